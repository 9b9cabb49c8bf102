/* Bodies over ground: links, the way they came, a scale; play, pause, scrub, follow. */
(() => {
  /* Ends of every link from the centre of mass, the mean link angle and the joint angles. */
  function ends(snake, i) {
    const joints = snake.joints[i], l = snake.halfLength, angles = [0];
    for (const phi of joints) angles.push(angles[angles.length - 1] + phi);
    const mean = angles.reduce((a, b) => a + b, 0) / angles.length;
    const points = [[0, 0]], centres = [];
    for (const relative of angles) {
      const a = relative - mean + snake.heading[i], [x, y] = points[points.length - 1];
      points.push([x + 2 * l * Math.cos(a), y + 2 * l * Math.sin(a)]);
      centres.push([x + l * Math.cos(a), y + l * Math.sin(a)]);
    }
    const cx = centres.reduce((s, p) => s + p[0], 0) / centres.length, cy = centres.reduce((s, p) => s + p[1], 0) / centres.length;
    return points.map(([x, y]) => [x - cx + snake.x[i], y - cy + snake.y[i]]);
  }

  Page.builders.snake = (figure, box, spec) => {
    const t = spec.t, last = t.length - 1, hidden = new Set();
    const known = (s, i) => s.x[i] !== null && s.y[i] !== null && s.heading[i] !== null && s.joints[i].every((v) => v !== null);
    const reach = Math.max(...spec.snakes.map((s) => s.halfLength * (s.joints[0].length + 1)));
    let time = t[0], playing = false, follow, before = 0;

    function bounds(indices) {
      let b = [Infinity, -Infinity, Infinity, -Infinity];
      for (const s of spec.snakes) for (const i of indices) if (known(s, i)) b = [Math.min(b[0], s.x[i]), Math.max(b[1], s.x[i]), Math.min(b[2], s.y[i]), Math.max(b[3], s.y[i])];
      return b[0] > b[1] ? [0, 0, 0, 0] : b;
    }
    const whole = bounds([...t.keys()]);
    follow = Math.max(whole[1] - whole[0], whole[3] - whole[2]) > 5 * reach;  // else the body would be a speck
    const index = () => {
      let a = 0, b = last;
      while (b - a > 1) { const m = (a + b) >> 1; if (t[m] <= time) a = m; else b = m; }
      return Math.abs(t[b] - time) < Math.abs(t[a] - time) ? b : a;
    };

    function draw(c, width, height) {
      const i = index(), b = follow ? bounds([i]) : whole;
      const room = follow ? 3.2 : 2.3, w = b[1] - b[0] + room * reach, h = b[3] - b[2] + 1.5 * reach;
      const scale = Math.min(width / w, height / h), cx = (b[0] + b[1]) / 2, cy = (b[2] + b[3]) / 2;
      const px = (x) => width / 2 + (x - cx) * scale, py = (y) => height / 2 - (y - cy) * scale;
      const left = cx - width / 2 / scale, right = cx + width / 2 / scale, low = cy - height / 2 / scale, high = cy + height / 2 / scale;
      const marks = Page.ticks(left, right, width / 80), step = marks.length > 1 ? marks[1] - marks[0] : 1;
      c.strokeStyle = Page.color("grid"); c.lineWidth = 1;
      for (let k = Math.ceil(left / step); k * step <= right; k++) { c.beginPath(); c.moveTo(px(k * step), 0); c.lineTo(px(k * step), height); c.stroke(); }
      for (let k = Math.ceil(low / step); k * step <= high; k++) { c.beginPath(); c.moveTo(0, py(k * step)); c.lineTo(width, py(k * step)); c.stroke(); }
      spec.snakes.forEach((s, n) => {
        if (hidden.has(n)) return;
        const color = Page.color(s.color);
        c.strokeStyle = color; c.lineWidth = 1.5; c.globalAlpha = 0.25; c.lineJoin = "round";
        const way = (from, to) => {
          c.beginPath();
          let down = false;
          for (let k = from; k <= to; k++) { if (!known(s, k)) { down = false; continue; } if (down) c.lineTo(px(s.x[k]), py(s.y[k])); else c.moveTo(px(s.x[k]), py(s.y[k])); down = true; }
          c.stroke();
        };
        way(0, last); c.globalAlpha = 0.9; way(0, i); c.globalAlpha = 1;
        if (!known(s, i)) return;
        const points = ends(s, i), thick = Math.max(4, Math.min(s.halfLength * scale * 0.5, 14));
        c.lineCap = "round";
        for (let k = 0; k + 1 < points.length; k++) {
          c.globalAlpha = 0.55 + 0.45 * (k + 1) / (points.length - 1);
          c.lineWidth = thick; c.strokeStyle = color;
          c.beginPath(); c.moveTo(px(points[k][0]), py(points[k][1])); c.lineTo(px(points[k + 1][0]), py(points[k + 1][1])); c.stroke();
        }
        c.globalAlpha = 1;
        c.fillStyle = Page.color("card");
        for (const [x, y] of points.slice(1, -1)) { c.beginPath(); c.arc(px(x), py(y), thick * 0.32, 0, 7); c.fill(); }
        c.fillStyle = Page.color("fg"); c.textAlign = "center"; c.textBaseline = "middle";
        const label = (p, q, text) => {
          const d = Math.hypot(p[0] - q[0], p[1] - q[1]) || 1, out = thick / 2 + 9;
          c.fillText(text, px(p[0]) + (p[0] - q[0]) / d * out, py(p[1]) - (p[1] - q[1]) / d * out);
        };
        label(points[0], points[1], "1");
        label(points[points.length - 1], points[points.length - 2], String(points.length - 1));
      });
      c.strokeStyle = Page.color("fg"); c.fillStyle = Page.color("fg"); c.lineWidth = 2; c.textAlign = "left"; c.textBaseline = "bottom";
      c.beginPath(); c.moveTo(12, height - 12); c.lineTo(12 + step * scale, height - 12); c.stroke();
      c.fillText(step >= 1 ? `${Page.number(step)} m` : `${Page.number(step * 100)} cm`, 12, height - 16);
    }

    const { paint } = Page.canvas(box, spec.height, draw);
    Page.legend(box, spec.snakes, (n, on) => { if (on) hidden.delete(n); else hidden.add(n); paint(); });

    const bar = document.createElement("div"), play = document.createElement("button"), slide = document.createElement("input");
    const clock = document.createElement("output"), pace = document.createElement("select"), view = document.createElement("button");
    bar.className = "bar";
    play.type = view.type = "button"; play.className = "play";
    slide.type = "range"; slide.min = t[0]; slide.max = t[last]; slide.step = "any"; slide.setAttribute("aria-label", "time in s");
    pace.setAttribute("aria-label", "speed of playing");
    for (const p of [0.25, 0.5, 1, 2, 4]) { const o = document.createElement("option"); o.value = p; o.textContent = p + "×"; o.selected = p === 1; pace.append(o); }
    bar.append(play, slide, clock, pace, view);
    box.after(bar);

    function show() {
      slide.value = time;
      clock.textContent = `${time.toFixed(2)} / ${t[last].toFixed(1)} s`;
      play.textContent = playing ? "❚❚ pause" : "▶ play";
      view.textContent = follow ? "whole way" : "follow";
      paint();
    }
    function frame(now) {
      if (!playing) return;
      time += Math.min((now - before) / 1000, 0.1) * pace.value;
      before = now;
      if (time >= t[last]) { time = t[last]; playing = false; }
      show();
      requestAnimationFrame(frame);
    }
    play.addEventListener("click", () => {
      playing = !playing;
      if (playing && time >= t[last]) time = t[0];
      before = performance.now();
      show();
      if (playing) requestAnimationFrame(frame);
    });
    slide.addEventListener("input", () => { time = +slide.value; show(); });
    view.addEventListener("click", () => { follow = !follow; show(); });
    time = t[0] + (t[last] - t[0]) * 0.5;  // a still picture shows the body in motion
    show();
  };
})();
