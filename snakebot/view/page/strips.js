/* Strip charts of the last 30 s, one a joint: set-point, executed, measured. */
import { color } from "./common.js";

const KEPT_S = 30;
const HEIGHT = 144, NAME = 16; // px: of a chart, and of the line above it that has its joint's name

export class Strips {
  constructor(box) {
    this.rows = [];
    this.box = box;
    this.plots = [];
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    new ResizeObserver(() => this.fit()).observe(box);
  }

  /* Another run: the charts stay where the robot has as many joints. */
  begin(about) {
    this.rows = [];
    if (about.joints === this.joints) return;
    this.joints = about.joints;
    this.build();
  }

  build() {
    for (const plot of this.plots) plot.destroy();
    this.box.replaceChildren();
    this.plots = Array.from({ length: this.joints }, (_, joint) => {
      const cell = document.createElement("div");
      this.box.append(cell);
      const axis = { stroke: color("muted"), grid: { stroke: color("grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui, sans-serif" };
      return new uPlot({
        width: Math.max(cell.clientWidth, 100), height: HEIGHT, padding: [NAME, null, null, null], title: "", cursor: { show: false }, legend: { show: false },
        scales: { x: { time: false } },
        axes: [{ ...axis, size: 26, values: (_, marks) => marks.map((m) => `${m} s`) }, { ...axis, size: 40, space: 24 }],
        series: [{}, { label: "set", stroke: color("command"), dash: [4, 3], width: 1.5 }, { label: "executed", stroke: color("applied"), width: 1.5 }, { label: "measured", stroke: color("measured"), width: 2 }],
        hooks: { draw: [(plot) => {
          const c = plot.ctx;
          c.save(); c.fillStyle = color("muted"); c.font = `${12 * devicePixelRatio}px system-ui, sans-serif`; c.textAlign = "left"; c.textBaseline = "top";
          c.fillText(`joint ${joint + 1}`, plot.bbox.left, plot.bbox.top - NAME * devicePixelRatio); c.restore();
        }] },
      }, [[], [], [], []], cell);
    });
  }

  fit() {
    for (const plot of this.plots) {
      const width = plot.root.parentElement.clientWidth;
      if (width && width !== plot.width) plot.setSize({ width, height: HEIGHT });
    }
  }

  add(rows) {
    this.rows.push(...rows);
    const newest = this.newest();
    if (!newest) return;
    let old = 0;
    while (this.rows[old][0] < newest[0] - KEPT_S) old++;
    if (old) this.rows.splice(0, old);
  }

  clear() {
    this.rows = [];
  }

  newest() {
    return this.rows.length ? this.rows[this.rows.length - 1] : null;
  }

  /* One job a chart: a click waits for one of them at most. */
  jobs() {
    return this.plots.map((plot, joint) => () => this.draw(plot, joint));
  }

  draw(plot, joint) {
    const last = this.newest();
    if (!last) return;
    const data = [this.rows.map((row) => row[0]), ...[1, 2, 3].map((kind) => this.rows.map((row) => row[kind][joint]))];
    plot.batch(() => { // drawn now, not after the job
      plot.setData(data, false);
      plot.setScale("x", { min: Math.max(last[0] - KEPT_S, this.rows[0][0]), max: Math.max(last[0], this.rows[0][0] + 1) });
    });
  }
}
