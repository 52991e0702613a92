// A figure's page: each panel a plot that is zoomed by the pointer and by the keyboard.

import uPlot from "./uPlot.js";
import { colours, onTheme, user } from "./theme.js";

const HEIGHT = 260;
const DASHES = [[], [7, 4], [2, 3], [9, 3, 2, 3]];
const parent = document.getElementById("plots");
const panels = JSON.parse(document.getElementById("data").textContent);
const plots = [];

/** Numbers again: the steps of cosim/plot/page/document.py, back. */
async function decode(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const rows = planes.length / 8;
  const mixed = new Uint8Array(planes.length);
  for (let plane = 0; plane < 8; plane++) {
    for (let row = 0; row < rows; row++) mixed[8 * row + plane] = planes[plane * rows + row];
  }
  return new Float64Array(mixed.buffer);
}

/** Columns over one x: held between the points where the form is steps, else missing there. */
function together(lines, holds) {
  const same = lines.every(({ x }) => x.length === lines[0].x.length && x.every((v, i) => v === lines[0].x[i]));
  const shown = (value) => (Number.isFinite(value) ? value : null);
  if (same) return [lines[0].x, ...lines.map(({ y }) => Array.from(y, shown))];
  const all = Float64Array.from(new Set(lines.flatMap(({ x }) => Array.from(x)))).sort();
  return [all, ...lines.map(({ x, y }) => {
    let at = -1;
    return Array.from(all, (moment) => {
      while (at + 1 < x.length && x[at + 1] <= moment) at++;
      if (at < 0 || (!holds && x[at] !== moment)) return undefined;
      return shown(y[at]);
    });
  })];
}

function axis(more) {
  return {
    stroke: () => colours.soft,
    grid: { stroke: () => colours.faint, width: 1 },
    ticks: { stroke: () => colours.faint, width: 1 },
    font: "12px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif",
    ...more,
  };
}

const short = (value) => (value == null ? "" : `${+value.toPrecision(6)}`);

function options(panel) {
  const { items, plane, logarithmic, form } = panel;
  const named = Object.keys(items).length > 0;
  const distr = logarithmic ? 3 : 1;
  const values = (_, ticks) => ticks.map((tick) => (named ? items[tick] ?? "" : short(tick)));
  return {
    mode: plane ? 2 : 1,
    width: parent.clientWidth || 300,
    height: height(panel),
    cursor: { drag: { x: true, y: plane || logarithmic, uni: 20 }, points: { show: false } },
    legend: { live: !plane, show: panel.lines.some((line) => line.label) || !plane },
    scales: {
      x: { time: false, distr, auto: !plane },
      y: { distr, auto: !plane, ...(!logarithmic && !plane && { range: form === "bars" ? fromZero : room }) },
    },
    axes: [
      axis({ label: panel.x, size: 34, labelSize: 20, values: (_, ticks) => ticks.map(short) }),
      axis({ label: named ? "" : panel.y, size: named ? 120 : 70, labelSize: 20, values }),
    ],
    series: [
      plane ? null : { label: panel.x, value: (_, value) => short(value) },
      ...panel.lines.map((line, index) => ({
        label: line.label || panel.title || panel.y,
        stroke: () => user(index),
        fill: form === "bars" ? () => `color-mix(in srgb, ${user(index)} 25%, transparent)` : undefined,
        dash: DASHES[Math.floor(index / 4) % DASHES.length],
        width: 1.5,
        spanGaps: form === "line",
        points: { show: false },
        ...(plane
          ? { facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }], paths: inOrder }
          : form === "line" ? {} : { paths: uPlot.paths.stepped({ align: 1 }) }),
        value: (_, value) => (value === null ? "" : items[value] ?? short(value)),
      })),
    ],
  };
}

/** A line through its points in their order, whichever way x goes. */
function inOrder(plot, series) {
  const path = new Path2D();
  const [x, y] = plot.data[series];
  let lifted = true;
  for (let row = 0; row < x.length; row++) {
    if (!Number.isFinite(x[row]) || !Number.isFinite(y[row])) {
      lifted = true;
      continue;
    }
    path[lifted ? "moveTo" : "lineTo"](plot.valToPos(x[row], "x", true), plot.valToPos(y[row], "y", true));
    lifted = false;
  }
  return { stroke: path, fill: null, clip: null, band: null, gaps: null, flags: 1 };
}

