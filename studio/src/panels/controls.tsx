// The controls that all panels are made of. Each has a label that screen readers say.

import { useId, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import * as actions from "../actions";
import { keyLabel } from "../keys";
import { Icon, type IconName } from "./icons";

const IS_MAC = typeof navigator !== "undefined" && /Mac|iPhone|iPad/.test(navigator.userAgent);

export function keyHint(keys: readonly string[] | undefined): string {
  return keys?.[0] ? keyLabel(keys[0], IS_MAC) : "";
}

export function Section(props: { title: string; id: string; open?: boolean; children: ComponentChildren }) {
  return (
    <details class="section" open={props.open ?? false} data-testid={`section-${props.id}`}>
      <summary>{props.title}</summary>
      <div class="section-body">{props.children}</div>
    </details>
  );
}

/** A button that runs an action, as its icon or as its words. */
export function ActionButton(props: { name: string; icon?: IconName; label?: string; class?: string }) {
  const action = actions.list().find((a) => a.name === props.name);
  if (!action) return null;
  const hint = keyHint(action.keys);
  const isOn = action.on?.();
  const detail = action.detail?.();
  const words = detail ? `${action.label}: ${detail}` : action.label;
  return (
    <button
      type="button"
      class={`${props.icon ? "icon-button" : "button"} ${props.class ?? ""}`}
      aria-label={props.icon ? action.label : undefined}
      aria-pressed={isOn === undefined ? undefined : isOn}
      aria-keyshortcuts={action.keys?.[0]?.replace("Mod", "Control")}
      title={hint ? `${words} (${hint})` : words}
      disabled={action.enabled?.() === false}
      data-testid={action.name}
      onClick={() => actions.run(props.name)}
    >
      {props.icon ? <Icon name={props.icon} /> : (props.label ?? action.label)}
    </button>
  );
}

export function Button(props: {
  children: ComponentChildren;
  onClick: () => void;
  testid?: string;
  title?: string;
  disabled?: boolean;
  kind?: "primary" | "quiet";
  autofocus?: boolean;
}) {
  return (
    <button
      type="button"
      class={`button ${props.kind ?? ""}`}
      autofocus={props.autofocus}
      onClick={props.onClick}
      disabled={props.disabled}
      title={props.title}
      data-testid={props.testid}
    >
      {props.children}
    </button>
  );
}

interface SliderProps {
  label: string;
  testid: string;
  value: number;
  min: number;
  max: number;
  step: number;
  unit?: string;
  /** Equal ways of the slider are equal factors. */
  scale?: "log";
  disabled?: boolean;
  /** How the number beside it is written. */
  format?: (value: number) => string;
  onInput: (value: number) => void;
  /** The slide is over. */
  onEnd?: () => void;
}

/** A slider, and a field for the number itself. */
export function Slider(props: SliderProps) {
  const id = useId();
  // What is being typed stays, though answers of the kernel draw the panel anew.
  const [draft, setDraft] = useState<string | null>(null);
  const format = props.format ?? String;
  const isLog = props.scale === "log";
  const set = (text: string, fromSlider = false) => {
    let value = Number(text);
    if (fromSlider && isLog) value = Number((10 ** value).toPrecision(2));
    if (text.trim() !== "" && Number.isFinite(value)) props.onInput(Math.min(props.max, Math.max(props.min, value)));
  };
  return (
    <div class="field">
      <label for={id}>{props.label}</label>
      <div class="slider">
        <input
          id={id}
          type="range"
          min={isLog ? Math.log10(props.min) : props.min}
          max={isLog ? Math.log10(props.max) : props.max}
          step={isLog ? 0.1 : props.step}
          value={isLog ? Math.log10(props.value) : props.value}
          disabled={props.disabled}
          aria-valuetext={`${format(props.value)}${props.unit ? ` ${props.unit}` : ""}`}
          data-testid={props.testid}
          onInput={(e) => set(e.currentTarget.value, true)}
          onChange={() => props.onEnd?.()}
        />
        <input
          class="number"
          type="text"
          inputMode="decimal"
          aria-label={`${props.label}, number`}
          value={draft ?? format(props.value)}
          disabled={props.disabled}
          data-testid={`${props.testid}-number`}
          onInput={(e) => setDraft(e.currentTarget.value)}
          onBlur={() => setDraft(null)}
          onChange={(e) => {
            setDraft(null);
            set(e.currentTarget.value);
            e.currentTarget.value = format(props.value);
            props.onEnd?.();
          }}
        />
      </div>
    </div>
  );
}

export function Choice<T extends string>(props: {
  label: string;
  testid: string;
  value: T;
  options: readonly (readonly [T, string])[];
  onChange: (value: T) => void;
  disabled?: boolean;
}) {
  const id = useId();
  return (
    <div class="field row">
      <label for={id}>{props.label}</label>
      <select
        id={id}
        value={props.value}
        disabled={props.disabled}
        data-testid={props.testid}
        onChange={(e) => {
          const chosen = e.currentTarget.value as T;
          // What is shown follows from the state, also where a choice is only a way to do something.
          e.currentTarget.value = props.value;
          props.onChange(chosen);
        }}
      >
        {props.options.map(([value, text]) => (
          <option key={value} value={value} selected={value === props.value}>
            {text}
          </option>
        ))}
      </select>
    </div>
  );
}

/** A few choices side by side. */
export function Segmented<T extends string>(props: {
  label: string;
  testid: string;
  value: T;
  options: readonly (readonly [T, string])[];
  onChange: (value: T) => void;
  hideLabel?: boolean;
}) {
  const name = useId();
  return (
    <fieldset class="segmented" data-testid={props.testid}>
      <legend class={props.hideLabel ? "unseen" : undefined}>{props.label}</legend>
      <div>
        {props.options.map(([value, text]) => (
          <label key={value}>
            <input
              type="radio"
              name={name}
              value={value}
              checked={value === props.value}
              data-testid={`${props.testid}-${value}`}
              onChange={() => props.onChange(value)}
            />
            <span>{text}</span>
          </label>
        ))}
      </div>
    </fieldset>
  );
}

export function Switch(props: {
  label: string;
  testid: string;
  on: boolean;
  onChange: (on: boolean) => void;
  disabled?: boolean;
  title?: string;
}) {
  return (
    <label class="switch" title={props.title}>
      <input
        type="checkbox"
        role="switch"
        checked={props.on}
        disabled={props.disabled}
        data-testid={props.testid}
        onChange={(e) => props.onChange(e.currentTarget.checked)}
      />
      <span>{props.label}</span>
    </label>
  );
}

/** A number to type. `commit` gets it when it is complete and different. */
export function NumberField(props: {
  label: string;
  testid: string;
  value: number;
  hideLabel?: boolean;
  min?: number;
  max?: number;
  disabled?: boolean;
  format?: (value: number) => string;
  onCommit: (value: number) => void;
}) {
  const id = useId();
  const format = props.format ?? ((x) => String(+x.toPrecision(6)));
  const [wrong, setWrong] = useState(false);
  const [draft, setDraft] = useState<string | null>(null);
  return (
    <div class="field row">
      <label for={id} class={props.hideLabel ? "unseen" : undefined}>
        {props.label}
      </label>
      <input
        id={id}
        class="number"
        type="text"
        inputMode="decimal"
        value={draft ?? format(props.value)}
        disabled={props.disabled}
        aria-invalid={wrong}
        data-testid={props.testid}
        onInput={(e) => setDraft(e.currentTarget.value)}
        onBlur={() => {
          if (!wrong) setDraft(null);
        }}
        onChange={(e) => {
          const text = e.currentTarget.value.trim().replace(",", ".");
          const value = Number(text);
          const isGood =
            text !== "" &&
            Number.isFinite(value) &&
            value >= (props.min ?? -Infinity) &&
            value <= (props.max ?? Infinity);
          setWrong(!isGood);
          if (isGood) setDraft(null);
          if (isGood && text !== format(props.value)) props.onCommit(value);
        }}
      />
    </div>
  );
}
