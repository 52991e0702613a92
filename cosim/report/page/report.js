// A run's page: the scene with its slider, and plots of what was recorded.

import uPlot from "./uPlot.js";
import { colours, onTheme, user } from "./theme.js";
import { STATES, Scene, mark } from "./scene.js";

const HEIGHT = 170;
const POINTS = 2048; // twice as many are drawn of a line, about two for each pixel
const data = JSON.parse(document.getElementById("data").textContent);
const byName = new Map(data.signals.map((signal) => [signal.name, signal]));
const unpacked = new Map();

/** The values of a packed array, unpacked once: the steps of cosim/report/page/pack.py, back. */
function values(number) {
  if (!unpacked.has(number)) unpacked.set(number, unpack(data.packed[number]));
  return unpacked.get(number);
}

async function unpack({ rows, low, step, data: text }) {
  const found = new Float64Array(rows);
  if (text === undefined) return found.fill(low);
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  let steps = 0;
  for (let row = 0; row < rows; row++) {
    steps = (steps + planes[row] + 256 * planes[rows + row]) & 65535;
    found[row] = steps === 65535 ? NaN : low + step * steps;
  }
  return found;
}

// The moment that is looked at, shared by scene, slider and plots.

const clock = document.getElementById("clock");
const slider = document.getElementById("time");
const watchers = [];
const [START, END] = [data.start, data.start + data.duration]; // the model's time (s)
let now = START;

function moveTo(time) {
  now = Math.min(Math.max(time, START), END);
  slider.value = now;
  clock.textContent = `${now.toFixed(3)} s`;
  for (const watcher of watchers) watcher(now);
}

// Plots.

const plots = [];
const parent = document.getElementById("plots");
let range = [START, END];

async function columns(name) {
  const signal = byName.get(name);
  if (signal.rows !== undefined) return [{ name, values: await values(signal.rows) }];
  return [
    { name: `${name}, greatest`, values: await values(signal.high) },
    { name: `${name}, least`, values: await values(signal.low) },
  ];
}

async function addPlot(names, unit) {
  const lines = [];
  for (const [index, name] of names.entries()) {
    const parts = await columns(name);
    for (const part of parts) lines.push({ ...part, index, of: byName.get(name), band: parts.length > 1 });
  }
  const length = Math.max(...lines.map((line) => line.values.length));
  const period = Math.min(...lines.map((line) => line.of.period));
  const aligned = lines.map((line) => {
    const ratio = line.of.period / period;
    if (ratio === 1 && line.values.length === length) return line.values;
    return Float64Array.from({ length }, (_, row) =>
      line.values[Math.min(line.values.length - 1, Math.floor(row / ratio + 1e-9))]);
  });
  const figure = document.createElement("figure");
  const caption = document.createElement("figcaption");
  caption.textContent = names.length === 1 ? names[0] : unit === "" ? "signals" : `signals in ${unit}`;
  const note = document.createElement("span");
  note.textContent = names.length === 1 ? [unit, byName.get(names[0]).description].filter(Boolean).join(" · ") : "";
  const close = document.createElement("button");
  close.type = "button";
  close.textContent = "Close";
  close.setAttribute("aria-label", `Close the plot of ${names.join(", ")}`);
  caption.append(note, close);
  figure.append(caption);
  parent.append(figure);
  const found = visible(aligned, period);
  const plot = new uPlot(options(lines, byName.get(names[0]).items), found, figure);
  const marker = document.createElement("div");
  marker.className = "marker";
  plot.over.append(marker);
  const entry = { plot, figure, marker, aligned, period };
  plots.push(entry);
  close.onclick = () => {
    plots.splice(plots.indexOf(entry), 1);
    plot.destroy();
    figure.remove();
  };
  plot.setScale("x", { min: range[0], max: range[1] });
  place(entry);
}

