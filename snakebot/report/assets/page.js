/* Theme, colours, redraw: what every figure on the page shares. */
"use strict";
const Page = (() => {
  const root = document.documentElement;
  const wanted = matchMedia("(prefers-color-scheme: dark)");
  const redraws = new Set();
  const builders = {};
  let chosen = null;
  try { chosen = localStorage.getItem("snakebot-theme"); } catch { /* a file page may have no storage */ }

  function apply() {
    root.dataset.theme = chosen || (wanted.matches ? "dark" : "light");
    redraws.forEach((redraw) => redraw());
  }
  wanted.addEventListener("change", apply);

  function color(name) {
    return getComputedStyle(root).getPropertyValue("--" + name).trim() || "#888";
  }

  /* 1-2-5 steps for about `count` marks between two values */
  function ticks(low, high, count) {
    const rough = (high - low) / Math.max(count, 1);
    if (!(rough > 0)) return [low];
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999);
    const out = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) out.push(k * step);
    return out;
  }

  function number(value, digits = 3) {
    if (value === null || value === undefined || !isFinite(value)) return "–";
    return (+value.toPrecision(Math.max(digits, 1) + 1)).toString().replace("-", "−");
  }

  /* A canvas as wide as its box, sharp on every screen; `draw(context, width, height)` is called when it must be. */
  function canvas(box, height, draw) {
    const element = document.createElement("canvas");
    box.append(element);
    const paint = () => {
      const width = box.clientWidth, ratio = window.devicePixelRatio || 1;
      if (!width) return;
      if (element.width !== Math.round(width * ratio) || element.height !== Math.round(height * ratio)) {
        element.width = Math.round(width * ratio);
        element.height = Math.round(height * ratio);
        element.style.height = height + "px";
      }
      const context = element.getContext("2d");
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      context.font = "12px system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
      draw(context, width, height);
    };
    new ResizeObserver(paint).observe(box);
    redraws.add(paint);
    return { element, paint };
  }

  /* A legend whose entries switch their line off and on. Text goes in as text, never as markup. */
  function legend(box, entries, toggle) {
    const list = document.createElement("div");
    list.className = "legend";
    const values = entries.map((entry, index) => {
      const button = document.createElement("button"), mark = document.createElement("i"), value = document.createElement("b");
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      mark.style.setProperty("--c", `var(--${entry.color})`);
      if (entry.dash) mark.className = "dash";
      button.append(mark, document.createTextNode(entry.name));
      if (entry.live) button.append(value);
      button.addEventListener("click", () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(on));
        toggle(index, on);
      });
      list.append(button);
      return value;
    });
    box.before(list);
    return values;
  }

  function start() {
    const data = JSON.parse(document.getElementById("data").textContent);
    const build = (figure) => {
      const spec = data.charts[figure.id];
      if (!spec || figure.dataset.built) return;
      figure.dataset.built = "yes";
      builders[spec.kind](figure, figure.querySelector(".plot"), spec);
    };
    document.querySelectorAll("figure.chart").forEach((figure) => {
      const fold = figure.closest("details");
      if (fold && !fold.open) fold.addEventListener("toggle", () => build(figure), { once: true });
      else build(figure);
    });
    document.getElementById("theme").addEventListener("click", () => {
      chosen = root.dataset.theme === "dark" ? "light" : "dark";
      try { localStorage.setItem("snakebot-theme", chosen); } catch { /* as above */ }
      apply();
    });
  }

  apply();
  return { color, ticks, number, canvas, legend, start, builders, redraws };
})();
