/* Signals over one axis (uPlot): drag to zoom, double click or a button for all; charts of a group move together. */
(() => {
  const groups = new Map();

  function zoomGroup(chart, low, high) {
    for (const other of groups.get(chart.group) || [chart]) other.plot.setScale("x", { min: low, max: high });
  }

  /* One finger along the axis pans when zoomed in, two fingers zoom; the page still scrolls up and down. */
  function touch(chart) {
    const over = chart.plot.over;
    over.style.touchAction = "pan-y";
    let last = null;
    const read = (event) => {
      const left = over.getBoundingClientRect().left, xs = [...event.touches].map((t) => t.clientX - left);
      return { middle: xs.reduce((a, b) => a + b, 0) / xs.length, spread: xs.length > 1 ? Math.abs(xs[0] - xs[1]) : 0 };
    };
    over.addEventListener("touchstart", (event) => { last = read(event); }, { passive: true });
    over.addEventListener("touchmove", (event) => {
      const now = read(event), { min, max } = chart.plot.scales.x, width = over.clientWidth;
      if (last && last.spread > 8 && now.spread > 8) {
        const factor = Math.min(Math.max(last.spread / now.spread, 0.5), 2), at = min + (now.middle / width) * (max - min);
        zoomGroup(chart, Math.max(at - (at - min) * factor, chart.low), Math.min(at + (max - at) * factor, chart.high));
        if (event.cancelable) event.preventDefault();
      } else if (last && now.spread === 0 && last.spread === 0) {
        let shift = ((last.middle - now.middle) / width) * (max - min);
        shift = Math.min(Math.max(shift, chart.low - min), chart.high - max);
        zoomGroup(chart, min + shift, max + shift);
      }
      last = now;
    }, { passive: false });
  }

  Page.builders.line = (figure, box, spec) => {
    const chart = { group: spec.sync || figure.id, low: spec.x[0], high: spec.x[spec.x.length - 1] };
    const values = Page.legend(box, spec.lines.map((l) => ({ ...l, live: true })), (i, on) => chart.plot.setSeries(i + 1, { show: on }));
    const axis = (side, extra) => ({
      stroke: () => Page.color("muted"),
      grid: { stroke: () => Page.color("grid"), width: 1 },
      ticks: { stroke: () => Page.color("rule"), width: 1, size: 4 },
      font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
      label: side.label, labelSize: 18, labelGap: 2, ...extra,
    });
    const bands = (u) => {
      const context = u.ctx;
      context.save();
      context.fillStyle = Page.color("band");
      for (const band of spec.bands) {
        const left = Math.max(u.valToPos(band.start, "x", true), u.bbox.left);
        const right = Math.min(u.valToPos(band.end, "x", true), u.bbox.left + u.bbox.width);
        if (right <= left) continue;
        context.fillRect(left, u.bbox.top, right - left, u.bbox.height);
      }
      context.restore();
    };
    const show = (u) => values.forEach((value, i) => {
      const index = u.cursor.idx, y = index === null || index === undefined ? null : spec.lines[i].y[index];
      value.textContent = index === null || index === undefined ? "" : Page.number(y);
    });
    const options = {
      width: Math.max(box.clientWidth, 120), height: spec.height, legend: { show: false }, pxAlign: 0.5,
      cursor: { sync: { key: chart.group, setSeries: false }, drag: { x: true, y: false, setScale: false }, points: { size: 6 }, y: false },
      scales: { x: { time: false }, y: spec.yAxis.log ? { distr: 3 } : {} },
      axes: [
        axis(spec.xAxis, { size: 34, space: 60 }),
        axis(spec.yAxis, { size: 48, space: 24, values: (u, splits) => splits.map((v) => (v === null ? "" : Page.number(v))) }),
      ],
      series: [{}, ...spec.lines.map((line) => ({
        label: line.name, stroke: () => Page.color(line.color), width: line.width, dash: line.dash ? [6, 4] : undefined,
        points: { show: line.points, size: 6 }, spanGaps: false,
      }))],
      hooks: {
        drawClear: [bands], setCursor: [show],
        setSelect: [(u) => {
          if (u.select.width > 3) zoomGroup(chart, u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
          u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
        }],
      },
    };
    chart.plot = new uPlot(options, [spec.x, ...spec.lines.map((l) => l.y)], box);
    chart.plot.over.addEventListener("dblclick", () => zoomGroup(chart, chart.low, chart.high));
    touch(chart);
    if (!groups.has(chart.group)) groups.set(chart.group, []);
    groups.get(chart.group).push(chart);
    if (chart.high > chart.low) {
      const bar = document.createElement("div");
      bar.className = "zoom";
      const button = (text, action) => {
        const b = document.createElement("button");
        b.type = "button"; b.textContent = text; b.addEventListener("click", action); bar.append(b);
      };
      for (const band of spec.bands.slice(0, 1)) if (band.label) button(band.label, () => zoomGroup(chart, band.start, band.end));
      button("all", () => zoomGroup(chart, chart.low, chart.high));
      figure.querySelector("figcaption").append(bar);
    }
    new ResizeObserver(() => {
      if (box.clientWidth && box.clientWidth !== chart.plot.width) chart.plot.setSize({ width: box.clientWidth, height: spec.height });
    }).observe(box);
    Page.redraws.add(() => chart.plot.redraw(false, true));
  };
})();
