/* The body over the ground, the way it came, a scale; without a pose about its own centre. */
import { $, color, number, put } from "./common.js";

const SCALE_STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
const TRAIL = 3000; // positions kept
const FILLED = 0.8; // of the picture, by the body: its way leads through the middle

export class Body {
  constructor(canvas, follow) {
    this.canvas = canvas;
    this.follow = true;
    follow.addEventListener("click", () => {
      this.follow = !this.follow;
      follow.setAttribute("aria-pressed", String(this.follow));
      if (this.last) this.draw(...this.last);
    });
    new ResizeObserver(() => { if (this.last) this.draw(...this.last); }).observe(canvas);
  }

  begin(about) {
    this.half = about.half_length_m || 0.08;
    this.links = about.joints + 1;
    this.trail = [];
    this.bounds = null;
    this.last = null;
  }

  /* Ends of every link, metres, from the centre of mass, the mean link angle and the joint angles (rad). */
  ends(joints, x, y, heading) {
    const angles = [0];
    for (const phi of joints) angles.push(angles[angles.length - 1] + phi);
    const mean = angles.reduce((a, b) => a + b, 0) / angles.length, points = [[0, 0]], centres = [];
    for (const relative of angles) {
      const a = relative - mean + heading, [px, py] = points[points.length - 1];
      points.push([px + 2 * this.half * Math.cos(a), py + 2 * this.half * Math.sin(a)]);
      centres.push([px + this.half * Math.cos(a), py + this.half * Math.sin(a)]);
    }
    const cx = centres.reduce((s, p) => s + p[0], 0) / centres.length, cy = centres.reduce((s, p) => s + p[1], 0) / centres.length;
    return points.map(([px, py]) => [px - cx + x, py - cy + y]);
  }

  draw(row, pose) {
    this.last = [row, pose];
    const ratio = devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) return;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const c = this.canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    const angles = (list) => list.map((v) => (v === null ? 0 : v * Math.PI / 180));
    const known = (list) => Boolean(list) && list.some((v) => v !== null);
    const [, set, executed, measured] = row || [];
    const wanted = [set, executed].find(known), seen = [measured, executed, set].find(known);
    const placed = pose && pose[0] !== null && pose[2] !== null;
    const [x, y, heading] = placed ? pose : [0, 0, 0];
    if (placed) {
      const end = this.trail[this.trail.length - 1];
      if (!end || Math.hypot(end[0] - x, end[1] - y) > 0.002) this.trail.push([x, y]);
      if (this.trail.length > TRAIL) this.trail = this.trail.filter((_, i) => i % 2 === 0);
    }
    const body = this.ends(seen ? angles(seen) : Array(this.links - 1).fill(0), x, y, heading);
    const reach = this.half * this.links;
    let view = [x, y, 2.6 * reach, 1.5 * reach];
    if (!this.follow && placed) {
      const b = this.bounds || (this.bounds = [x, x, y, y]);
      b[0] = Math.min(b[0], x); b[1] = Math.max(b[1], x); b[2] = Math.min(b[2], y); b[3] = Math.max(b[3], y);
      view = [(b[0] + b[1]) / 2, (b[2] + b[3]) / 2, b[1] - b[0] + 2.4 * reach, b[3] - b[2] + 1.5 * reach];
    }
    const span = (k) => Math.max(...body.map((p) => p[k])) - Math.min(...body.map((p) => p[k])) || reach;
    // Of a steady size while it moves, but whole whichever way it lies.
    const scale = Math.min(width / view[2], height / view[3], FILLED * width / span(0), FILLED * height / span(1));
    const px = (p) => [width / 2 + (p[0] - view[0]) * scale, height / 2 - (p[1] - view[1]) * scale];
    this.grid(c, width, height, view, scale, px);
    if (this.trail.length > 1) {
      c.strokeStyle = color("muted"); c.globalAlpha = 0.5; c.lineWidth = 1.5;
      this.line(c, this.trail.map(px)); c.globalAlpha = 1;
    }
    c.lineJoin = c.lineCap = "round";
    c.strokeStyle = color("command"); c.globalAlpha = 0.45; c.lineWidth = 2; c.setLineDash([4, 5]);
    if (wanted) this.line(c, this.ends(angles(wanted), x, y, heading).map(px));
    c.setLineDash([]); c.globalAlpha = 1;
    const points = body.map(px), thick = Math.max(4, Math.min(16, 0.35 * this.half * scale));
    c.strokeStyle = color("measured"); c.lineWidth = thick;
    this.line(c, points);
    c.fillStyle = color("card");
    for (const [jx, jy] of points.slice(1, -1)) { c.beginPath(); c.arc(jx, jy, thick * 0.28, 0, 7); c.fill(); }
    // The free end of link 1 is marked, from which joints are counted: the tail of a gait with a positive beta.
    c.fillStyle = color("measured"); c.beginPath(); c.arc(points[0][0], points[0][1], thick * 0.75, 0, 7); c.fill();
    const label = placed ? `x ${number(x, 3)} m  y ${number(y, 3)} m  heading ${number(heading * 180 / Math.PI, 0)}°${pose[3] === null ? "" : `  ${number(pose[3], 3)} m/s`}`
      : "no pose: drawn about its own centre";
    put($("pose"), label);
  }

  line(c, points) {
    c.beginPath();
    points.forEach(([x, y], i) => (i ? c.lineTo(x, y) : c.moveTo(x, y)));
    c.stroke();
  }

  grid(c, width, height, view, scale, px) {
    const step = SCALE_STEPS.find((s) => s * scale > 55) || 10;
    c.strokeStyle = color("grid"); c.lineWidth = 1;
    const left = view[0] - width / scale / 2, top = view[1] + height / scale / 2;
    for (let gx = Math.ceil(left / step) * step; gx < left + width / scale; gx += step) { const [a] = px([gx, 0]); c.beginPath(); c.moveTo(a, 0); c.lineTo(a, height); c.stroke(); }
    for (let gy = Math.floor(top / step) * step; gy > top - height / scale; gy -= step) { const [, b] = px([0, gy]); c.beginPath(); c.moveTo(0, b); c.lineTo(width, b); c.stroke(); }
    c.fillStyle = c.strokeStyle = color("muted"); c.font = "12px system-ui, sans-serif"; c.textAlign = "left";
    c.beginPath(); c.moveTo(12, 16); c.lineTo(12 + step * scale, 16); c.stroke();
    c.fillText(`${step} m`, 16, 30);
  }
}
