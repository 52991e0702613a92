"""Whether gains stand the corners that a design promises."""

from __future__ import annotations

from collections.abc import Mapping

from cosim.theory.chance.network import Network
from cosim.theory.design.corners import Corner, radius_in, stands
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import Timing


class CornerJudge:
    """Whether gains stand the corners; those that have failed are asked first."""

    def __init__(
        self,
        parameters: Parameters,
        network: Network,
        timing: Timing,
        corners: tuple[Corner, ...],
    ) -> None:
        self.parameters, self.network, self.timing = parameters, network, timing
        self.process = network.process()
        self.corners = corners
        self.asked = [c for c in corners if c.stiffness > 1.0 and not c.loses] or list(corners[:1])

    def radius(self, corner: Corner, gains: Mapping[str, float], compensation: float) -> float:
        """In one corner."""
        loop = self.parameters.replaced(gains)
        return radius_in(corner, loop, self.timing, self.process, compensation)

    def quick(self, gains: Mapping[str, float]) -> bool:
        """In the corners that have mattered so far, without compensation."""
        return self._stands(self.asked, gains, 0.0)

    def steady(self, gains: Mapping[str, float], compensation: float = 0.0) -> bool:
        """In every corner in which all packets arrive."""
        return self._stands([c for c in self.corners if not c.loses], gains, compensation)

    def lossy(self, gains: Mapping[str, float], compensation: float = 0.0) -> bool:
        """In every corner in which packets are lost."""
        return self._stands([c for c in self.corners if c.loses], gains, compensation)

    def radii(self, gains: Mapping[str, float], compensation: float) -> dict[str, float]:
        """In every corner, by name."""
        return {c.name: self.radius(c, gains, compensation) for c in self.corners}

    def _stands(self, corners: list[Corner], gains: Mapping[str, float], b_c: float) -> bool:
        first = [c for c in self.asked if c in corners]
        for corner in (*first, *(c for c in corners if c not in first)):
            loop = self.parameters.replaced(gains)
            if not stands(corner, loop, self.timing, self.process, b_c):
                if corner.loses:
                    return False
                self.asked = [corner, *(c for c in self.asked if c != corner)][:4]
                return False
        return True
