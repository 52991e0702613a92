// A hand: where this page's user wants the two fingers, from mouse, touch, keys or a gamepad.
//
// One mouse is a pinch: both fingers around the pointer, closed by its button, the space bar or the
// wheel. Two touches are a finger each. It says where it is in every frame, moving or not: silence
// means that nobody is there, and a hidden page is silent.

const OPEN = 0.065; // half the gap between the fingers (m) when open ...
const CLOSED = 0.027; // ... and when closed: 23 mm inside the faces of a box of 10 cm
const CLOSE_SPEED = 0.16; // m/s
const FASTEST = 0.8; // m/s of the middle
const KEY_SPEED = 0.08;
const STICK_SPEED = 0.15;
const LEAST_MS = 4; // between two messages
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Hand {
  #canvas;
  #scene;
  #say;
  #reach = null;
  #axis = [1, 0];
  #middle = null;
  #goal = null;
  #half = OPEN;
  #wanted = OPEN;
  #touches = new Map();
  #keys = new Set();
  #pressed = false;
  #before = 0;
  #sent = 0;
  here = false; // whether somebody has touched anything yet
  events = new Set(); // times of real events that were sent, to measure the way to the picture

  constructor(canvas, scene, say) {
    this.#canvas = canvas;
    this.#scene = scene;
    this.#say = say;
    const raw = "onpointerrawupdate" in canvas ? "pointerrawupdate" : "pointermove";
    canvas.addEventListener(raw, (event) => this.#moved(event));
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => this.#up(event));
    }
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event, true));
    canvas.addEventListener("keyup", (event) => this.#key(event, false));
    canvas.addEventListener("blur", () => this.#keys.clear());
  }

  /** The reach of the user's fingers ``[[x, y, radius], ...]``, or null: this page only looks on. */
  take(reach) {
    const same = JSON.stringify(reach) === JSON.stringify(this.#reach);
    this.#reach = reach;
    this.#canvas.classList.toggle("plays", reach !== null);
    if (same) return;
    this.here = false;
    this.#touches.clear();
    this.#middle = this.#goal = null;
    this.#half = this.#wanted = OPEN;
    if (reach) {
      const [a, b] = reach;
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const length = Math.hypot(dx, dy);
      this.#axis = length > 1e-6 ? [dx / length, dy / length] : [1, 0];
      this.#goal = this.#middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    }
  }

  /** Forget what was touched: a fresh run begins, with its emulated hand. */
  forget() {
    const reach = this.#reach;
    this.#reach = null;
    this.take(reach);
  }

  /** Called every frame: move on, and say where the fingers should be. */
  frame() {
    if (!this.#reach || document.hidden) return;
    const now = performance.now();
    const step = Math.min(0.05, (now - this.#before) * 1e-3);
    this.#before = now;
    this.#keysAndSticks(step);
    if (!this.here) return;
    this.#advance(step);
    this.#send(now);
  }

  /** Where the fingers should be: x, y of each (m). */
  get fingers() {
    if (!this.#reach || !this.here || !this.#middle) return null;
    const touched = [...this.#touches.values()];
    if (touched.length === 2) {
      const along = (p) => p[0] * this.#axis[0] + p[1] * this.#axis[1];
      return touched.toSorted((p, q) => along(p) - along(q)).map((p, n) => clamp(p, this.#reach[n]));
    }
    return [-1, 1].map((side) => [
      this.#middle[0] + side * this.#half * this.#axis[0],
      this.#middle[1] + side * this.#half * this.#axis[1],
    ]);
  }

  #advance(step) {
    const [dx, dy] = [this.#goal[0] - this.#middle[0], this.#goal[1] - this.#middle[1]];
    const share = Math.min(1, (FASTEST * step) / Math.max(Math.hypot(dx, dy), 1e-9));
    this.#middle = [this.#middle[0] + share * dx, this.#middle[1] + share * dy];
    const way = this.#wanted - this.#half;
    this.#half += Math.sign(way) * Math.min(Math.abs(way), CLOSE_SPEED * step);
  }

  #moved(event) {
    if (!this.#reach) return;
    const newest = event.getCoalescedEvents?.().at(-1) ?? event;
    const place = this.#scene.world(newest.clientX, newest.clientY);
    this.here = true;
    if (event.pointerType === "touch" && this.#touches.has(event.pointerId)) {
      this.#touches.set(event.pointerId, place);
    }
    if (event.pointerType !== "touch" || this.#touches.size < 2) this.#goal = this.#within(place);
    const now = performance.now();
    const step = Math.min(0.05, (now - this.#before) * 1e-3);
    this.#before = now;
    this.#advance(step);
    if (now - this.#sent >= LEAST_MS) this.#send(newest.timeStamp || now, true);
  }

  #down(event) {
    if (!this.#reach) return;
    this.#canvas.focus({ preventScroll: true });
    this.#canvas.setPointerCapture?.(event.pointerId);
    this.here = true;
    const place = this.#scene.world(event.clientX, event.clientY);
    if (event.pointerType === "touch") this.#touches.set(event.pointerId, place);
    this.#goal = this.#within(place);
    this.#grip(true);
    event.preventDefault();
  }

  #up(event) {
    this.#touches.delete(event.pointerId);
    if (this.#reach && this.#touches.size === 0) this.#grip(false);
  }

  #grip(closed) {
    this.#pressed = closed;
    this.#wanted = closed ? CLOSED : OPEN;
  }

  #wheel(event) {
    if (!this.#reach) return;
    event.preventDefault();
    this.here = true;
    this.#wanted = Math.min(OPEN, Math.max(CLOSED, this.#wanted + Math.sign(event.deltaY) * 0.006));
  }

  #key(event, down) {
    if (!this.#reach) return;
    if (event.key === " ") {
      if (!event.repeat) this.#grip(down);
    } else if (event.key in KEYS) {
      this.#keys[down ? "add" : "delete"](event.key);
    } else return;
    this.here = true;
    event.preventDefault();
  }

  #keysAndSticks(step) {
    let [x, y] = [0, 0];
    for (const key of this.#keys) {
      x += KEYS[key][0] * KEY_SPEED;
      y += KEYS[key][1] * KEY_SPEED;
    }
    const pad = navigator.getGamepads?.().find((each) => each?.connected);
    if (pad) {
      const [sx, sy] = pad.axes;
      if (Math.hypot(sx, sy) > 0.15) {
        x += sx * STICK_SPEED;
        y -= sy * STICK_SPEED;
      }
      const closed = pad.buttons.some((button) => button.pressed);
      if (closed !== this.#padClosed) {
        this.#padClosed = closed;
        this.#grip(closed);
        this.here = true;
      }
    }
    if (x || y) {
      this.here = true;
      this.#goal = this.#within([this.#goal[0] + x * step, this.#goal[1] + y * step]);
    }
  }

  #padClosed = false;

  /** The nearest middle at which both fingers stay in reach. */
  #within(place) {
    const middle = [...place];
    for (let round = 0; round < 4; round++) {
      this.#reach.forEach((disc, index) => {
        const side = (index ? 1 : -1) * OPEN;
        const finger = [middle[0] + side * this.#axis[0], middle[1] + side * this.#axis[1]];
        const inside = clamp(finger, disc);
        middle[0] += inside[0] - finger[0];
        middle[1] += inside[1] - finger[1];
      });
    }
    return middle;
  }

  #send(time, isEvent = false) {
    const [a, b] = this.fingers;
    this.#sent = performance.now();
    const stamp = Math.round(time * 1000) / 1000;
    if (isEvent) {
      this.events.add(stamp);
      if (this.events.size > 500) this.events.delete(this.events.values().next().value);
    }
    this.#say({ hand: [stamp, ...a, ...b].map((each) => Math.round(each * 1e6) / 1e6) });
  }
}

function clamp([x, y], [cx, cy, radius]) {
  const away = Math.hypot(x - cx, y - cy);
  if (away <= radius) return [x, y];
  return [cx + ((x - cx) * radius) / away, cy + ((y - cy) * radius) / away];
}
