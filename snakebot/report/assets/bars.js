/* Horizontal bars, a group a category, with intervals where they are known. */
(() => {
  /* A name that does not fit, in two lines: broken at the space that leaves them most alike. */
  function folded(name, fits) {
    const spaces = [...name.matchAll(/ /g)].map((found) => found.index);
    if (fits(name) || !spaces.length) return [name];
    const at = spaces.reduce((best, i) => (Math.abs(i - name.length / 2) < Math.abs(best - name.length / 2) ? i : best));
    return [name.slice(0, at), name.slice(at + 1)];
  }

  Page.builders.bars = (figure, box, spec) => {
    function draw(c, width, height) {
      const names = spec.categories, count = Math.max(spec.bars.length, 1);
      const widest = Math.max(...names.map((n) => c.measureText(n).width), 20);
      const m = { left: Math.min(widest + 12, width * 0.42), right: 52, top: 4, bottom: 30 };
      const w = width - m.left - m.right, row = (height - m.top - m.bottom) / Math.max(names.length, 1);
      let low = 0, high = 0;
      for (const bar of spec.bars) for (const list of [bar.values, bar.low, bar.high]) for (const v of list) if (v !== null && isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
      if (low === high) high = 1;
      const px = (v) => m.left + (v - low) / (high - low) * w;
      c.strokeStyle = Page.color("grid"); c.fillStyle = Page.color("muted"); c.textAlign = "center"; c.textBaseline = "top";
      for (const v of Page.ticks(low, high, w / 70)) { c.beginPath(); c.moveTo(px(v), m.top); c.lineTo(px(v), height - m.bottom); c.stroke(); c.fillText(Page.number(v), px(v), height - m.bottom + 3); }
      c.textBaseline = "alphabetic"; c.fillText(spec.xAxis.label, m.left + w / 2, height - 5);
      names.forEach((name, i) => {
        c.fillStyle = Page.color("fg"); c.textAlign = "right"; c.textBaseline = "middle";
        const lines = row < 28 ? [name] : folded(name, (text) => c.measureText(text).width <= m.left - 10);
        lines.forEach((line, k) => {
          let text = line;
          while (text.length > 2 && c.measureText(text).width > m.left - 10) text = text.slice(0, -2) + "…";
          c.fillText(text, m.left - 8, m.top + row * (i + 0.5) + 14 * (k - (lines.length - 1) / 2));
        });
        spec.bars.forEach((bar, k) => {
          const thick = (row - 8) / count, y = m.top + row * i + 4 + thick * k, v = bar.values[i];
          if (v === null || v === undefined || !isFinite(v)) return;
          c.fillStyle = Page.color(bar.color);
          c.fillRect(Math.min(px(0), px(v)), y + 1, Math.max(Math.abs(px(v) - px(0)), 1), thick - 2);
          const a = bar.low[i], b = bar.high[i];
          let end = px(Math.max(v, 0));
          if (a !== undefined && a !== null && b !== undefined && b !== null) {
            c.strokeStyle = Page.color("fg"); c.lineWidth = 1.5;
            c.beginPath(); c.moveTo(px(a), y + thick / 2); c.lineTo(px(b), y + thick / 2); c.stroke(); c.lineWidth = 1;
            end = Math.max(end, px(b));
          }
          c.fillStyle = Page.color("muted"); c.textAlign = "left"; c.fillText(Page.number(v, 2), end + 5, y + thick / 2);
        });
      });
    }
    const { paint } = Page.canvas(box, spec.height, draw);
    if (spec.bars.length > 1) Page.legend(box, spec.bars, () => {});
    paint();
  };
})();
