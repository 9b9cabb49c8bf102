/* The page: one web socket, the newest state as it comes, drawn at most twenty times a second. */
import { Body } from "./body.js";
import { Strips } from "./strips.js";
import { Controls } from "./controls.js";
import { Story } from "./story.js";
import { $, number, put } from "./common.js";

const SILENCE_MS = 800; // a server beats four times a second: after this long the page says that it hears nothing
const ALARM_MS = 50; // between two looks whether anything is heard
const AGAIN_MS = 500; // between two tries to connect; the next run at this address is shown, too
const PICTURE_MS = 50; // at least, between two pictures: where nothing but the processor draws, one takes 10 ms of it
const ROUND_PICTURES = 6; // figures and charts are spread over so many: each is drawn three times a second

let socket = null, about = null, heard = performance.now(), last = null, dirty = false, ended = false;
let drawing = false, drawn = -Infinity, waiting = false, jobs = [], share = 1; // of one round of figures and charts: what is left, how many a picture
const body = new Body($("body"), $("follow")), strips = new Strips($("strips")), controls = new Controls(say), story = new Story();

function connect() {
  const here = new URL("./", location.href);
  here.protocol = here.protocol.replace("http", "ws");
  here.search = location.search; // the token, where one is needed
  socket = new WebSocket(here, ["snakebot.view.1"]);
  socket.onmessage = (event) => take(JSON.parse(event.data));
  socket.onclose = () => { socket = null; setTimeout(connect, AGAIN_MS); };
}

function say(wish) {
  if (!socket || socket.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify(wish));
  return true;
}

/* What ends the motion: asked for at once, and what becomes of it is said. */
function end(what) {
  const name = what === "stop" ? "STOP" : "Ramp down";
  told(say({ do: what }) ? `${name}: sent …` : `${name}: NOT SENT, there is no connection. Use \`snakebot stop\` or the robot's power switch.`);
}

function told(line) {
  put($("said"), line);
  $("said").hidden = !line;
}

function take(message) {
  heard = performance.now();
  if (message.type === "hello") begin(message);
  else if (message.type === "reply" && ["stop", "ramp_down"].includes(message.do)) {
    told(`${message.do === "stop" ? "STOP" : "Ramp down"}: ${message.refused || "the run has been told"}`);
  } else if (message.type === "reply") controls.replied(message);
  else if (message.type === "frame" && about) {
    last = message;
    if (message.fresh) { strips.clear(); body.begin(about); $("events").replaceChildren(); }
    if (message.story) story.show(message.story);
    strips.add(message.rows);
    for (const event of message.events) addEvent(event);
    ended = Boolean(message.status.ended);
    dirty = true;
    alarm(heard);
    soon();
  }
}

function begin(hello) {
  about = hello;
  ended = false;
  last = null;
  told("");
  document.title = `snakebot · ${hello.title}`;
  put($("title"), hello.title);
  put($("where"), [hello.robot, hello.port].filter(Boolean).join(" · "));
  $("events").replaceChildren();
  body.begin(hello);
  strips.begin(hello);
  controls.begin(hello);
  jobs = []; // those of another run
}

function addEvent(event) {
  const item = document.createElement("li"), time = document.createElement("time");
  item.className = `l${event.level}`;
  time.textContent = `${number(event.t_s, 2)} s`;
  item.append(time, document.createTextNode(event.message));
  $("events").prepend(item);
  while ($("events").childElementCount > 100) $("events").lastElementChild.remove();
}

