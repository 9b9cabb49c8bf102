/* Joints with their states, sliders of the gait with the limits they would meet. */
import { $, color, number, put } from "./common.js";

const PARTS = [
  ["alpha_deg", "alpha", 0, 90, 1, "°"], ["beta_deg", "beta", 0, 180, 1, "°"],
  ["omega_rad_s", "omega", 0, 8, 0.05, "rad/s"], ["offset_deg", "offset", -30, 30, 0.5, "°"],
];
const MARGIN = 0.95; // of speed and acceleration: what a board is sure to execute as it is
const BUSY_MS = 1300; // a change blends in for a second: until then the sliders show what was asked for
const POWERED = ["armed", "holding"]; // modes of the board in which a joint's own state tells what it does
const UNPOWERED = { fault: "fault", stopped: "no power", disarmed: "no power", silent: "unknown" };
const STATES = { active: "active", free: "free", rigid: "rigid", rigid_here: "rigid" };

export class Controls {
  constructor(say) {
    this.say = say;
    this.sliders = {};
    for (const [name, label, low, high, step, unit] of PARTS) {
      const row = document.createElement("label"), input = document.createElement("input"), output = document.createElement("output");
      const track = document.createElement("span"), allowed = document.createElement("i");
      Object.assign(input, { type: "range", min: low, max: high, step, name });
      track.append(input, allowed);
      row.append(document.createTextNode(label), track, output);
      $("sliders").append(row);
      input.addEventListener("input", () => this.moved());
      this.sliders[name] = { input, output, allowed, low, high, unit, digits: step < 0.1 ? 2 : step < 1 ? 1 : 0 };
    }
  }

  /* Play, pause, seek and speed of a recording. */
  playback(about) {
    $("play-box").hidden = !about.recording;
    if (!about.recording || $("speed").options.length) return;
    for (const speed of about.speeds) $("speed").append(new Option(`${speed} x`, speed, speed === 1, speed === 1));
    $("play").addEventListener("click", () => this.say({ do: $("play").textContent }));
    $("seek").addEventListener("input", () => this.say({ do: "seek", t_s: Number($("seek").value) }));
    $("speed").addEventListener("change", () => this.say({ do: "speed", speed: Number($("speed").value) }));
  }

  begin(about) {
    this.about = about;
    this.playback(about);
    this.asked = -Infinity; // when the sliders were moved last
    this.known = false; // until the run's gait is known, the sliders are somewhere and may not be moved
    this.wanted = null;
    this.waiting = false;
    this.refused = "";
    this.shown = ""; // the gait whose limits are drawn
    $("ends").hidden = Boolean(about.recording);
    $("ramp").hidden = Boolean(about.onlooker); // only who drives can
    const rows = Array.from({ length: about.joints }, (_, i) => {
      const row = document.createElement("tr");
      for (let k = 0; k < 9; k++) { const cell = document.createElement("td"); if ((k > 0 && k < 6) || k === 7) cell.className = "n"; row.append(cell); }
      row.children[0].textContent = i + 1;
      row.children[8].append(document.createElement("canvas"));
      row.children[6].append(document.createElement("span"));
      if (!about.recording && !about.onlooker) {
        const choice = document.createElement("select");
        choice.setAttribute("aria-label", `state of joint ${i + 1}`);
        choice.hidden = true;
        for (const state of ["active", "free", "rigid"]) choice.append(new Option(state, state));
        choice.addEventListener("change", () => {
          const joint = `:${i + 1}`, kind = choice.value;
          this.say({ do: "fault", fault: kind === "active" ? `clear${joint}` : kind === "free" ? `free${joint}` : `rigid${joint}@1s` });
          choice.blur();
        });
        row.children[6].append(choice);
      }
      return row;
    });
    $("joints").tBodies[0].replaceChildren(...rows);
  }

  values() {
    return Object.fromEntries(PARTS.map(([name]) => [name, Number(this.sliders[name].input.value)]));
  }

  moved() {
    if (!this.known) return;
    this.wanted = this.values();
    this.refused = "";
    this.asked = performance.now();
    this.send();
  }

  /* One change at a time: the next one goes out when the last has been answered. */
  send() {
    if (this.waiting || !this.wanted || this.binding(this.wanted)) return;
    this.waiting = true;
    const gait = this.wanted;
    this.wanted = null;
    if (!this.say({ do: "gait", ...gait })) this.waiting = false;
  }

  replied(message) {
    this.waiting = false;
    this.refused = message.refused || "";
    if (!this.refused) this.send();
  }

  /* Which limit a gait would break, in words; "" where none. */
  binding(gait) {
    const alpha = gait.alpha_deg, rate = gait.omega_rad_s, rad = alpha * Math.PI / 180, a = this.about;
    for (let i = 0; i < a.joints; i++) {
      if (alpha + Math.abs(gait.offset_deg) > a.angle_limit_deg[i]) return `angle of joint ${i + 1}: ${number(alpha + Math.abs(gait.offset_deg), 0)} of ${number(a.angle_limit_deg[i], 0)}°`;
      if (rad * rate > MARGIN * a.speed_limit_rad_s[i]) return `speed of joint ${i + 1}: ${number(rad * rate, 2)} of ${number(a.speed_limit_rad_s[i], 2)} rad/s`;
      if (rad * rate * rate > MARGIN * a.acceleration_limit_rad_s2[i]) return `acceleration of joint ${i + 1}: ${number(rad * rate * rate, 1)} of ${number(a.acceleration_limit_rad_s2[i], 1)} rad/s²`;
    }
    return "";
  }

