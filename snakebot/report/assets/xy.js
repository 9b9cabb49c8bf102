/* Curves and clouds in a plane, with the nearest point named under the pointer. */
(() => {
  Page.builders.xy = (figure, box, spec) => {
    const hidden = new Set();
    let place = null;
    const finite = (v) => v !== null && isFinite(v);

    function extent(key) {
      let low = Infinity, high = -Infinity;
      for (const curve of spec.curves) for (const v of curve[key]) if (finite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
      return low > high ? [0, 1] : [low, high];
    }
    const pad = ([low, high], share) => {
      const room = (high - low) * share || Math.max(Math.abs(high), 1e-3) * share;
      return [low - room, high + room];
    };

    function draw(c, width, height) {
      const m = { left: 54, right: 10, top: 8, bottom: 36 };
      const w = width - m.left - m.right, h = height - m.top - m.bottom;
      let [x0, x1] = pad(extent("x"), 0.06), [y0, y1] = pad(extent("y"), 0.08);
      if (spec.diagonal) { x0 = y0 = Math.min(x0, y0); x1 = y1 = Math.max(x1, y1); }
      if (spec.equal) {
        const scale = Math.max((x1 - x0) / w, (y1 - y0) / h);
        const cx = (x0 + x1) / 2, cy = (y0 + y1) / 2;
        [x0, x1, y0, y1] = [cx - scale * w / 2, cx + scale * w / 2, cy - scale * h / 2, cy + scale * h / 2];
      }
      const px = (v) => m.left + (v - x0) / (x1 - x0) * w, py = (v) => m.top + (y1 - v) / (y1 - y0) * h;
      place = { px, py, m, w, h };
      c.lineWidth = 1;
      c.fillStyle = Page.color("muted");
      c.strokeStyle = Page.color("grid");
      c.textAlign = "center"; c.textBaseline = "top";
      for (const v of Page.ticks(x0, x1, w / 70)) { c.beginPath(); c.moveTo(px(v), m.top); c.lineTo(px(v), m.top + h); c.stroke(); c.fillText(Page.number(v), px(v), m.top + h + 5); }
      c.textAlign = "right"; c.textBaseline = "middle";
      for (const v of Page.ticks(y0, y1, h / 36)) { c.beginPath(); c.moveTo(m.left, py(v)); c.lineTo(m.left + w, py(v)); c.stroke(); c.fillText(Page.number(v), m.left - 6, py(v)); }
      c.textAlign = "center"; c.textBaseline = "alphabetic";
      c.fillText(spec.xAxis.label, m.left + w / 2, height - 4);
      c.save(); c.translate(11, m.top + h / 2); c.rotate(-Math.PI / 2); c.fillText(spec.yAxis.label, 0, 0); c.restore();
      c.save();
      c.beginPath(); c.rect(m.left, m.top, w, h); c.clip();
      if (spec.diagonal) {
        c.strokeStyle = Page.color("muted"); c.setLineDash([5, 4]);
        const from = Math.max(x0, y0), to = Math.min(x1, y1);
        c.beginPath(); c.moveTo(px(from), py(from)); c.lineTo(px(to), py(to)); c.stroke(); c.setLineDash([]);
      }
      spec.curves.forEach((curve, index) => {
        if (hidden.has(index)) return;
        c.strokeStyle = c.fillStyle = Page.color(curve.color);
        c.lineWidth = 1.5; c.lineJoin = "round";
        c.setLineDash(curve.dash ? [6, 4] : []);
        if (curve.mode === "points") {
          curve.x.forEach((x, i) => {
            if (!finite(x) || !finite(curve.y[i])) return;
            c.beginPath();
            if (index === 2) c.rect(px(x) - 4, py(curve.y[i]) - 4, 8, 8); else c.arc(px(x), py(curve.y[i]), index ? 6 : 4, 0, 7);
            if (index) c.stroke(); else c.fill();  // rings and squares leave what lies under them visible
          });
        } else {
          c.globalAlpha = 0.9; c.beginPath();
          let down = false;
          curve.x.forEach((x, i) => {
            const y = curve.y[i];
            if (!finite(x) || !finite(y)) { down = false; return; }
            if (down) c.lineTo(px(x), py(y)); else c.moveTo(px(x), py(y));
            down = true;
          });
          c.stroke(); c.globalAlpha = 1;
        }
        c.setLineDash([]);
      });
      c.restore();
      c.strokeStyle = Page.color("rule"); c.strokeRect(m.left, m.top, w, h);
    }

    const { element, paint } = Page.canvas(box, spec.height, draw);
    if (spec.curves.length > 1 || spec.curves[0]?.name) {
      Page.legend(box, spec.curves, (i, on) => { if (on) hidden.delete(i); else hidden.add(i); paint(); });
    }
    paint();

    const tip = document.createElement("div");
    tip.className = "tip"; tip.hidden = true; box.append(tip);
    element.addEventListener("pointermove", (event) => {
      if (!place) return;
      const at = element.getBoundingClientRect(), mx = event.clientX - at.left, my = event.clientY - at.top;
      let best = null;
      spec.curves.forEach((curve, index) => {
        if (hidden.has(index)) return;
        curve.x.forEach((x, i) => {
          if (!finite(x) || !finite(curve.y[i])) return;
          const distance = Math.hypot(place.px(x) - mx, place.py(curve.y[i]) - my);
          if (distance < (best ? best.distance : 18)) best = { distance, curve, i };
        });
      });
      tip.hidden = !best;
      if (!best) return;
      const { curve, i } = best, x = curve.x[i], y = curve.y[i];
      tip.textContent = `${curve.labels[i] || curve.name || ""} (${Page.number(x)}, ${Page.number(y)})`.trim();
      tip.style.left = Math.min(place.px(x) + 8, Math.max(box.clientWidth - tip.offsetWidth - 4, 0)) + "px";
      tip.style.top = Math.max(place.py(y) - 28, 0) + "px";
    });
    element.addEventListener("pointerleave", () => { tip.hidden = true; });
  };
})();
