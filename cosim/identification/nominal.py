"""What a published device is taken to be until it was measured: the parameters of its model.

Used for feedforward, to see that an excitation stays inside the limits, and for what a preset
cannot tell apart. Identification itself uses none of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cosim.identification.five_bar import Array, FiveBar
from cosim.identification.regressor import PARAMETERS


@dataclass(frozen=True, slots=True, kw_only=True)
class Nominal:
    """Inertia and friction of a five-bar with uniform links, both sides alike, SI units."""

    proximal_inertia: float
    distal_mass: float
    distal_inertia: float
    tip_mass: float
    coulomb_friction: float
    viscous_friction: float

    @classmethod
    def of(cls, device: str, given: Mapping[str, float] | None = None) -> Nominal:
        """Those of a published device (``quanser``, ``haply``), other values in their place.

        Rotors count as a part of the proximal links.
        """
        from fmus.shared.mechanism.device import DEVICE, presets

        at = min(next(item.value for item in DEVICE.items if item.name == device), 1)
        found = {name: pair[at] for name, pair in presets("DYNAMICS").items()}
        found.update({name: value for name, value in (given or {}).items() if value != -1})
        found["proximal_inertia"] += found["gear_ratio"] ** 2 * found["rotor_inertia"]
        return cls(**{name: found[name] for name in cls.__slots__})

    def nu(self, bar: FiveBar) -> float:
        """What each distal link adds at either end (kg)."""
        return self.distal_mass / 4 + self.distal_inertia / bar.distal**2

    def values(self, bar: FiveBar, payload: float = 0.0) -> Array:
        """The regressor's parameters, with a mass (kg) at the tip; shape (parameters,)."""
        nu, phi = self.nu(bar), self.distal_mass / 4 - self.distal_inertia / bar.distal**2
        side = self.proximal_inertia + nu * bar.proximal**2
        known = {
            "J_1": side,
            "J_2": side,
            "M": self.tip_mass + 2 * nu + payload,
            "phi_1": phi,
            "phi_2": phi,
            "coulomb_1": self.coulomb_friction,
            "coulomb_2": self.coulomb_friction,
            "viscous_1": self.viscous_friction,
            "viscous_2": self.viscous_friction,
        }
        return np.array([known.get(each.name, 0.0) for each in PARAMETERS])
