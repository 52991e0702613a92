// The scene on a canvas: copies of the box, fingers, linkages, forces, walls, trails.

import { colours, user } from "./theme.js";

export const STATES = ["free", "first touch", "sticking", "sliding"];
const FORCE_SCALE = 0.02; // metres drawn for a newton
const TRAIL_SECONDS = 1.5;
const SOFT = 2e-4; // metres a node is off its square before the lattice is drawn
const MARGIN = 0.03;

export class Scene {
  #canvas;
  #context;
  #scene = null;
  #place = new Map();
  #values = [];
  #trails = new Map();
  #bounds = null;
  #lines = new Map();
  own = null; // the station whose copy is drawn whole; the others are ghosts
  hand = null; // where this page's pointer wants the fingers

  constructor(canvas) {
    this.#canvas = canvas;
    this.#context = canvas.getContext("2d");
    new ResizeObserver(() => this.#resize()).observe(canvas);
    this.#resize();
  }

  show(scene, values) {
    this.#scene = scene;
    this.#place = new Map(values.map((name, index) => [name, index]));
    this.#trails.clear();
    this.#values = [];
    const stations = [
      ...new Set([...scene.boxes, ...scene.fingers].map((each) => each.station)),
    ];
    this.#lines = new Map(stations.map((name, index) => [name, index]));
    this.#bounds = null;
  }

  /** The number of a station's colour. */
  colourOf(station) {
    return this.#lines.get(station) ?? 0;
  }

  take(time, values) {
    this.#values = values;
    for (const each of [...this.#scene.fingers, ...this.#scene.boxes]) {
      const point = this.#pair(each.position ?? each.pose);
      if (!point) continue;
      const trail = this.#trails.get(each.name) ?? [];
      trail.push([time, ...point]);
      while (trail.length && (trail[0][0] < time - TRAIL_SECONDS || trail[0][0] > time)) trail.shift();
      this.#trails.set(each.name, trail);
    }
  }

  value(name) {
    return name === null || name === undefined ? null : this.#values[this.#place.get(name)] ?? null;
  }

  /** Whether a finger or box is of the world whose torques are passed on; of two there is one. */
  inUse(each) {
    if (each.share === undefined) return true;
    const share = this.value(each.share);
    return share === null ? each.world === 0 : (share >= 0.5) === (each.world === 1);
  }

  get fingers() {
    return this.#scene?.fingers.filter((each) => this.inUse(each)) ?? [];
  }

  get boxes() {
    return this.#scene?.boxes.filter((each) => this.inUse(each)) ?? [];
  }

  /** World coordinates (m) of a place in the window. */
  world(clientX, clientY) {
    const box = this.#canvas.getBoundingClientRect();
    const view = this.#view();
    return [
      (clientX - box.left - box.width / 2) / view.scale + view.x,
      -(clientY - box.top - box.height / 2) / view.scale + view.y,
    ];
  }

  draw() {
    const scene = this.#scene;
    const pen = this.#context;
    const ratio = devicePixelRatio || 1;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = colours.ground;
    pen.fillRect(0, 0, this.#canvas.width, this.#canvas.height);
    if (!scene || !this.#values.length) return;
    const view = this.#view();
    pen.setTransform(ratio, 0, 0, ratio, this.#canvas.width / 2, this.#canvas.height / 2);
    this.#at = (x, y) => [(x - view.x) * view.scale, -(y - view.y) * view.scale];
    this.#metre = view.scale;
    pen.lineJoin = pen.lineCap = "round";
    pen.font = "13px system-ui, sans-serif";
    this.#grid(view);
    for (const wall of scene.walls) this.#wall(wall, view);
    const { boxes, fingers } = this;
    const own = boxes.find((box) => box.station === this.own) ?? boxes[0];
    for (const box of boxes) if (box !== own) this.#box(box, true);
    if (own) this.#box(own, false);
    for (const finger of fingers) if (finger.device) this.#linkage(finger);
    for (const each of [...fingers, ...boxes]) this.#trail(each);
    for (const finger of fingers) this.#finger(finger, this.#copyOf(finger));
    for (const point of this.hand ?? []) this.#cross(point);
    scene.bodies.forEach((body, index) => this.#body(body, index));
    this.#scales(view);
  }

  #at = () => [0, 0];
  #metre = 1;

  #resize() {
    const ratio = devicePixelRatio || 1;
    const box = this.#canvas.getBoundingClientRect();
    this.#canvas.width = Math.max(1, Math.round(box.width * ratio));
    this.#canvas.height = Math.max(1, Math.round(box.height * ratio));
    this.draw();
  }

  #pair(names) {
    if (!names?.length) return null;
    const found = [this.value(names[0]), this.value(names[1])];
    return found[0] === null || found[1] === null ? null : found;
  }

  /** Middle of the picture and pixels in a metre: everything that stands still, and room to move. */
  #view() {
    if (!this.#bounds) this.#bounds = this.#extent();
    const [left, bottom, right, top] = this.#bounds;
    const box = this.#canvas.getBoundingClientRect();
    const scale = Math.min(box.width / (right - left), box.height / (top - bottom));
    return { x: (left + right) / 2, y: (bottom + top) / 2, scale, width: box.width, height: box.height };
  }

  #extent() {
    const scene = this.#scene;
    const points = [];
    for (const box of scene.boxes) {
      const place = this.#pair(box.pose) ?? [0, 0];
      const reach = 1.3 * box.side;
      points.push([place[0] - reach, place[1] - reach], [place[0] + reach, place[1] + reach]);
    }
    for (const finger of scene.fingers) {
      if (finger.device) points.push(finger.device.base);
      points.push(this.#pair(finger.position) ?? [0, 0]);
    }
    for (const body of scene.bodies) {
      const x = this.value(body.position) ?? 0;
      points.push([x - 0.1, -0.1], [x + 0.1, 0.1]);
    }
    if (!points.length) points.push([-0.2, -0.2], [0.2, 0.2]);
    const xs = points.map((point) => point[0]);
    const ys = points.map((point) => point[1]);
    return [
      Math.min(...xs) - MARGIN, Math.min(...ys) - MARGIN,
      Math.max(...xs) + MARGIN, Math.max(...ys) + MARGIN,
    ];
  }

  #path(points, closed = false) {
    const pen = this.#context;
    pen.beginPath();
    points.forEach((point, index) => pen[index ? "lineTo" : "moveTo"](...this.#at(...point)));
    if (closed) pen.closePath();
  }

  #grid(view) {
    const pen = this.#context;
    pen.strokeStyle = colours.faint;
    pen.lineWidth = 1;
    const step = 0.05;
    const halfX = view.width / 2 / view.scale;
    const halfY = view.height / 2 / view.scale;
    for (let x = Math.ceil((view.x - halfX) / step) * step; x < view.x + halfX; x += step) {
      this.#path([[x, view.y - halfY], [x, view.y + halfY]]);
      pen.stroke();
    }
    for (let y = Math.ceil((view.y - halfY) / step) * step; y < view.y + halfY; y += step) {
      this.#path([[view.x - halfX, y], [view.x + halfX, y]]);
      pen.stroke();
    }
  }

  #wall([x, y, nx, ny]) {
    const pen = this.#context;
    const size = Math.hypot(nx, ny) || 1;
    const [tx, ty] = [-ny / size, nx / size];
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 3;
    this.#path([[x - 2 * tx, y - 2 * ty], [x + 2 * tx, y + 2 * ty]]);
    pen.stroke();
    pen.lineWidth = 1;
    for (let s = -1; s < 1; s += 0.015) {
      const [px, py] = [x + s * tx, y + s * ty];
      this.#path([[px, py], [px - 0.012 * (nx / size + tx), py - 0.012 * (ny / size + ty)]]);
      pen.stroke();
    }
  }

  #corners(box) {
    const [x, y] = this.#pair(box.pose) ?? [0, 0];
    const angle = this.value(box.pose[2]) ?? 0;
    const [c, s, h] = [Math.cos(angle), Math.sin(angle), box.side / 2];
    return [[-h, -h], [h, -h], [h, h], [-h, h]].map(([u, v]) => [x + c * u - s * v, y + s * u + c * v]);
  }

  #box(box, ghost) {
    const pen = this.#context;
    const corners = this.#corners(box);
    const nodes = this.#nodes(box);
    const outline = nodes && isSoft(nodes) ? [0, 1, 2, 5, 8, 7, 6, 3].map((i) => nodes[i]) : corners;
    const colour = user(this.colourOf(box.station));
    this.#path(outline, true);
    if (!ghost) {
      pen.globalAlpha = 0.16;
      pen.fillStyle = colour;
      pen.fill();
      pen.globalAlpha = 1;
    }
    pen.setLineDash(ghost ? [7, 5] : []);
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.stroke();
    pen.setLineDash([]);
    if (outline !== corners) this.#lattice(nodes);
    const depth = this.value(box.penetration);
    if (!ghost && depth > 1e-6) {
      const [x, y] = this.#at(...this.#pair(box.pose));
      pen.fillStyle = colours.ink;
      pen.textAlign = "center";
      pen.fillText(`${(depth * 1e3).toFixed(2)} mm in the wall`, x, y + 4);
    }
  }

  #nodes(box) {
    if (box.nodes.length !== 18) return null;
    const flat = box.nodes.map((name) => this.value(name));
    if (flat.some((each) => each === null)) return null;
    return Array.from({ length: 9 }, (_, index) => [flat[2 * index], flat[2 * index + 1]]);
  }

