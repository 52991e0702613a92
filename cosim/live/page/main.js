// The live page: what comes through the socket, drawn.

import { Connection } from "/connection.js";
import { forcesOf } from "/forces.js";
import { Hand } from "/hand.js";
import { Quantiles, delays, losses, packets, ripple, saturation } from "/measures.js";
import { Plots } from "/plots.js";
import { STATES, Scene, label, mark } from "/scene.js";
import { Sheet } from "/sheet.js";
import { Store } from "/store.js";
import { colours, onTheme } from "/theme.js";
import { drawMap, modesAt, radiusAt } from "/theory.js";

const $ = (id) => document.getElementById(id);
const PLOT_MS = 50;
const PLOT_SHARE = 4; // plots take a quarter of the time at most
const READOUT_MS = 250;
const DRAW_MS = 6;
const RIPPLE_SECONDS = 1;
const SWITCH_KEY = "c";
const RIPPLE_MEAN = 0.125; // s of the running mean

const store = new Store();
const scene = new Scene($("scene"));
const plots = new Plots($("plots"), store);
const latency = new Quantiles();
let run = null;
let forces = []; // on each finger
let seats = null;
let newest = null;
let dirty = false;
let drawn = 0;
let drawing = 0; // ms that a picture takes
let shownSample = 0;
let ages = new Quantiles();
let chosen = null;
let chosenNames = [];

// Before the connection, which a page without a token closes while it is made.
const sheet = new Sheet($("sheet"), (answer) => connection.say({ sheet: answer }));
const connection = new Connection(location.hash.slice(1), {
  opened: () => say("Connected."),
  closed: (ever) => {
    sheet.over();
    say(ever ? "The run's server is gone; looking for it." :
      "Not let in: open the whole address that cohaptic printed, with what follows the #.");
  },
  waiting: () => say("No run goes on; the next one is shown."),
  ended: () => say("The run has ended."),
  run: introduce,
  seats: takeSeats,
  sheet: takeSheet,
  rows: (frame) => store.add(frame.rows),
  frame: (frame) => {
    store.add(frame.rows);
    newest = frame;
    ages.add(frame.age);
    scene.take(frame.time, frame.values);
    dirty = true;
    // Not before the frame's turn where drawing takes long: messages would wait behind it. What the
    // pointer did is drawn sooner.
    const least = Math.max(showsMore() ? 0 : DRAW_MS, 2 * drawing);
    if (performance.now() - drawn >= least && !document.hidden) draw();
  },
});
// For whoever measures on the page; nothing here reads it.
globalThis.cohaptic = {
  get time() { return newest?.time ?? null; },
  get age() { return newest?.age ?? null; },
  get stale() { return connection.stale; },
  get run() { return run; },
  get times() { return plots.times; },
  value: (name) => scene.value(name),
  latency: (share) => latency.at(share),
  get measured() { return latency.count; },
  get drawing() { return drawing; },
};
const hand = new Hand($("scene"), scene, (message) => connection.say(message));

function say(text) {
  $("state").textContent = text;
}

function name(text) {
  $("name").textContent = text;
  document.title = `${text} · cohaptic`;
}

/** A participant sees the scene alone: numbers and names would tell what is studied. */
function takeSheet(told) {
  sheet.show(told);
  document.body.classList.add("study");
  name(told.title);
  say(told.heading);
}

// --- what is shown -------------------------------------------------------------------------------

function introduce(told) {
  run = told;
  if (sheet.title === null) name(told.name);
  say(sheet.heading || "The run goes on.");
  store.clear();
  forces = forcesOf(told.scene.fingers);
  scene.show(told.scene, told.values);
  hand.forget();
  newest = null;
  $("signals").replaceChildren(...Object.keys(told.signals).map((name) => {
    const option = document.createElement("option");
    option.value = name;
    return option;
  }));
  legend();
  usualPlots();
}

