"""Stability of a whole plane of parameters at once, with no eigenvalue call.

Two stations in a loop share, at every delay, a(z) = det(zI − A) and q(z) = g adj(zI − A) b + d a of
their one-frame maps: the closed loop is zⁿ a₁ a₂ − q₁ q₂. The root z = 1 of the translation is
divided out, and a vectorised Schur–Cohn test decides every cell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cosim.theory.models.parameters import Parameters
from cosim.theory.models.station import Station, Value, hand_alone, object_station
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.numerics import Bool, Real
from cosim.theory.stability.schur_cohn import all_roots_inside, divide_by_z_minus_one, multiply
from cosim.theory.stability.spectral_radius import stability


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a map: a parameter and where it goes.

    Attributes:
        name: the parameter.
        values: shape (points,).
    """

    name: str
    values: Real

    @staticmethod
    def even(name: str, high: float, points: int = 201) -> Axis:
        """Evenly spaced from high/points to high: zero stiffness ties nothing together."""
        return Axis(name, np.linspace(0.0, high, points + 1)[1:])


def stability_maps(
    parameters: Parameters,
    timing: Timing,
    x: Axis,
    y: Axis,
    delays: Sequence[PathDelay | int],
) -> Bool:
    """Which cells of the plane are stable, for several delays.

    Two users and whole ratios go through the Schur–Cohn test, everything else through eigenvalues,
    cell by cell.

    Args:
        parameters: what does not vary.
        timing: rates; its delay is replaced.
        x: the horizontal axis.
        y: the vertical axis.
        delays: of the two directions, or a round trip of n network samples.

    Returns:
        Shape (delays, y points, x points).
    """
    for axis in (x, y):
        for end in (axis.values[0], axis.values[-1]):
            parameters.replaced({axis.name: float(end)})
    paths = [PathDelay.round_trip(one) if isinstance(one, int) else one for one in delays]
    if parameters.users > 2 or timing.ratio.denominator != 1:
        return _by_eigenvalues(parameters, timing, x, y, paths)
    columns, rows = np.meshgrid(x.values, y.values)
    values = _varied(parameters, {x.name: columns.ravel(), y.name: rows.ravel()})
    open_loop, feedback, neutral = _polynomials(parameters, values, timing)
    maps: list[Bool] = []
    for path in paths:
        polynomial = np.concatenate([open_loop, np.zeros((path.total, *open_loop.shape[1:]))])
        polynomial[polynomial.shape[0] - feedback.shape[0] :] -= feedback
        for _ in range(neutral):
            polynomial = divide_by_z_minus_one(polynomial)
        inside = np.broadcast_to(all_roots_inside(polynomial), (columns.size,))
        maps.append(inside.reshape(columns.shape))
    return np.array(maps)


def _varied(parameters: Parameters, varied: Mapping[str, Real]) -> dict[str, Value]:
    """Every leaf's value; an array over the cells where a varied name sets it."""
    marked = parameters.replaced(dict.fromkeys(varied, 1.0))
    values: dict[str, Value] = {}
    for leaf in marked.leaves:
        name = marked.source(leaf)
        values[leaf] = varied[name] if name in varied else parameters[leaf]
    return values


def _polynomials(
    parameters: Parameters, values: dict[str, Value], timing: Timing
) -> tuple[Real, Real, int]:
    """a₁ a₂ and q₁ q₂, highest power first, and how often z = 1 is to be divided out."""
    period = float(timing.control_period)
    samples = timing.samples_per_frame
    walls = (values["k_w"], values["b_w"])
    walled = bool(np.any(np.asarray(walls) != 0.0))
    grounded = bool(np.any(np.asarray(values["k_w"]) != 0.0))
    if parameters.architecture == "distributed":
        ends: list[tuple[Station, Real]] = []
        for m, r in ((1, 2), (2, 1)):
            held = [
                (
                    values[f"k_{m}{r}"] + values[f"k_o{m}"],
                    values[f"b_{m}{r}"] + values[f"b_o{m}"],
                )
            ]
            station = object_station(
                hand=(values[f"m_h{m}"], values[f"b_h{m}"]),
                local=(values[f"k_{m}{m}"], values[f"b_{m}{m}"]),
                object_mass=values[f"m_o{m}"],
                compensation=values[f"b_c{m}"],
                held=[*held, walls] if walled else held,
                period=period,
                computation_delay=timing.computation_delay,
            )
            sent = [values[f"k_{r}{m}"], values[f"b_{r}{m}"], values[f"k_o{r}"], values[f"b_o{r}"]]
            ends.append((station, _row(station, sent)))
        a_1, q_1 = _transfer(*ends[0], samples)
        a_2, q_2 = (a_1, q_1) if _alike(values) else _transfer(*ends[1], samples)
        return multiply(a_1, a_2), multiply(q_1, q_2), 0 if grounded else 1

    single = parameters.architecture == "single"
    held = [] if single else [(values["k_2"], values["b_2"])]
    server = object_station(
        hand=(values["m_h1"], values["b_h1"]),
        local=(values["k"], values["b"]) if single else (values["k_1"], values["b_1"]),
        object_mass=values["m_o"],
        compensation=values["b_c"],
        held=[*held, walls] if walled else held,
        period=period,
        computation_delay=timing.computation_delay,
    )
    if single:
        a, _ = _transfer(replace(server, B=server.A[..., :, :1]), server.A[..., 0, :], samples)
        free = all(bool(np.all(np.asarray(values[name]) == 0.0)) for name in ("b_h1", "b_c", "b_w"))
        return a, np.zeros((1, 1)), 0 if grounded else 2 if free else 1
    a_1, q_1 = _transfer(server, server.C[..., 0, :], samples, through=True)
    client = hand_alone(values["m_h2"], values["b_h2"], period=period)
    a_2, q_2 = _transfer(client, _row(client, [values["k_2"], values["b_2"]]), samples)
    return multiply(a_1, a_2), multiply(q_1, q_2), 0 if grounded else 1