  #lattice(nodes) {
    const pen = this.#context;
    pen.strokeStyle = colours.line;
    pen.lineWidth = 1;
    const edges = [];
    for (let row = 0; row < 3; row++) {
      for (let column = 0; column < 3; column++) {
        const here = 3 * row + column;
        if (column < 2) edges.push([here, here + 1]);
        if (row < 2) edges.push([here, here + 3]);
        if (row < 2 && column < 2) edges.push([here, here + 4], [here + 1, here + 3]);
      }
    }
    for (const [a, b] of edges) {
      this.#path([nodes[a], nodes[b]]);
      pen.stroke();
    }
    pen.fillStyle = colours.ink;
    for (const node of nodes) this.#dot(node, 2.5);
  }

  #dot(point, radius) {
    const pen = this.#context;
    pen.beginPath();
    pen.arc(...this.#at(...point), radius, 0, 7);
    pen.fill();
  }

  /** A word that can be read over whatever is drawn beneath it. */
  #text(word, x, y) {
    const pen = this.#context;
    pen.strokeStyle = colours.ground;
    pen.fillStyle = colours.ink;
    pen.lineWidth = 4;
    pen.lineJoin = "round";
    pen.strokeText(word, x, y);
    pen.fillText(word, x, y);
  }

  #linkage(finger) {
    const tip = this.#pair(finger.position);
    const angles = this.#pair(finger.device.angles);
    if (!tip || !angles) return;
    const pen = this.#context;
    const { base: [x, y, turn], proximal, distance } = finger.device;
    const motors = [[x, y], [x + distance * Math.cos(turn), y + distance * Math.sin(turn)]];
    pen.strokeStyle = pen.fillStyle = user(this.colourOf(finger.station));
    pen.globalAlpha = 0.35;
    motors.forEach((motor, index) => {
      const angle = turn + angles[index];
      const elbow = [motor[0] + proximal * Math.cos(angle), motor[1] + proximal * Math.sin(angle)];
      pen.lineWidth = 4;
      this.#path([motor, elbow]);
      pen.stroke();
      pen.lineWidth = 2.5;
      this.#path([elbow, tip]);
      pen.stroke();
      this.#dot(motor, 6);
      this.#dot(elbow, 3.5);
    });
    pen.globalAlpha = 1;
  }

  #trail(each) {
    const trail = this.#trails.get(each.name);
    if (!trail || trail.length < 2) return;
    const pen = this.#context;
    pen.strokeStyle = user(this.colourOf(each.station));
    pen.lineWidth = 1.2;
    pen.globalAlpha = 0.55;
    this.#path(trail.map(([, x, y]) => [x, y]));
    pen.stroke();
    pen.globalAlpha = 1;
  }

  /** The copy of the box that a finger touches: its own component's, or its station's, or any. */
  #copyOf(finger) {
    const { boxes } = this;
    return boxes.find((box) => box.name === finger.component)
      ?? boxes.find((box) => box.station === finger.station) ?? boxes[0] ?? null;
  }

  /** Depth in the box, its face's outward normal and the face's point nearest to a finger. */
  #contact(point, box) {
    const [x, y] = this.#pair(box.pose) ?? [0, 0];
    const angle = this.value(box.pose[2]) ?? 0;
    const [c, s, h] = [Math.cos(angle), Math.sin(angle), box.side / 2];
    const u = c * (point[0] - x) + s * (point[1] - y);
    const v = -s * (point[0] - x) + c * (point[1] - y);
    const alongX = Math.abs(u) > Math.abs(v);
    const normal = alongX ? [Math.sign(u), 0] : [0, Math.sign(v)];
    const depth = h - Math.max(Math.abs(u), Math.abs(v));
    const turned = [c * normal[0] - s * normal[1], s * normal[0] + c * normal[1]];
    const foot = [point[0] + depth * turned[0], point[1] + depth * turned[1]];
    return { depth, normal: turned, foot };
  }

  #finger(finger, box) {
    const point = this.#pair(finger.position);
    if (!point) return;
    const pen = this.#context;
    const colour = user(this.colourOf(finger.station));
    const force = this.#pair(finger.force) ?? [0, 0];
    const size = Math.hypot(...force);
    const told = this.value(finger.state);
    const state = told ?? (size > 0.02 ? 2 : 0);
    if (state !== 0 && box) this.#cone(point, box, colour);
    if (size > 0.02) this.#arrow(point, force, colour);
    const [x, y] = this.#at(...point);
    pen.beginPath();
    pen.arc(x, y, 8, 0, 7);
    mark(pen, x, y, state, colour);
    pen.textAlign = "center";
    const side = box && point[1] < (this.#pair(box.pose) ?? [0, 0])[1] ? 22 : -14;
    this.#text(label(finger), x, y + side);
  }

  #cone(point, box, colour) {
    const { depth, normal, foot } = this.#contact(point, box);
    const pen = this.#context;
    if (box.friction) {
      const half = Math.atan(box.friction);
      const angle = Math.atan2(-normal[1], normal[0]);
      pen.beginPath();
      const at = this.#at(...point);
      pen.moveTo(...at);
      pen.arc(...at, 0.045 * this.#metre, angle - half, angle + half);
      pen.closePath();
      pen.globalAlpha = 0.14;
      pen.fillStyle = colour;
      pen.fill();
      pen.globalAlpha = 1;
    }
    if (depth > 0) {
      pen.strokeStyle = colours.ink;
      pen.lineWidth = 3;
      this.#path([point, foot]);
      pen.stroke();
    }
  }

  #arrow(from, force, colour) {
    const pen = this.#context;
    const to = [from[0] + FORCE_SCALE * force[0], from[1] + FORCE_SCALE * force[1]];
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = 3;
    this.#path([from, to]);
    pen.stroke();
    const [x, y] = this.#at(...to);
    const angle = Math.atan2(-force[1], force[0]);
    pen.beginPath();
    pen.moveTo(x + 7 * Math.cos(angle), y + 7 * Math.sin(angle));
    for (const turn of [2.5, -2.5]) pen.lineTo(x + 7 * Math.cos(angle + turn), y + 7 * Math.sin(angle + turn));
    pen.closePath();
    pen.fill();
  }

  #cross([wx, wy]) {
    const pen = this.#context;
    const [x, y] = this.#at(wx, wy);
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.5;
    pen.beginPath();
    for (const [dx, dy] of [[1, 0], [0, 1]]) {
      pen.moveTo(x - 12 * dx, y - 12 * dy);
      pen.lineTo(x - 4 * dx, y - 4 * dy);
      pen.moveTo(x + 4 * dx, y + 4 * dy);
      pen.lineTo(x + 12 * dx, y + 12 * dy);
    }
    pen.stroke();
  }

  #body(body, index) {
    const x = this.value(body.position);
    if (x === null) return;
    const pen = this.#context;
    const count = this.#scene.bodies.length;
    // Below one another, however far they go and so however few pixels a metre has.
    const row = Math.max((0.16 / count) * this.#metre, 24);
    pen.fillStyle = user(index);
    const [px, middle] = this.#at(x, 0);
    const py = middle + (index + 0.5 - count / 2) * row;
    pen.fillRect(px - 12, py - 9, 24, 18);
    pen.textAlign = "left";
    this.#text(body.name, px + 18, py + 4);
  }

  #scales(view) {
    const pen = this.#context;
    const left = -view.width / 2 + 14;
    const bottom = view.height / 2 - 14;
    pen.fillStyle = pen.strokeStyle = colours.ink;
    pen.textAlign = "left";
    pen.lineWidth = 2;
    const rows = [[0.05, "5 cm"]];
    if (this.#scene.fingers.length) rows.push([FORCE_SCALE, "1 N"]);
    rows.forEach(([length, text], index) => {
      const y = bottom - 20 * index;
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(left + length * view.scale, y);
      pen.stroke();
      pen.fillText(text, left + length * view.scale + 8, y + 4);
    });
  }
}

