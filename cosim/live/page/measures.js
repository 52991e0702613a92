// What is counted of the last moments: force ripple, saturation, packets.

/** Rms (N) of what is left of a force beside its running mean over a window of rows. */
export function ripple(x, y, rows) {
  return Math.hypot(deviation(x, rows), deviation(y, rows));
}

function deviation(values, rows) {
  const half = rows >> 1;
  const sums = new Float64Array(values.length + 1);
  for (let i = 0; i < values.length; i++) sums[i + 1] = sums[i] + (values[i] ?? 0);
  let total = 0;
  let count = 0;
  for (let i = half; i + half < values.length; i++) {
    const mean = (sums[i + half + 1] - sums[i - half]) / (2 * half + 1);
    total += (values[i] - mean) ** 2;
    count += 1;
  }
  return count ? Math.sqrt(total / count) : NaN;
}

/** Share of rows in which a force is at its limit. */
export function saturation(x, y, limit) {
  if (!limit || !x.length) return NaN;
  let count = 0;
  for (let i = 0; i < x.length; i++) count += Math.hypot(x[i], y[i]) >= 0.999 * limit;
  return count / x.length;
}

/** Mean age (ticks) and share of packets that never came, by the numbers of those held. */
export function packets(ages, sequences) {
  let age = 0;
  let known = 0;
  let arrived = 0;
  let before = null;
  let first = null;
  for (let i = 0; i < sequences.length; i++) {
    if (ages[i] === null || sequences[i] === null || sequences[i] < 0) continue;
    age += ages[i];
    known += 1;
    if (sequences[i] !== before) {
      if (before === null) first = sequences[i];
      else arrived += 1;
      before = sequences[i];
    }
  }
  const sent = before === null ? 0 : before - first;
  return { age: known ? age / known : NaN, loss: sent ? 1 - arrived / sent : NaN };
}

/** The delay (ms) of the packet held at each row: its age when it came; ``scale`` is ms a tick. */
export function delays(ages, sequences, scale) {
  let held = null;
  let delay = null;
  return ages.map((age, row) => {
    const number = sequences[row];
    if (age === null || number === null || number < 0) return null;
    if (number !== held) {
      // Where rows were thinned, the least of a few is the age with which it came.
      const near = [age, ages[row - 1], ages[row + 1]].filter((each) => each != null);
      if (held !== null) delay = Math.min(...near) * scale;
      held = number;
    }
    return delay;
  });
}

/** The delay at rows where a packet came and one before it never did; null elsewhere. */
export function losses(ages, sequences, scale) {
  let held = null;
  return ages.map((age, row) => {
    const number = sequences[row];
    if (age === null || number === null || number < 0) return null;
    const lost = held !== null && number > held + 1;
    held = number;
    return lost ? age * scale : null;
  });
}

/** Median and 99th percentile of the newest values. */
export class Quantiles {
  #values = [];

  add(value) {
    this.#values.push(value);
    if (this.#values.length > 2000) this.#values.splice(0, 1000);
  }

  get count() {
    return this.#values.length;
  }

  at(share) {
    const sorted = this.#values.toSorted((a, b) => a - b);
    return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? NaN;
  }
}