def _alike(values: Mapping[str, Value]) -> bool:
    """Whether the two workstations are the same, as in every figure of chapter 5."""
    pairs = [
        (name, f"{name[:-1]}2") for name in values if name.endswith("1") and name[-2] not in "12"
    ]
    pairs += [(f"{kind}_11", f"{kind}_22") for kind in "kb"]
    pairs += [(f"{kind}_12", f"{kind}_21") for kind in "kb"]
    return all(
        values[one] is values[other]
        or (np.ndim(values[one]) == np.ndim(values[other]) == 0 and values[one] == values[other])
        for one, other in pairs
    )


def _row(station: Station, entries: list[Value]) -> Real:
    """A row over a station's state that begins with the given entries."""
    columns = np.broadcast_arrays(*(np.asarray(entry, dtype=np.float64) for entry in entries))
    row = np.zeros((*columns[0].shape, station.A.shape[-1]))
    for place, column in enumerate(columns):
        row[..., place] = column
    return row


def _transfer(
    station: Station, sent: Real, samples: int, *, through: bool = False
) -> tuple[Real, Real]:
    """a(z) = det(zI − A) and q(z) = g adj(zI − A) b (+ d a) of a station resampled to T_t (4.4).

    Cells come last, so that every operation runs over all of them at once.
    """
    tick = np.moveaxis(station.A, (-2, -1), (0, 1)).copy()
    push = np.moveaxis(station.B[..., :, 0], -1, 0).copy()
    row = np.moveaxis(sent, -1, 0)
    A, b = _resampled(tick, push, samples)
    n = A.shape[0]
    # Newton's identities: the characteristic polynomial from the traces of the powers of A.
    power, traces = A, [np.einsum("ii...->...", A)]
    powers = [A]
    for exponent in range(2, n + 1):
        half = powers[(exponent + 1) // 2 - 1]
        other = powers[exponent // 2 - 1]
        traces.append(np.einsum("ij...,ji...->...", half, other))
        if 2 * len(powers) < n:
            power = np.einsum("ij...,jk...->ik...", power, A)
            powers.append(power)
    a = [np.ones_like(traces[0])]
    for k in range(1, n + 1):
        total = np.zeros_like(traces[0])
        for back in range(1, k + 1):
            total += a[k - back] * traces[back - 1]
        a.append(-total / k)
    # adj(zI − A) b, coefficient by coefficient: v_0 = b, v_k = A v_{k−1} + a_k b.
    vector = b
    q = [np.einsum("i...,i...->...", row, vector)]
    for k in range(1, n):
        vector = np.einsum("ij...,j...->i...", A, vector) + a[k] * b
        q.append(np.einsum("i...,i...->...", row, vector))
    characteristic = np.array(np.broadcast_arrays(*a))
    numerator = np.array(np.broadcast_arrays(*q))
    if through:
        gain = station.D[..., 0, 0]
        full = characteristic * gain
        full[1:] += numerator
        numerator = full
    return characteristic, numerator


def _resampled(tick: Real, push: Real, samples: int) -> tuple[Real, Real]:
    """A^N and (A^{N−1} + … + I) b by doubling."""
    power: Real | None = None
    total = np.zeros_like(push)
    base, sum_of_base = tick, push
    remaining = samples
    while remaining:
        if remaining % 2:
            total = (
                sum_of_base
                if power is None
                else np.einsum("ij...,j...->i...", base, total) + sum_of_base
            )
            power = base if power is None else np.einsum("ij...,jk...->ik...", base, power)
        remaining //= 2
        if remaining:
            sum_of_base = np.einsum("ij...,j...->i...", base, sum_of_base) + sum_of_base
            base = np.einsum("ij...,jk...->ik...", base, base)
    assert power is not None
    return power, total


def _by_eigenvalues(
    parameters: Parameters, timing: Timing, x: Axis, y: Axis, paths: Sequence[PathDelay]
) -> Bool:
    maps = np.zeros((len(paths), y.values.size, x.values.size), dtype=np.bool_)
    for row, vertical in enumerate(y.values):
        for column, horizontal in enumerate(x.values):
            model = parameters.replaced(
                {x.name: float(horizontal), y.name: float(vertical)}
            ).model()
            for number, path in enumerate(paths):
                timed = replace(timing, delay=path)
                maps[number, row, column] = stability(model, timed).stable
    return maps
