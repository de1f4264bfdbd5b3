// Keys as text: `Mod+Shift+Z`, where Mod is Ctrl, and Cmd on a Mac.

export interface Pressed {
  key: string;
  ctrlKey: boolean;
  metaKey: boolean;
  altKey: boolean;
  shiftKey: boolean;
}

/** The key of an event, in the form that actions list. */
export function keyOf(event: Pressed): string {
  let { key } = event;
  if (key === " ") key = "Space";
  const isLetter = /^\p{L}$/u.test(key);
  if (isLetter) key = key.toUpperCase();
  let text = "";
  if (event.ctrlKey || event.metaKey) text += "Mod+";
  if (event.altKey) text += "Alt+";
  // Shift is part of a sign like `?` or `+` already, which other keyboards have elsewhere.
  if (event.shiftKey && (isLetter || key.length > 1)) text += "Shift+";
  return text + key;
}

/** Whether typing belongs to what has the focus, rather than to the studio. */
export function isTyping(target: EventTarget | null, key: string): boolean {
  const element = target as Partial<HTMLElement> | null;
  const tag = element?.tagName;
  if (!tag) return false;
  if (element.isContentEditable === true || tag === "TEXTAREA") return true;
  if (tag === "SELECT") return !key.includes("Mod+");
  if (tag === "INPUT") {
    const type = (element as Partial<HTMLInputElement>).type ?? "text";
    if (["checkbox", "radio", "button"].includes(type)) return key === "Space" || key.startsWith("Arrow");
    if (type === "range") return /^(Arrow|Home|End|Page)/.test(key);
    return !key.startsWith("Mod+") || ["Mod+Z", "Mod+A", "Mod+C", "Mod+V", "Mod+X"].includes(key);
  }
  if (tag === "BUTTON" || tag === "SUMMARY" || tag === "A") return key === "Space" || key === "Enter";
  return false;
}

const SIGNS: Record<string, string> = {
  ArrowLeft: "←",
  ArrowRight: "→",
  ArrowUp: "↑",
  ArrowDown: "↓",
  Escape: "Esc",
};

/** A key as people read it. */
export function keyLabel(key: string, isMac = false): string {
  return key
    .split("+")
    .map((part) => (part === "Mod" ? (isMac ? "⌘" : "Ctrl") : (SIGNS[part] ?? part)))
    .join(isMac ? "" : "+")
    .replace(/\+$/, "+");
}