function usualPlots() {
  plots.clear();
  plots.begin = run.start;
  chosen = null;
  const { fingers, channels, boxes, bodies } = run.scene;
  if (forces.length) {
    plots.add("Force on the fingers", "N", forces.map(({ finger, names, given }) => ({
      names, label: label(finger), colour: scene.colourOf(finger.station), dash: finger.finger - 1,
      combine: (values) => {
        const [x, y] = given(values);
        return x === null ? null : Math.hypot(x, y);
      },
    })));
  }
  if (channels.length) {
    plots.add("Delay of each packet, and those that were lost", "ms", [
      ...channels.map((channel, index) => ({
        names: [channel.age, channel.sequence], label: channel.name, colour: index, dash: index,
        stepped: true, whole: ([age, number]) => delays(age, number, 1e3 / run.rate),
      })),
      ...channels.map((channel) => ({
        names: [channel.age, channel.sequence], label: `${channel.name} lost`, points: true,
        whole: ([age, number]) => losses(age, number, 1e3 / run.rate),
      })),
    ]);
  }
  // Of two worlds each counts what it would have been given, which is no user's energy.
  const ports = fingers.filter((finger) => finger.energy && finger.share === undefined);
  if (ports.length) {
    plots.add("Energy that the users have put in", "J", ports.map((finger) => ({
      names: [finger.energy], label: label(finger), colour: scene.colourOf(finger.station),
      dash: finger.finger - 1,
    })));
  }
  const copies = boxes.filter((box) => !box.world);
  const first = boxes.length ? copies.map((box) => box.pose[0]) : bodies.map((body) => body.position);
  chosenNames = chosenNames.filter((name) => name in run.signals);
  if (!chosenNames.length) chosenNames = first;
  plotChosen();
}

function plotChosen() {
  if (chosen) plots.remove(chosen);
  chosen = chosenNames.length
    ? plots.add("Chosen signals", commonUnit(chosenNames), chosenNames.map((name, index) => ({
      names: [name], label: name, colour: index, dash: Math.floor(index / 4),
    })))
    : null;
  connection.say({ watch: plots.signals });
}

function commonUnit(names) {
  const units = new Set(names.map((name) => run.signals[name]));
  return units.size === 1 ? [...units][0] : "";
}

function legend() {
  const items = STATES.map((text, state) => {
    const canvas = document.createElement("canvas");
    const ratio = devicePixelRatio || 1;
    canvas.width = canvas.height = 22 * ratio;
    canvas.style.width = canvas.style.height = "22px";
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.beginPath();
    pen.arc(11, 11, 8, 0, 7);
    mark(pen, 11, 11, state, colours.soft);
    return [canvas, text];
  });
  if (!run.scene.fingers.length) items.length = 0;
  if (run.scene.boxes.length > 1) items.push([null, "dashed: the other's copy of the box"]);
  if (run.scene.fingers.length) items.push([null, "arrow: force on the finger · wedge: friction cone · bar: penetration"]);
  $("legend").replaceChildren(...items.map(([canvas, text]) => {
    const item = document.createElement("li");
    if (canvas) item.append(canvas);
    item.append(text);
    return item;
  }));
}
onTheme(() => {
  if (run) legend();
  if (seats) showTheory(seats);
  draw();
});

// --- numbers -------------------------------------------------------------------------------------

function readouts() {
  const rows = [];
  const add = (name, value, key) => rows.push([name, value, key]);
  const number = (value, digits, unit) => (Number.isFinite(value) ? `${value.toFixed(digits)} ${unit}` : "–");
  const since = newest.time - RIPPLE_SECONDS;
  const stations = new Map();
  for (const { finger, names, given } of forces) {
    const found = store.since(names, since);
    if (!found || found[0].length < 10) continue;
    const [times, ...columns] = found;
    const pairs = times.map((_, row) => given(columns.map((column) => column[row])));
    const [x, y] = [0, 1].map((axis) => pairs.map((pair) => pair[axis]));
    const step = (times.at(-1) - times[0]) / (times.length - 1);
    const value = {
      ripple: ripple(x, y, Math.max(3, Math.round(RIPPLE_MEAN / step))),
      full: saturation(x, y, finger.limit),
    };
    const before = stations.get(finger.station);
    if (!before || !(before.ripple > value.ripple)) stations.set(finger.station, { ...before, ...value });
  }
  for (const [station, value] of stations) {
    const name = station.replace(/^station_/, "");
    add(`Force ripple, ${name}`, number(value.ripple, 2, "N"), `ripple-${name}`);
    add(`At the limit, ${name}`, number(100 * value.full, 0, "%"), `saturation-${name}`);
  }
  for (const channel of run.scene.channels) {
    const found = store.since([channel.age, channel.sequence], newest.time - 5);
    if (!found) continue;
    const { age, loss } = packets(found[1], found[2]);
    add(`${channel.name} age`, number((age * 1e3) / run.rate, 1, "ms"), `age-${channel.name}`);
    add(`${channel.name} lost`, number(100 * loss, 1, "%"), `loss-${channel.name}`);
  }
  if (newest.status) {
    const { misses, worst, slipped } = newest.status;
    add("Deadlines missed", String(misses), "misses");
    add("Ticks slipped", String(slipped), "slipped");
    add("Latest tick", number(worst * 1e3, 2, "ms"), "worst");
  }
  add("Frame's age", number(ages.at(0.5), 0, "ms"), "frame-age");
  if (connection.stale) add("Stale frames dropped", String(connection.stale), "stale");
  if (newest.lost) add("Rows lost by the page", String(newest.lost), "lost");
  if (latency.count > 20) {
    add("Pointer to picture", `${latency.at(0.5).toFixed(0)} ms, 99 %: ${latency.at(0.99).toFixed(0)}`, "latency");
  }
  $("how").hidden = latency.count <= 20;
  $("readouts").replaceChildren(...rows.map(([name, value, key]) => {
    const row = document.createElement("div");
    const term = document.createElement("dt");
    const detail = document.createElement("dd");
    term.textContent = name;
    detail.textContent = value;
    detail.dataset.key = key;
    row.append(term, detail);
    return row;
  }));
  const touching = scene.fingers.filter((finger) => scene.value(finger.state)).map(label);
  $("scene").setAttribute("aria-label", `The scene at ${newest.time.toFixed(1)} s; ` +
    (touching.length ? `fingers on the box: ${touching.join(", ")}` : "no finger touches the box"));
}

