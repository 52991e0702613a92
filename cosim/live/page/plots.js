// Live plots: forces, packets, energies and any signal, over one window that can be held and zoomed.

import uPlot from "/vendor/uPlot.js";
import { colours, onTheme, user } from "./theme.js";

const HEIGHT = 150;
const DASHES = [[], [7, 4], [2, 3], [9, 3, 2, 3]];
const SYNC = uPlot.sync("time");

export class Plots {
  #parent;
  #store;
  #plots = [];
  #held = false;
  #turn = 0;
  seconds = 5;
  begin = 0; // model time (s) of the run's first tick
  onHold = () => {};

  constructor(parent, store) {
    this.#parent = parent;
    this.#store = store;
    new ResizeObserver(() => this.#resize()).observe(parent);
    onTheme(() => {
      for (const each of this.#plots) each.plot?.redraw(false, true);
    });
  }

  clear() {
    for (const each of this.#plots) each.remove();
    this.#plots = [];
  }

  /** A plot of lines ``{names, label, colour, dash}``; ``combine`` makes one value of several names. */
  add(title, unit, lines, combine = (values) => values[0]) {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.append(unit ? `${title} (${unit})` : title);
    figure.append(caption);
    this.#parent.append(figure);
    const plot = new uPlot(this.#options(lines), [[], ...lines.map(() => [])], figure);
    const entry = {
      plot, lines, combine,
      remove: () => {
        plot.destroy();
        figure.remove();
      },
    };
    this.#plots.push(entry);
    return entry;
  }

  remove(entry) {
    entry.remove();
    this.#plots = this.#plots.filter((each) => each !== entry);
  }

  get signals() {
    return [...new Set(this.#plots.flatMap((each) => each.lines.flatMap((line) => line.names)))];
  }

  get held() {
    return this.#held;
  }

  hold(held) {
    if (held === this.#held) return;
    this.#held = held;
    this.onHold(held);
  }

  get count() {
    return this.#plots.length;
  }

  /** The times (s) that are shown last; null before that. */
  get times() {
    const { min, max } = this.#plots[this.#turn]?.plot.scales.x ?? {};
    return min == null ? null : { min, max };
  }

  /** The times (s) to show: none before the run began, where the lines grow into the room. */
  #window(time) {
    const min = Math.max(this.begin, time - this.seconds);
    return { min, max: Math.max(time, min + this.seconds) };
  }

  /** Draw one plot, each in its turn. */
  drawNext(time) {
    if (this.#held || document.hidden || !this.#plots.length) return;
    this.#turn = (this.#turn + 1) % this.#plots.length;
    const { plot, lines, combine } = this.#plots[this.#turn];
    const window = this.#window(time);
    const names = [...new Set(lines.flatMap((line) => line.names))];
    const found = this.#store.since(names, window.min);
    if (!found) return;
    const columns = new Map(names.map((name, index) => [name, found[index + 1]]));
    const drawn = lines.map((line) => {
      const parts = line.names.map((name) => columns.get(name));
      if (line.whole) return line.whole(parts);
      return parts.length === 1 && !line.combine ? parts[0] : found[0].map((_, row) => (line.combine ?? combine)(parts.map((part) => part[row])));
    });
    plot.setData([found[0], ...drawn], false);
    plot.batch(() => {
      plot.setScale("x", window);
      plot.setScale("y", range(drawn));
    });
  }

  #resize() {
    const width = this.#parent.clientWidth;
    for (const { plot } of this.#plots) plot.setSize({ width, height: HEIGHT });
  }

  #options(lines) {
    const axis = {
      stroke: () => colours.soft,
      grid: { stroke: () => colours.faint, width: 1 },
      ticks: { stroke: () => colours.faint, width: 1 },
      font: "12px system-ui, sans-serif",
    };
    return {
      width: this.#parent.clientWidth || 300,
      height: HEIGHT,
      legend: {
        live: false,
        markers: { dash: (_, index) => (lines[index - 1]?.dash ? "dashed" : "solid") },
      },
      cursor: { sync: { key: SYNC.key }, points: { show: false } },
      scales: { x: { time: false, auto: false }, y: { auto: false } },
      axes: [
        { ...axis, size: 26, values: (_, ticks) => ticks.map((tick) => `${+tick.toFixed(3)} s`) },
        { ...axis, size: width, values: (_, ticks) => ticks.map((tick) => `${+tick.toPrecision(6)}`) },
      ],
      series: [
        {},
        ...lines.map((line, index) => ({
          label: line.label,
          stroke: () => (line.points ? colours.loss : user(line.colour ?? index)),
          dash: DASHES[(line.dash ?? 0) % DASHES.length],
          width: 1.5,
          spanGaps: false,
          points: line.points
            ? { show: true, size: 5, stroke: () => colours.loss, fill: () => colours.loss }
            : { show: false },
          paths: line.points ? () => null : line.stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
        })),
      ],
      hooks: {
        setSelect: [(plot) => {
          if (plot.select.width > 2) this.hold(true);
        }],
        ready: [(plot) => plot.over.addEventListener("dblclick", () => this.hold(false))],
      },
    };
  }
}

/** Room (px) for the longest label of an axis. */
function width(_, labels) {
  return 16 + 7 * Math.max(4, ...(labels ?? []).map((text) => text.length));
}

function range(columns) {
  let low = Infinity;
  let high = -Infinity;
  for (const column of columns) {
    for (const value of column) {
      if (value === null || value === undefined) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return { min: 0, max: 1 };
  const room = Math.max(0.06 * (high - low), 1e-6, 1e-3 * Math.abs(high));
  return { min: low - room, max: high + room };
}
