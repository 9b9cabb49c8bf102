/* What the parts of the page share: elements, numbers as they are shown, the colours of the scheme. */
export const $ = (id) => document.getElementById(id);

export function put(element, value) {
  if (element.textContent !== value) element.textContent = value;
}

export function number(value, digits) {
  return value === null || value === undefined || !isFinite(value) ? "–" : value.toFixed(digits).replace("-", "−");
}

/* Asking for a style makes the browser work out all of them first: each colour is asked for once a scheme. */
let colors = {};
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colors = {}; });
export const color = (name) => (colors[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