// --- drawing -------------------------------------------------------------------------------------

function draw() {
  const began = performance.now();
  scene.hand = hand.fingers;
  scene.draw();
  drawn = performance.now();
  drawing += 0.2 * (drawn - began - drawing);
  dirty = false;
  if (!newest) return;
  $("clock").textContent = `${newest.time.toFixed(1)} s`;
  measureLatency();
}

/** The number of the pointer's sample that the newest tick has used. */
function usedSample() {
  const pointer = run?.scene.pointers.find((each) => each.station === seats?.user);
  return pointer ? scene.value(pointer.count) : null;
}

const showsMore = () => usedSample() > shownSample;

/** A pointer's event is seen in the first picture whose tick has used its sample. */
function measureLatency() {
  const mine = newest.seen?.[seats?.user];
  const used = usedSample();
  shownSample = used ?? 0;
  for (const [number, time] of mine ?? []) {
    if (number <= used && hand.events.delete(time)) latency.add(drawn - time);
  }
}

let plotNext = 0;
let read = 0;
function frame(now) {
  hand.frame();
  if (dirty || (scene.hand && now - drawn > DRAW_MS)) draw();
  // One thing a frame: whatever comes in meanwhile waits.
  if (newest && now - read >= READOUT_MS) {
    read = now;
    readouts();
  } else if (newest && now >= plotNext) {
    const began = performance.now();
    plots.drawNext(newest.time);
    const took = performance.now() - began;
    plotNext = now + Math.max(PLOT_MS / Math.max(1, plots.count), PLOT_SHARE * took);
  }
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);

// --- seats and controls --------------------------------------------------------------------------

function takeSeats(told) {
  seats = told;
  const playing = run?.scene.pointers.length > 0;
  $("controls").hidden = !playing;
  $("help").hidden = !playing;
  $("stage").classList.toggle("playing", playing);
  $("second").hidden = told.users.length < 2;
  scene.own = told.user;
  const pointer = run?.scene.pointers.find((each) => each.station === told.user);
  hand.take(pointer ? pointer.fingers.map((finger) => finger.reach) : null);
  const short = (name) => name.replace(/^station_/, "user ");
  $("user").replaceChildren(...[null, ...told.users].map((name) => {
    const option = new Option(name === null ? "looking on" : short(name), name ?? "");
    option.disabled = name !== null && name !== told.user && told.taken.includes(name);
    option.selected = name === told.user;
    return option;
  }));
  $("pace").hidden = !told.control;
  if (told.control) {
    const { speed, paused, speeds } = told.control;
    $("speed").replaceChildren(...speeds.map((each) => new Option(`${each * 100} %`, each, false, each === speed)));
    $("pause").setAttribute("aria-pressed", paused);
    $("step").disabled = !paused;
  }
  showKnobs(told.knobs);
  showTheory(told);
}

function showKnobs(knobs) {
  const panel = $("knobs");
  panel.hidden = !knobs.length || !run?.scene.pointers.length;
  for (const knob of knobs) {
    const shown = document.getElementById(`knob-${knob.key}`) ?? (knob.choices.length ? choice : slider)(knob);
    if (!shown.isConnected) panel.append(shown.closest("label") ?? shown);
    shown.disabled = seats.user === null;
    if (knob.choices.length) shown.querySelectorAll("input")[knob.value].checked = true;
    else {
      if (document.activeElement !== shown || !shown.matches(":active")) shown.value = knob.value;
      shown.nextElementSibling.textContent = amount(knob.value, knob.unit);
    }
  }
}