function room(_, low, high) {
  if (low === null || low === undefined || !Number.isFinite(low)) return [0, 1];
  const space = high > low ? 0.04 * (high - low) : Math.abs(high) || 1;
  return [low - space, high + space];
}

const fromZero = (_, low, high) => [0, 1.05 * (high || 1)];

function height(panel) {
  const width = parent.clientWidth || 300;
  return panel.plane || panel.logarithmic ? Math.round(Math.min(560, Math.max(280, 0.6 * width))) : HEIGHT;
}

/** Of two axes of one unit, the one with more room shows more, so that circles stay round. */
function square(plot) {
  const { x, y } = plot.scales;
  const [wide, high] = [plot.over.clientWidth, plot.over.clientHeight];
  const pixel = Math.max((x.max - x.min) / wide, (y.max - y.min) / high);
  const around = (scale, size) => {
    const middle = (scale.min + scale.max) / 2;
    return { min: middle - (pixel * size) / 2, max: middle + (pixel * size) / 2 };
  };
  plot.batch(() => {
    const [across, up] = [around(x, wide), around(y, high)];
    plot.setScale("x", across);
    plot.setScale("y", up);
  });
}

function whole(plot, panel, columns) {
  if (!panel.plane) {
    plot.setData(columns, true);
    return;
  }
  plot.batch(() => {
    ["x", "y"].forEach((scale, index) => {
      const [min, max] = room(plot, ...ends(columns.slice(1).map((column) => column[index])));
      plot.setScale(scale, { min, max });
    });
  });
  if (panel.square) square(plot);
}

function ends(columns) {
  let [low, high] = [Infinity, -Infinity];
  for (const column of columns) {
    for (const value of column) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return [low, high];
}

/** Zoom (factor below 1) or move (share of the width) along x. */
function change(plot, factor, share) {
  const { min, max } = plot.scales.x;
  const log = plot.scales.x.distr === 3;
  const [low, high] = log ? [Math.log(min), Math.log(max)] : [min, max];
  const middle = (low + high) / 2 + share * (high - low);
  const half = (factor * (high - low)) / 2;
  const [left, right] = [middle - half, middle + half].map((end) => (log ? Math.exp(end) : end));
  plot.setScale("x", { min: left, max: right });
}

const KEYS = { "+": [0.5, 0], "=": [0.5, 0], "-": [2, 0], ArrowLeft: [1, -0.2], ArrowRight: [1, 0.2] };

async function add(panel) {
  const lines = await Promise.all(panel.lines.map(async (line) => ({
    ...line, x: await decode(line.x), y: await decode(line.y),
  })));
  const columns = panel.plane
    ? [null, ...lines.map(({ x, y }) => [x, y])]
    : together(lines, panel.form === "steps");
  if (panel.logarithmic) {
    for (const column of columns.slice(1)) column.forEach((value, row) => value > 0 || (column[row] = null));
  }
  const figure = document.createElement("figure");
  const caption = document.createElement("figcaption");
  caption.textContent = panel.title;
  caption.hidden = !panel.title;
  figure.append(caption);
  parent.append(figure);
  const plot = new uPlot(options(panel), columns, figure);
  whole(plot, panel, columns);
  const label = panel.lines.map((line) => line.label || panel.title || panel.y).join(", ");
  plot.root.tabIndex = 0;
  plot.root.setAttribute("role", "group");
  plot.root.setAttribute("aria-label", `Plot of ${label}: ${panel.y} over ${panel.x}`);
  plot.root.addEventListener("keydown", (event) => {
    if (event.key === "0") whole(plot, panel, columns);
    else if (event.key in KEYS) change(plot, ...KEYS[event.key]);
    else return;
    event.preventDefault();
  });
  plot.over.addEventListener("dblclick", () => whole(plot, panel, columns));
  plots.push({ plot, panel });
}

new ResizeObserver(() => {
  for (const { plot, panel } of plots) {
    plot.setSize({ width: parent.clientWidth, height: height(panel) });
    if (panel.square) square(plot);
  }
}).observe(parent);
onTheme(() => {
  for (const { plot } of plots) plot.redraw(false, true);
});

async function main() {
  for (const panel of panels) await add(panel);
  document.documentElement.dataset.ready = "yes";
}

// For whoever opens the console.
globalThis.figure = { panels, plots };

main().catch((error) => {
  const note = document.createElement("p");
  note.className = "outcome bad";
  note.textContent = `This page could not be drawn: ${error.message}`;
  document.querySelector("main").prepend(note);
});
