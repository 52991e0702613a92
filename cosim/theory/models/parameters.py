"""Parameters by the thesis's names, and the models that they make.

A parameter has a most specific name (``k_21``) and more general ones (``k_12`` for either of a
pair, ``b`` for every coupler's damping). The most specific name that was given wins; defaults come
last.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.theory.models.mass_spring_damper import Centralized, Distributed, Model
from cosim.theory.numerics import Real

Architecture = Literal["single", "centralized", "distributed"]
ARCHITECTURES: tuple[Architecture, ...] = ("single", "centralized", "distributed")

_MASSES = {"m_h": 0.1, "m_o": 0.4}
_NEUTRAL = {"b_c": 0.0, "b_h": 0.0, "k_w": 0.0, "b_w": 0.0}

CHAPTER_5: dict[Architecture, dict[str, float]] = {
    "single": {**_MASSES, **_NEUTRAL, "k": 1000.0, "b": 10.0},
    "centralized": {**_MASSES, **_NEUTRAL, "k_1": 1000.0, "k_2": 100.0, "b": 10.0},
    "distributed": {
        **_MASSES,
        **_NEUTRAL,
        "k_11": 2000.0,
        "k_12": 300.0,
        "k_o": 1000.0,
        "b": 10.0,
    },
}
"""Constants of chapter 5 (N/m, N·s/m, kg). Its figures vary k_1, k_2; 1000, 100 stand for them."""

TABLE_6_1: dict[Architecture, dict[str, float]] = {
    "single": {**_MASSES, **_NEUTRAL, "k": 1000.0, "b": 15.0},
    "centralized": {
        **_MASSES,
        **_NEUTRAL,
        "k_1": 1000.0,
        "b_1": 15.0,
        "k_2": 85.0,
        "b_2": 3.0,
    },
    "distributed": {
        **_MASSES,
        **_NEUTRAL,
        "k_11": 3000.0,
        "b_11": 20.0,
        "k_12": 400.0,
        "b_12": 2.0,
        "k_o": 300.0,
        "b_o": 10.0,
    },
}
"""Table 6.1 (N/m, N·s/m, kg)."""

WALL: dict[str, float] = {"k_w": 30000.0, "b_w": 20.0}
"""The rigid wall of section 6.2 (N/m, N·s/m)."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """What values a parameter may have."""

    unit: str
    positive: bool
    signed: bool = False


_KINDS = {
    "m": _Kind("kg", positive=True),
    "k": _Kind("N/m", positive=False),
    "b": _Kind("N·s/m", positive=False),
    "b_c": _Kind("N·s/m", positive=False, signed=True),
}


class Parameters:
    """The values of one architecture's parameters, looked up by their most specific name.

    Args:
        architecture: whose names are meant.
        given: what the user gave, by name.
        defaults: what holds where the user gave nothing.
        users: number of users; 1 for ``single``.

    Raises:
        InputError: for an unknown name (with the nearest known one) or a value out of range.
    """

    def __init__(
        self,
        architecture: Architecture,
        given: Mapping[str, float],
        defaults: Mapping[str, float],
        users: int = 2,
    ) -> None:
        self.architecture: Architecture = architecture
        self.users = check_users(architecture, users)
        self.given = dict(given)
        self.defaults = dict(defaults)
        self.leaves = _leaves(architecture, self.users)
        known = {name for names in self.leaves.values() for name in names}
        for name, value in self.given.items():
            _check_name(name, known, architecture)
            _check_value(name, value)

    def __getitem__(self, leaf: str) -> float:
        """The value of a most specific name."""
        name = self.source(leaf)
        return self.given[name] if name in self.given else self.defaults[name]

    def source(self, leaf: str) -> str:
        """The name whose value holds for a most specific name."""
        for source in (self.given, self.defaults):
            for name in self.leaves[leaf]:
                if name in source:
                    return name
        raise KeyError(leaf)

    def resolved(self) -> dict[str, float]:
        """Every most specific name with the value that holds."""
        return {leaf: self[leaf] for leaf in self.leaves}

    def model(self, present: tuple[bool, ...] | None = None) -> Model:
        """The model that these parameters describe.

        Args:
            present: which users' hands take part; None: all.
        """
        users = range(1, self.users + 1)
        hands = present or (True,) * self.users
        hand_mass = self._array(f"m_h{m}" for m in users)
        hand_damping = self._array(f"b_h{m}" for m in users)
        if self.architecture == "distributed":
            return Distributed(
                present=hands,
                hand_mass=hand_mass,
                hand_damping=hand_damping,
                object_mass=self._array(f"m_o{m}" for m in users),
                local_stiffness=self._array(f"k_{m}{m}" for m in users),
                local_damping=self._array(f"b_{m}{m}" for m in users),
                remote_stiffness=self._square("k_{m}{r}"),
                remote_damping=self._square("b_{m}{r}"),
                object_stiffness=self._square("k_o{m}"),
                object_damping=self._square("b_o{m}"),
                compensation=self._array(f"b_c{m}" for m in users),
                wall_stiffness=self["k_w"],
                wall_damping=self["b_w"],
            )
        single = self.architecture == "single"
        return Centralized(
            present=hands,
            hand_mass=hand_mass,
            hand_damping=hand_damping,
            object_mass=self["m_o"],
            stiffness=self._array(["k"] if single else (f"k_{m}" for m in users)),
            damping=self._array(["b"] if single else (f"b_{m}" for m in users)),
            compensation=self["b_c"],
            wall_stiffness=self["k_w"],
            wall_damping=self["b_w"],
        )

    def replaced(self, values: Mapping[str, float]) -> Parameters:
        """The same parameters with some given anew."""
        return Parameters(self.architecture, {**self.given, **values}, self.defaults, self.users)

    def _array(self, leaves: Iterable[str]) -> Real:
        return np.array([self[leaf] for leaf in leaves])

    def _square(self, pattern: str) -> Real:
        matrix = np.zeros((self.users, self.users))
        for m in range(self.users):
            for r in range(self.users):
                if m != r:
                    matrix[m, r] = self[pattern.format(m=m + 1, r=r + 1)]
        return matrix


def check_users(architecture: Architecture, users: int) -> int:
    """The number of users of a model; one for ``single``.

    Raises:
        InputError: where it is not 2 to 9.
    """
    if architecture == "single":
        return 1
    if not 2 <= users <= 9:
        raise InputError(
            f"A {architecture} loop has 2 to 9 users, not {users}; for one user use "
            "--architecture single."
        )
    return users


def _leaves(architecture: Architecture, users: int) -> dict[str, tuple[str, ...]]:
    """Each most specific name with all the names that set it, most specific first."""
    numbers = range(1, users + 1)
    leaves: dict[str, tuple[str, ...]] = {}
    for m in numbers:
        leaves[f"m_h{m}"] = (f"m_h{m}", "m_h")
        leaves[f"b_h{m}"] = (f"b_h{m}", "b_h")
    leaves["k_w"], leaves["b_w"] = ("k_w",), ("b_w",)
    if architecture == "single":
        return leaves | {
            "m_o": ("m_o",),
            "b_c": ("b_c",),
            "k": ("k", "k_1"),
            "b": ("b", "b_1"),
        }
    if architecture == "centralized":
        leaves["m_o"], leaves["b_c"] = ("m_o",), ("b_c",)
        leaves["k_1"], leaves["b_1"] = ("k_1",), ("b_1", "b")
        for m in numbers[1:]:
            leaves[f"k_{m}"] = _distinct(f"k_{m}", "k_2")
            leaves[f"b_{m}"] = _distinct(f"b_{m}", "b_2", "b")
        return leaves
    for m in numbers:
        leaves[f"m_o{m}"] = (f"m_o{m}", "m_o")
        leaves[f"b_c{m}"] = (f"b_c{m}", "b_c")
        leaves[f"k_{m}{m}"] = _distinct(f"k_{m}{m}", "k_11", "k_22")
        leaves[f"b_{m}{m}"] = _distinct(f"b_{m}{m}", "b_11", "b_22", "b")
        leaves[f"k_o{m}"] = _distinct(f"k_o{m}", "k_o", "k_o1", "k_o2")
        leaves[f"b_o{m}"] = _distinct(f"b_o{m}", "b_o", "b_o1", "b_o2", "b")
        for r in numbers:
            if m != r:
                leaves[f"k_{m}{r}"] = _distinct(f"k_{m}{r}", "k_12", "k_21")
                leaves[f"b_{m}{r}"] = _distinct(f"b_{m}{r}", "b_12", "b_21", "b")
    return leaves


def _distinct(*names: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _check_name(name: str, known: set[str], architecture: Architecture) -> None:
    if name in known:
        return
    listing = ", ".join(sorted(known, key=lambda word: (word[0], len(word), word)))
    raise InputError(
        f"The {architecture} model has no parameter {name!r}."
        f"{did_you_mean(name, known, listed=0)} It has: {listing}."
    )


def _check_value(name: str, value: float) -> None:
    kind = _KINDS["b_c" if name.startswith("b_c") else name[0]]
    if not math.isfinite(value):
        raise InputError(f"{name} is {value}: it must be a finite number of {kind.unit}.")
    if kind.positive and value <= 0:
        raise InputError(f"{name} is {value:g} {kind.unit}: a mass must be positive.")
    if value < 0 and not kind.signed:
        raise InputError(
            f"{name} is {value:g} {kind.unit}: it cannot be negative. "
            "Negative damping is what the compensation b_c is for."
        )