const turn = (knob, value) => connection.say({ knobs: { [knob.key]: value } });

const amount = (value, unit) => `${value} ${unit === "samples" && Number(value) === 1 ? "sample" : unit}`;

function slider(knob) {
  const row = document.createElement("label");
  const input = document.createElement("input");
  Object.assign(input, {
    type: "range", id: `knob-${knob.key}`, min: knob.minimum, max: knob.maximum, step: knob.step,
  });
  const shown = document.createElement("output");
  input.addEventListener("input", () => {
    turn(knob, Number(input.value));
    shown.textContent = amount(input.value, knob.unit);
  });
  row.append(knob.label, input, shown);
  return input;
}

/** A switch between a few things. */
function choice(knob) {
  const group = document.createElement("fieldset");
  group.id = `knob-${knob.key}`;
  const legend = document.createElement("legend");
  legend.textContent = `${knob.label} (key ${SWITCH_KEY.toUpperCase()})`;
  group.append(legend, ...knob.choices.map((name, value) => {
    const row = document.createElement("label");
    const input = document.createElement("input");
    Object.assign(input, { type: "radio", name: group.id, value: name });
    input.addEventListener("change", () => turn(knob, value));
    row.append(input, name);
    return row;
  }));
  return group;
}

// A mouse that pinches the box cannot go to the switch.
addEventListener("keydown", (event) => {
  const knob = seats?.knobs.find((each) => each.choices.length);
  const typing = event.target.matches?.("input:not([type=radio]):not([type=range]), select");
  if (!knob || typing || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key.toLowerCase() === SWITCH_KEY) turn(knob, (knob.value + 1) % knob.choices.length);
});

/** The radius and slowest modes at the present knobs, and the map around them. */
function showTheory({ knobs }) {
  const theory = run?.theory;
  const values = Object.fromEntries(knobs.map((knob) => [knob.key, knob.value]));
  $("theory").hidden = !theory || $("knobs").hidden;
  if ($("theory").hidden) return;
  const world = theory.worlds[values[theory.switch] ?? 0] ?? theory.worlds[0];
  const radius = radiusAt(world, values);
  $("world").textContent = world.name;
  $("radius").textContent = `spectral radius ${radius.toFixed(2)}: ${radius < 1 ? "stable" : "unstable"}`;
  $("radius").dataset.value = radius;
  $("modes").textContent = `Slowest modes: ${modesAt(world, values).map(modeText).join("; ")}.`;
  $("stiffness").textContent = knobs.find((knob) => knob.key === world.axes[1][0])?.label ?? "stiffness";
  drawMap($("map"), world, values);
}

/** A mode in words; ``factor`` is by what it grows in a second. */
function modeText([factor, hertz]) {
  const change = Math.log(factor);
  const time = `${(1 / Math.abs(change)).toPrecision(2)} s`;
  const pace = hertz < 0.05 ? "without oscillation" : `at ${hertz.toFixed(1)} Hz`;
  return `${pace}, ${change < 0 ? "decays" : "grows"} by e in ${time}`;
}

const control = (wish) => connection.say({ control: wish });
$("user").addEventListener("change", (event) => connection.say({ user: event.target.value || null }));
$("restart").addEventListener("click", () => control({ restart: true }));
$("pause").addEventListener("click", () => control({ paused: !seats.control.paused }));
$("step").addEventListener("click", () => control({ step: true }));
$("speed").addEventListener("change", (event) => control({ speed: Number(event.target.value) }));

$("freeze").addEventListener("click", () => plots.hold(!plots.held));
plots.onHold = (held) => $("freeze").setAttribute("aria-pressed", held);
$("window").addEventListener("change", (event) => {
  plots.seconds = Number(event.target.value);
});
$("choose").addEventListener("submit", (event) => {
  event.preventDefault();
  const name = $("signal").value.trim();
  const known = run && name in run.signals;
  $("signal").setCustomValidity(known ? "" : "The run records nothing of that name.");
  if (!known) $("signal").reportValidity();
  else if (!chosenNames.includes(name)) {
    chosenNames = [...chosenNames, name].slice(-8);
    $("signal").value = "";
    plotChosen();
  }
});
$("signal").addEventListener("input", () => $("signal").setCustomValidity(""));
$("clear").addEventListener("click", () => {
  chosenNames = [];
  plotChosen();
});
