// What the theory says at the present knobs: the spectral radius, and where it passes 1.

import { colours, user } from "./theme.js";

const SIZE = [220, 120];
const ROOM = [34, 8, 8, 22]; // left, top, right, bottom (px)
const FINE = 48;

/** The radius at some knobs (values by key), linear between the points of the grid. */
export function radiusAt(theory, values) {
  let corners = [[0, 1]];
  for (const [key, levels] of theory.axes) {
    const value = Math.min(levels.at(-1), Math.max(levels[0], values[key]));
    let low = levels.findLastIndex((level) => level <= value);
    low = Math.max(0, Math.min(low, levels.length - 2));
    const share = (value - levels[low]) / (levels[low + 1] - levels[low]);
    corners = corners.flatMap(([place, weight]) => [
      [place * levels.length + low, weight * (1 - share)],
      [place * levels.length + low + 1, weight * share],
    ]);
  }
  return corners.reduce((sum, [place, weight]) => sum + weight * theory.radii[place], 0);
}

/** The slowest modes ``[[factor a second, Hz], ...]`` at the grid's nearest point. */
export function modesAt(theory, values) {
  const nearest = (levels, value) => levels.reduce((best, level, index) =>
    (Math.abs(level - value) < Math.abs(levels[best] - value) ? index : best), 0);
  const place = theory.axes.reduce((sum, [key, levels]) => sum * levels.length + nearest(levels, values[key]), 0);
  return theory.modes[place];
}

/** A map over delay and stiffness at the other knobs: unstable shaded, its boundary, where we are. */
export function drawMap(canvas, theory, values) {
  const ratio = devicePixelRatio || 1;
  canvas.width = SIZE[0] * ratio;
  canvas.height = SIZE[1] * ratio;
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  const [left, top, right, bottom] = ROOM;
  const [width, height] = [SIZE[0] - left - right, SIZE[1] - top - bottom];
  const [[delay, delays], [stiffness, levels]] = theory.axes;
  const most = delays.at(-1);
  const [least, stiffest] = [levels[0], levels.at(-1)];
  const unstable = (i, j) => radiusAt(theory, {
    ...values, [delay]: (i / FINE) * most, [stiffness]: least + (j / FINE) * (stiffest - least),
  }) >= 1;
  const at = (i, j) => [left + (i / FINE) * width, top + height - (j / FINE) * height];
  pen.fillStyle = colours.loss;
  pen.strokeStyle = colours.ink;
  pen.lineWidth = 1.5;
  for (let i = 0; i < FINE; i++) {
    for (let j = 0; j < FINE; j++) {
      const here = unstable(i, j);
      const [x, y] = at(i, j + 1);
      const [w, h] = [width / FINE, height / FINE];
      if (here) {
        pen.globalAlpha = 0.25;
        pen.fillRect(x, y, w + 0.3, h + 0.3);
        pen.globalAlpha = 1;
      }
      if (i + 1 < FINE && unstable(i + 1, j) !== here) line(pen, x + w, y, x + w, y + h);
      if (j + 1 < FINE && unstable(i, j + 1) !== here) line(pen, x, y, x + w, y);
    }
  }
  pen.strokeStyle = colours.line;
  pen.lineWidth = 1;
  pen.strokeRect(left, top, width, height);
  pen.fillStyle = colours.soft;
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "center";
  for (const n of delays) pen.fillText(n, left + (n / most) * width, SIZE[1] - 8);
  pen.textAlign = "right";
  pen.fillText(stiffest, left - 4, top + 9);
  pen.fillText(least, left - 4, top + height);
  const x = left + (values[delay] / most) * width;
  const y = top + height - ((values[stiffness] - least) / (stiffest - least)) * height;
  pen.fillStyle = user(0);
  pen.beginPath();
  pen.arc(x, y, 5, 0, 7);
  pen.fill();
  pen.strokeStyle = colours.ground;
  pen.lineWidth = 2;
  pen.stroke();
}

function line(pen, ...ends) {
  pen.beginPath();
  pen.moveTo(ends[0], ends[1]);
  pen.lineTo(ends[2], ends[3]);
  pen.stroke();
}
