// Rows of the plotted signals, as they came: times (s) and values by record group.

const KEPT_SECONDS = 60;

export class Store {
  #groups = new Map();

  clear() {
    this.#groups.clear();
  }

  add(entries) {
    for (const { g, t, y } of entries) {
      const group = this.#group(g);
      const before = group.t.length;
      group.t.push(...t);
      for (const name of Object.keys(y)) {
        if (!group.y.has(name)) group.y.set(name, new Array(before).fill(null));
      }
      for (const [name, kept] of group.y) {
        const values = y[name];
        if (values) kept.push(...values);
        else for (let i = 0; i < t.length; i++) kept.push(null);
      }
      this.#trim(group);
    }
  }

  /** Times and values of some signals of one group from a time on; null where nothing is there. */
  since(names, start) {
    for (const group of this.#groups.values()) {
      const known = names.filter((name) => group.y.has(name));
      if (!known.length) continue;
      const first = lowerBound(group.t, start);
      return [
        group.t.slice(first),
        ...names.map((name) => group.y.get(name)?.slice(first) ?? new Array(group.t.length - first).fill(null)),
      ];
    }
    return null;
  }

  #group(number) {
    if (!this.#groups.has(number)) this.#groups.set(number, { t: [], y: new Map() });
    return this.#groups.get(number);
  }

  #trim(group) {
    const last = group.t.at(-1);
    if (last - group.t[0] < 1.5 * KEPT_SECONDS) return;
    const first = lowerBound(group.t, last - KEPT_SECONDS);
    group.t.splice(0, first);
    for (const values of group.y.values()) values.splice(0, first);
  }
}

function lowerBound(sorted, wanted) {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}