/** Times and columns of the rows in view; of many, the least and greatest of each few. */
function visible(columns, period) {
  const first = Math.max(0, Math.floor((range[0] - START) / period) - 1);
  const last = Math.min(columns[0].length, Math.ceil((range[1] - START) / period) + 2);
  const size = Math.ceil((last - first) / POINTS);
  if (size <= 2) {
    const rows = Math.max(0, last - first);
    const time = Float64Array.from({ length: rows }, (_, row) => START + (first + row) * period);
    return [time, ...columns.map((column) => Array.from(column.subarray(first, last), known))];
  }
  const bins = Math.ceil((last - first) / size);
  const time = Float64Array.from({ length: 2 * bins }, (_, row) => START + (first + (row * size) / 2) * period);
  return [time, ...columns.map((column) => {
    const found = new Array(2 * bins);
    for (let bin = 0; bin < bins; bin++) {
      let low = Infinity;
      let high = -Infinity;
      const end = Math.min(last, first + (bin + 1) * size);
      for (let row = first + bin * size; row < end; row++) {
        if (column[row] < low) low = column[row];
        if (column[row] > high) high = column[row];
      }
      found[2 * bin] = low <= high ? low : null;
      found[2 * bin + 1] = low <= high ? high : null;
    }
    return found;
  })];
}

const known = (value) => (Number.isNaN(value) ? null : value);

let zooming = false;

function zoom(min, max) {
  if (zooming || (range[0] === min && range[1] === max)) return;
  zooming = true;
  range = [min, max];
  for (const entry of plots) {
    entry.plot.batch(() => {
      entry.plot.setData(visible(entry.aligned, entry.period), false);
      entry.plot.setScale("x", { min, max });
    });
    place(entry);
  }
  zooming = false;
}

