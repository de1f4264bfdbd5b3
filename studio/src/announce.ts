// What the program says: the status line, which screen readers hear, and messages that wait for an answer.

import { signal } from "@preact/signals";

export const status = signal("");

/** Says something in the status line. */
export function announce(text: string): void {
  status.value = text;
}

export interface Message {
  kind: "error" | "info";
  title: string;
  text: string;
  help: string | null;
  choices: { label: string; run: () => void }[];
}

/** The message that is open, or null. */
export const message = signal<Message | null>(null);

export function tell(news: Message): void {
  message.value = news;
  announce(`${news.title}: ${news.text}`);
}

export function dismiss(): void {
  message.value = null;
}
