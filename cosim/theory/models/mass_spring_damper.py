"""The mass-spring-damper models of Figs 3.1, 4.3, 4.4, 6.1 and 6.3, for any number of users.

One shared world frame: forces on a body are K (X_other − X_self) with no mirrored axes, so the plus
signs of (4.26) and (4.28) are minus signs here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from cosim.theory.numerics import Real


@dataclass(frozen=True, slots=True)
class Centralized:
    """Hands coupled to one object on the server (Fig. 4.3); user 1 is the server's own user.

    With one user it is the single-user loop of chapter 3, and no network is in it. A user whose
    ``present`` is false has no hand in the model (Fig. 6.1 a and b).

    Attributes:
        present: shape (users,), whether each user's hand takes part.
        hand_mass: shape (users,), hand and device, kg.
        hand_damping: shape (users,), physical viscous damping of hand and device, N·s/m.
        object_mass: kg.
        stiffness: shape (users,), virtual couplers K_m, N/m.
        damping: shape (users,), N·s/m.
        compensation: b_c, a force −b_c v sampled from the object's own velocity at T_c and held,
            N·s/m; negative compensates.
        wall_stiffness: N/m; 0 in free motion.
        wall_damping: N·s/m; 0 in free motion.
        hand_stiffness: N/m, of every hand towards where its user holds it; 0: hands are free.
    """

    present: tuple[bool, ...]
    hand_mass: Real
    hand_damping: Real
    object_mass: float
    stiffness: Real
    damping: Real
    compensation: float = 0.0
    wall_stiffness: float = 0.0
    wall_damping: float = 0.0
    hand_stiffness: float = 0.0

    @property
    def users(self) -> int:
        """Number of users, present or not."""
        return len(self.present)

    @property
    def grounded(self) -> bool:
        """Whether something holds the position, so that there is no translation mode."""
        return self.wall_stiffness != 0.0 or self.hand_stiffness != 0.0


@dataclass(frozen=True, slots=True)
class Distributed:
    """One copy of the object per workstation, tied all-to-all (Fig. 4.4).

    Entry (m, r) of a matrix is the coupler that workstation m computes from what r sent.

    Attributes:
        present: shape (users,), whether each user's hand takes part.
        hand_mass: shape (users,), kg.
        hand_damping: shape (users,), physical viscous damping, N·s/m.
        object_mass: shape (users,), kg.
        local_stiffness: shape (users,), K_mm between a hand and its own copy, N/m.
        local_damping: shape (users,), N·s/m.
        remote_stiffness: shape (users, users), K_mr between copy m and the hand of r, N/m.
        remote_damping: shape (users, users), N·s/m.
        object_stiffness: shape (users, users), K_o between copy m and the copy of r, N/m.
        object_damping: shape (users, users), N·s/m.
        compensation: shape (users,), b_c, a force −b_c v sampled at T_c and held, N·s/m.
        wall_stiffness: N/m, at every copy; 0 in free motion.
        wall_damping: N·s/m, at every copy; 0 in free motion.
        hand_stiffness: N/m, of every hand towards where its user holds it; 0: hands are free.
    """

    present: tuple[bool, ...]
    hand_mass: Real
    hand_damping: Real
    object_mass: Real
    local_stiffness: Real
    local_damping: Real
    remote_stiffness: Real
    remote_damping: Real
    object_stiffness: Real
    object_damping: Real
    compensation: Real
    wall_stiffness: float = 0.0
    wall_damping: float = 0.0
    hand_stiffness: float = 0.0

    @property
    def users(self) -> int:
        """Number of users, present or not."""
        return len(self.present)

    @property
    def grounded(self) -> bool:
        """Whether something holds the position, so that there is no translation mode."""
        return self.wall_stiffness != 0.0 or self.hand_stiffness != 0.0


Model: TypeAlias = Centralized | Distributed
