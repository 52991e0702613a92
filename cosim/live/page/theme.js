// Colours of the style sheet as canvases need them, renewed when the system goes dark or light.

const NAMES = [
  "ground", "raised", "ink", "soft", "line", "faint", "focus", "slide", "loss",
  "user-0", "user-1", "user-2", "user-3",
];

export const colours = {};
const listeners = [];

function read() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) colours[name] = style.getPropertyValue(`--${name}`).trim();
}

/** Call back when colours have changed. */
export function onTheme(listener) {
  listeners.push(listener);
}

export const user = (number) => colours[`user-${number % 4}`];

read();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  read();
  for (const listener of listeners) listener();
});
