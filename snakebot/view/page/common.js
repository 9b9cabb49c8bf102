/* What the parts of the page share: elements, numbers as they are shown, the colours of the scheme. */
export const $ = (id) => document.getElementById(id);

export function put(element, value) {
  if (element.textContent !== value) element.textContent = value;
}

export function number(value, digits) {
  if (value === null || value === undefined || !isFinite(value)) return "–";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−"); // no -0.0
}

/* Asking for a style makes the browser work out all of them first: each colour is asked for once a scheme. */
let colors = {};
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colors = {}; });
export const color = (name) => (colors[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