function facts(frame) {
  const s = frame.status, link = frame.link, tele = frame.telemetry;
  const rows = [
    ["rate", `${number(frame.loop.rate_hz, 1)} Hz`], ["round trip", `${number(frame.loop.round_trip_ms, 2)} ms`],
    ["late", link.late ?? 0, link.late], ["skipped", link.skipped ?? 0, link.skipped],
    ["without answer", link.lost ?? 0, link.lost], ["corrupt", link.corrupt ?? 0, link.corrupt],
    ["clamped", s.clamped ?? 0],
  ];
  if (link.standstills) rows.push(["standstills", link.standstills, true]);
  if (tele.supply_v !== undefined) rows.push(["supply", `${number(tele.supply_v, 2)} V`]);
  if (tele.supply_a !== undefined) rows.push(["current", `${number(tele.supply_a, 2)} A`]);
  const warm = Object.entries(tele).filter(([name]) => name.startsWith("temperature_")).map(([, value]) => value);
  if (warm.length) rows.push(["hottest servo", `${number(Math.max(...warm), 0)} °C`]);
  else if (tele.supply_temperature_c !== undefined) rows.push(["board", `${number(tele.supply_temperature_c, 0)} °C`]);
  if (s.holder) rows.push(["driven by host", s.holder]);
  rows.push(["pages", frame.pages]);
  const list = $("facts");
  if (list.childElementCount !== 2 * rows.length) {
    list.replaceChildren(...rows.map(() => {
      const pair = document.createElement("div");
      pair.append(document.createElement("dt"), document.createElement("dd"));
      return pair;
    }));
  }
  rows.forEach(([name, value, bad], i) => {
    const [dt, dd] = list.children[i].children;
    put(dt, name);
    put(dd, String(value));
    dd.classList.toggle("bad", Boolean(bad));
  });
}

/* The bar on top: nothing, the end of the run, or in red that nothing is heard any more. */
function alarm(now) {
  const lost = $("lost"), bad = last && ["fault", "stopped"].includes(last.status.mode);
  const silent = now - heard > SILENCE_MS || !socket;
  lost.hidden = !(ended || silent);
  if (lost.hidden) return;
  lost.classList.toggle("calm", ended && !bad);
  put(lost, ended ? `The run has ended${last && last.status.how ? `: ${last.status.how}` : ""}. What you see is its last state; the next run at this address will show here.`
    : "Connection lost: what you see is old, and the buttons reach nobody. Use `snakebot stop` or the robot's power switch.");
}

/* The body with each picture, and of all the rest a part a picture: what is pressed meanwhile waits for no more than that. */
function draw() {
  drawing = false;
  drawn = performance.now();
  if (!last) return;
  if (dirty) body.draw(strips.newest(), last.pose);
  waiting ||= dirty;
  dirty = false;
  if (!jobs.length && waiting) {
    waiting = false;
    jobs = [figures, ...strips.jobs()];
    share = Math.ceil(jobs.length / ROUND_PICTURES);
  }
  if ($("mode").textContent !== (last.status.mode || "–")) figures(); // power on or off is shown at once
  for (const job of jobs.splice(0, share)) job();
  if (jobs.length || waiting) soon();
}

/* No picture is drawn for nothing. */
function soon() {
  if (drawing) return;
  drawing = true;
  setTimeout(() => requestAnimationFrame(draw), Math.max(0, drawn + PICTURE_MS - performance.now()));
}

function figures() {
  const s = last.status, mode = s.mode || "–", row = strips.newest(), at = number(s.t_s ?? (row ? row[0] : null), 1);
  put($("where"), [about.robot, about.port, s.log].filter(Boolean).join(" · "));
  put($("mode"), mode);
  $("mode").className = `pill ${mode}`;
  put($("clock"), s.duration_s ? `${at} of ${number(s.duration_s, 1)} s` : `${at} s`);
  controls.show(last);
  controls.joints(last, row);
  facts(last);
}

addEventListener("keydown", (event) => {
  if (event.code !== "Space" || (about && about.recording)) return;
  event.preventDefault();
  if (!event.repeat) end("stop");
}, true);
addEventListener("keyup", (event) => { if (event.code === "Space" && !(about && about.recording)) event.preventDefault(); }, true);
$("stop").addEventListener("pointerdown", () => end("stop")); // not on release: every 100 ms counts
$("stop").addEventListener("click", (event) => { if (event.detail === 0) end("stop"); }); // by keyboard or a screen reader
$("ramp").addEventListener("click", () => end("ramp_down"));
connect();
setInterval(() => alarm(performance.now()), ALARM_MS);
