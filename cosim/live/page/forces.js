// The forces that fingers are given: of two worlds, in the share in which they are passed on.

/** For each finger of a person ``{finger, names, given}``; ``given`` makes [x, y] of the names' values. */
export function forcesOf(fingers) {
  const found = new Map();
  for (const finger of fingers.filter((each) => each.force.length)) {
    const key = finger.share === undefined ? finger.name : `${finger.station} ${finger.finger}`;
    found.set(key, [...(found.get(key) ?? []), finger].toSorted((a, b) => (a.world ?? 0) - (b.world ?? 0)));
  }
  return [...found.values()].map(([finger, other]) => (other
    ? { finger, names: [...finger.force, ...other.force, finger.share], given: blended }
    : { finger, names: finger.force, given: alone }));
}

function alone([x, y]) {
  return [x, y];
}

function blended([x1, y1, x2, y2, share]) {
  if ([x1, y1, x2, y2, share].some((value) => value === null || value === undefined)) return [null, null];
  return [(1 - share) * x1 + share * x2, (1 - share) * y1 + share * y2];
}