  /* The largest value of a slider that keeps every limit while the others stay. */
  most(name, gait) {
    const a = this.about, joints = Array.from({ length: a.joints }, (_, i) => i);
    const alpha = gait.alpha_deg * Math.PI / 180, rate = Math.abs(gait.omega_rad_s), degrees = 180 / Math.PI;
    const least = (of) => Math.min(...joints.map(of));
    if (name === "alpha_deg") return least((i) => Math.min(a.angle_limit_deg[i] - Math.abs(gait.offset_deg), MARGIN * degrees * Math.min(a.speed_limit_rad_s[i] / rate, a.acceleration_limit_rad_s2[i] / rate ** 2)));
    if (name === "omega_rad_s") return least((i) => Math.min(MARGIN * a.speed_limit_rad_s[i] / alpha, Math.sqrt(MARGIN * a.acceleration_limit_rad_s2[i] / alpha)));
    if (name === "offset_deg") return least((i) => a.angle_limit_deg[i] - gait.alpha_deg);
    return Infinity;
  }

  /* A bar under each slider: how far it may go. */
  marks(gait) {
    const key = JSON.stringify(gait);
    if (key === this.shown) return;
    this.shown = key;
    for (const [name] of PARTS) {
      const { allowed, low, high } = this.sliders[name], most = Math.max(0, this.most(name, gait));
      const share = (v) => Math.max(0, Math.min(1, (v - low) / (high - low)));
      const from = low < 0 ? share(-most) : 0;
      allowed.style.left = `${100 * from}%`;
      allowed.style.width = `${100 * (share(most) - from)}%`;
    }
  }

  show(frame) {
    if (this.about.recording) {
      const seek = $("seek"), s = frame.status;
      put($("play"), s.playing ? "pause" : "play");
      Object.assign(seek, { min: s.start_s ?? 0, max: s.duration_s ?? 1 });
      if (!seek.matches(":active")) seek.value = s.t_s;
    }
    const gait = frame.status.gait;
    $("gait-box").hidden = !gait; // a probe, a replay, a recording, a board that others drive: none to change
    const busy = performance.now() - this.asked < BUSY_MS || this.waiting || this.wanted;
    for (const [name] of PARTS) {
      const { input, output, unit, digits } = this.sliders[name];
      if (gait && !busy && (document.activeElement !== input || !this.known)) input.value = gait[name];
      put(output, `${number(Number(input.value), digits)} ${unit}`);
      input.disabled = !frame.drives || !gait;
    }
    this.known = this.known || Boolean(gait);
    if (gait) this.marks(this.values());
    const over = this.binding(this.values()), limits = $("limits");
    limits.classList.toggle("over", Boolean(over || this.refused));
    const share = this.about.speed_limit_rad_s.length ? Math.max(...this.about.speed_limit_rad_s.map((limit) => this.values().alpha_deg * Math.PI / 180 * this.values().omega_rad_s / limit)) : 0;
    put(limits, over ? `not sent: beyond the limit of ${over}` : this.refused ? `not changed: ${this.refused}` : `peak joint speed: ${number(share * 100, 0)} % of the limit`);
    const drive = $("drive");
    const watch = this.about.recording || this.about.onlooker;
    put(drive, this.about.ended ? `how the run ended: ${this.about.ended}` : frame.drives || watch ? "" : frame.free ? "No page drives: click here to take over." : "Another page drives; this one watches. STOP and Ramp down work here, too.");
    drive.onclick = frame.free ? () => this.say({ do: "drive" }) : null;
  }

  joints(frame, row) {
    if (!row) return;
    const [, set, executed, measured] = row, mode = frame.status.board || frame.status.mode; // a recording tells both
    const told = Object.keys(frame.telemetry).some((name) => name.startsWith("temperature_"));
    $("warm").hidden = !told;
    [...$("joints").tBodies[0].rows].forEach((line, i) => {
      const cells = line.children, error = measured[i] === null || set[i] === null ? null : measured[i] - set[i];
      [set[i], executed[i], measured[i], error, frame.rms_deg[i]].forEach((value, k) => put(cells[k + 1], number(value, k > 2 ? 2 : 1)));
      this.bar(cells[8].firstChild, this.about.angle_limit_deg[i], set[i], executed[i], measured[i]);
      const own = STATES[frame.joint_modes[i]] || frame.joint_modes[i], state = UNPOWERED[mode] || own;
      const [word, choice] = cells[6].children;
      cells[6].className = state.replace(" ", "-");
      put(word, state);
      if (choice) {
        choice.hidden = !frame.drives || !POWERED.includes(mode);
        word.hidden = !choice.hidden;
        if (document.activeElement !== choice && STATES[own]) choice.value = own;
      }
      cells[7].hidden = !told;
      put(cells[7], number(frame.telemetry[`temperature_${i + 1}_c`], 0));
    });
  }

  bar(canvas, limit, set, executed, measured) {
    const ratio = devicePixelRatio || 1, width = 90, height = 16;
    if (canvas.width !== width * ratio) { canvas.width = width * ratio; canvas.height = height * ratio; }
    const c = canvas.getContext("2d"), px = (v) => (Math.max(-1, Math.min(1, v / limit)) + 1) / 2 * (width - 8) + 4;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    c.fillStyle = color("grid"); c.fillRect(4, 6, width - 8, 4);
    if (executed !== null) { c.fillStyle = color("applied"); c.fillRect(Math.min(px(0), px(executed)), 6, Math.abs(px(executed) - px(0)), 4); }
    if (set !== null) { c.fillStyle = color("command"); c.fillRect(px(set) - 1, 1, 2, 14); }
    if (measured !== null) { c.fillStyle = color("measured"); c.beginPath(); c.arc(px(measured), 8, 4, 0, 7); c.fill(); }
  }
}