function options(lines, items) {
  const axis = {
    stroke: () => colours.soft,
    grid: { stroke: () => colours.faint, width: 1 },
    ticks: { stroke: () => colours.faint, width: 1 },
    font: "12px system-ui, sans-serif",
  };
  const bands = [];
  lines.forEach((line, index) => {
    if (line.band && line.name.endsWith("greatest")) {
      bands.push({ series: [index + 1, index + 2], fill: () => `color-mix(in srgb, ${user(line.index)} 30%, transparent)` });
    }
  });
  const named = (_, ticks) => ticks.map((tick) => items?.[tick] ?? (items ? "" : `${+tick.toPrecision(6)}`));
  return {
    width: parent.clientWidth || 300,
    height: HEIGHT,
    bands,
    cursor: { sync: { key: "time" }, points: { show: false }, drag: { x: true, y: false } },
    scales: { x: { time: false }, y: { range: room } },
    axes: [
      { ...axis, size: 28, values: (_, ticks) => ticks.map((tick) => `${+tick.toFixed(4)} s`) },
      { ...axis, size: items ? 120 : 62, values: named },
    ],
    series: [
      { label: "time", value: (_, value) => (value === null ? "" : `${value.toFixed(4)} s`) },
      ...lines.map((line) => ({
        label: line.name,
        stroke: () => user(line.index),
        dash: [[], [7, 4], [2, 3]][Math.floor(line.index / 4) % 3],
        width: line.band ? 0.6 : 1.5,
        points: { show: false },
        paths: uPlot.paths.stepped({ align: 1 }),
        value: (_, value) => (value === null ? "" : items?.[value] ?? `${+value.toPrecision(6)}`),
      })),
    ],
    hooks: {
      setScale: [(plot, key) => key === "x" && zoom(plot.scales.x.min, plot.scales.x.max)],
      ready: [(plot) => {
        let down = null;
        plot.over.addEventListener("mousedown", (event) => (down = event.clientX));
        plot.over.addEventListener("click", (event) => {
          if (down !== null && Math.abs(event.clientX - down) < 3) {
            moveTo(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
          }
        });
        plot.over.addEventListener("dblclick", () => zoom(START, END));
      }],
    },
  };
}

/** The ends of an axis: some room, also around a value that stands still. */
function room(_, low, high) {
  if (low === null) return [0, 1];
  const space = high > low ? 0.06 * (high - low) : Math.abs(high) || 1;
  return [low - space, high + space];
}

/** Put a plot's upright line to the moment of the slider; nothing is drawn again for it. */
function place({ plot, marker }) {
  const { min, max } = plot.scales.x;
  marker.hidden = !data.scene || now < min || now > max;
  if (!marker.hidden) marker.style.transform = `translateX(${plot.valToPos(now, "x")}px)`;
}

watchers.push(() => plots.forEach(place));
onTheme(() => {
  for (const { plot } of plots) plot.redraw(false, true);
});
new ResizeObserver(() => {
  for (const entry of plots) {
    entry.plot.setSize({ width: parent.clientWidth, height: HEIGHT });
    place(entry);
  }
}).observe(parent);

const input = document.getElementById("signal");
document.getElementById("names").append(
  ...data.signals.map((signal) => Object.assign(document.createElement("option"), { value: signal.name })),
);
document.getElementById("choose").onsubmit = async (event) => {
  event.preventDefault();
  const name = input.value.trim();
  input.setCustomValidity(byName.has(name) ? "" : "Nothing of this name was recorded.");
  if (!input.reportValidity()) return;
  await addPlot([name], byName.get(name).unit);
  input.value = "";
};
input.oninput = () => input.setCustomValidity("");

// The scene.

async function showScene() {
  document.getElementById("stage").hidden = false;
  const scene = new Scene(document.getElementById("scene"));
  const poses = await Promise.all(data.poses.map((pose) => values(pose.rows)));
  scene.show(data.scene, data.poses.map((pose) => pose.name));
  const at = (time) => data.poses.map(({ period }, index) => {
    const found = poses[index];
    const value = found[Math.min(found.length - 1, Math.floor((time - START) / period + 1e-9))];
    return Number.isNaN(value) ? null : value;
  });
  scene.take(START, at(START));
  watchers.push((time) => {
    scene.take(time, at(time));
    scene.draw();
  });
  onTheme(() => scene.draw());
  legend(scene);
  const play = document.getElementById("play");
  const speed = document.getElementById("speed");
  let last = null;
  const step = (stamp) => {
    if (last === null) return;
    const time = now + ((stamp - last) / 1000) * Number(speed.value);
    last = stamp;
    moveTo(time);
    if (now >= END) stop();
    else requestAnimationFrame(step);
  };
  const stop = () => {
    last = null;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  };
  const start = () => {
    if (now >= END) moveTo(START);
    last = performance.now();
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    requestAnimationFrame(step);
  };
  play.onclick = () => (last === null ? start() : stop());
  [slider.min, slider.max] = [START, END];
  slider.oninput = () => moveTo(Number(slider.value));
  slider.addEventListener("pointerdown", stop);
  document.getElementById("scene").onkeydown = (event) => {
    const steps = { ArrowLeft: -0.05, ArrowRight: 0.05, ",": -1 / 1024, ".": 1 / 1024 };
    if (event.key === " ") play.click();
    else if (event.key in steps) moveTo(now + steps[event.key]);
    else if (event.key === "Home") moveTo(START);
    else if (event.key === "End") moveTo(END);
    else return;
    event.preventDefault();
  };
  moveTo(START);
}

function legend(scene) {
  const list = document.getElementById("legend");
  const stations = [...new Set([...data.scene.boxes, ...data.scene.fingers].map((each) => each.station))];
  const entry = (text, draw) => {
    const item = document.createElement("li");
    const canvas = Object.assign(document.createElement("canvas"), { width: 24, height: 24 });
    const redraw = () => {
      const pen = canvas.getContext("2d");
      pen.clearRect(0, 0, 24, 24);
      draw(pen);
    };
    redraw();
    onTheme(redraw);
    item.append(canvas, text);
    list.append(item);
  };
  for (const station of stations) {
    entry(station, (pen) => {
      pen.fillStyle = user(scene.colourOf(station));
      pen.fillRect(4, 4, 16, 16);
    });
  }
  if (!data.scene.fingers.length) return;
  STATES.forEach((name, state) => entry(name, (pen) => {
    pen.beginPath();
    pen.arc(12, 12, 8, 0, 7);
    mark(pen, 12, 12, state, colours.ink);
  }));
}

async function main() {
  if (data.scene) await showScene();
  for (const { signals, unit } of data.panels) await addPlot(signals, unit);
  document.documentElement.dataset.ready = "yes";
}

// For whoever opens the console: the record by name, and the slider.
globalThis.report = { data, moveTo, values: (name) => values(byName.get(name).rows) };

main().catch((error) => {
  const note = document.createElement("p");
  note.className = "outcome bad";
  note.textContent = `This page could not be drawn: ${error.message}`;
  document.querySelector("main").prepend(note);
});
