"""A pointer that is moved by nobody reasonable."""

from __future__ import annotations

import random

from cosim.live.mailbox import FINGERS
from cosim.live.pointer import Pointer


class Restless(Pointer):
    """Sixty samples a second anywhere in reach or far beyond, with silences."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self._draw = random.Random(seed)

    def read(self, tick: int) -> None:
        if tick % 17 == 0:
            far = self._draw.choice([0.02, 0.1, 5.0])
            place = [self._draw.uniform(-far, far) for _ in range(2 * FINGERS)]
            self._take(tick // 17 + 1, [0.0, 1.0, *place])
        self._valid[0] = tick % 3000 < 2500
        self._age[0] = (tick % 17) / 1024