/** A finger's name as it stands beside it. */
export function label(finger) {
  return `${finger.station.replace(/^station_/, "")}${finger.finger}`;
}

/** Fill and stroke the present circle for a contact state. */
export function mark(pen, x, y, state, colour) {
  pen.fillStyle = state === 0 ? colours.ground : state === 3 ? colours.slide : colour;
  pen.fill();
  pen.strokeStyle = state === 3 ? colours.slide : colour;
  pen.lineWidth = 2.5;
  pen.stroke();
  if (state === 1 || state === 3) {
    pen.strokeStyle = colours.ground;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(x - 4, y);
    pen.lineTo(x + 4, y);
    if (state === 1) {
      pen.moveTo(x, y - 4);
      pen.lineTo(x, y + 4);
    }
    pen.stroke();
  }
}

/** Whether any node is off the square that the corners make. */
function isSoft(nodes) {
  const [a, b, c, d] = [nodes[0], nodes[2], nodes[6], nodes[8]];
  return nodes.some(([x, y], index) => {
    const u = (index % 3) / 2;
    const v = Math.floor(index / 3) / 2;
    const square = [0, 1].map((k) => (1 - v) * ((1 - u) * a[k] + u * b[k]) + v * ((1 - u) * c[k] + u * d[k]));
    return Math.hypot(x - square[0], y - square[1]) > SOFT;
  });
}
