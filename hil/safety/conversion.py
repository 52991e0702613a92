"""Joint torque to what a device takes (motor torque, volts or DAC codes), and exactly back.

V = sign * torque / (K_t * gear * G_amp) + V_bias. Torque is clamped first, then volts, then the
code, and every rounding goes toward zero *torque*, so that what is sent never exceeds what the
safety layer allowed. The joint torque always is the one at the proximal link, in N.m.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import ceil, floor, isfinite


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueDrive:
    """A drive that takes the motor's torque as a 32-bit float (Haply, ODrive, own boards)."""

    direction: int = 1
    gear: float = 1.0

    def encode(self, torque: float) -> float:
        """Motor torque (N.m) as the float32 nearest to it toward zero."""
        wanted = self.direction * torque / self.gear
        (code,) = struct.unpack("<f", struct.pack("<f", wanted))
        if abs(code) > abs(wanted):
            (bits,) = struct.unpack("<I", struct.pack("<f", code))
            (code,) = struct.unpack("<f", struct.pack("<I", bits - 1))
        while abs(code * self.gear) > abs(torque):
            (bits,) = struct.unpack("<I", struct.pack("<f", code))
            (code,) = struct.unpack("<f", struct.pack("<I", bits - 1))
        return code

    def sendable(self, torque: float) -> float:
        """The joint torque (N.m) that really is sent for a wanted one."""
        return self.decode(self.encode(torque))

    def decode(self, code: float) -> float:
        """Joint torque (N.m) of a motor torque."""
        return self.direction * code * self.gear


@dataclass(frozen=True, slots=True, kw_only=True)
class VoltageDrive:
    """A current amplifier behind a DAC: volts in, amperes out.

    ``torque_constant`` (N.m/A), ``gear`` (1), ``amplifier`` (A/V), ``bias`` (V) is the voltage at
    which the torque is zero; the DAC has ``low_code`` .. ``high_code`` for ``low`` .. ``high`` V.
    """

    direction: int = 1
    gear: float = 1.0
    torque_constant: float
    amplifier: float
    bias: float = 0.0
    low: float = -10.0
    high: float = 10.0
    low_code: int = -32767
    high_code: int = 32767

    @property
    def torque_per_volt(self) -> float:
        """Signed joint torque of one volt (N.m/V)."""
        return self.direction * self.torque_constant * self.gear * self.amplifier

    @property
    def volts_per_code(self) -> float:
        """One step of the DAC (V)."""
        return (self.high - self.low) / (self.high_code - self.low_code)

    def volts(self, torque: float) -> float:
        """The voltage for a joint torque (N.m), within the DAC's range."""
        return min(max(torque / self.torque_per_volt + self.bias, self.low), self.high)

    def encode(self, torque: float) -> int:
        """The DAC code for a joint torque (N.m), rounded toward zero torque.

        Raises:
            ValueError: it is not a finite number, which would become all that the DAC can give.
        """
        if not isfinite(torque):
            raise ValueError(f"{torque} is no torque")
        if torque == 0.0:
            return self.zero_code
        exact = self.low_code + (self.volts(torque) - self.low) / self.volts_per_code
        # Toward zero torque means toward the code of the bias voltage.
        code = floor(exact) if exact >= self._zero else ceil(exact)
        code = min(max(code, self.low_code), self.high_code)
        if abs(self.decode(code)) > abs(torque):
            code += 1 if code < self._zero else -1
        return code if self.decode(code) * torque > 0.0 else self.zero_code

    def sendable(self, torque: float) -> float:
        """The joint torque (N.m) that really is sent for a wanted one."""
        return self.decode(self.encode(torque))

    def decode(self, code: int) -> float:
        """Joint torque (N.m) of a DAC code; the zero code counts as exactly zero."""
        if code == self.zero_code:
            return 0.0
        return (self.voltage(code) - self.bias) * self.torque_per_volt

    def voltage(self, code: int) -> float:
        """The voltage of a DAC code."""
        return self.low + (code - self.low_code) * self.volts_per_code

    @property
    def zero_code(self) -> int:
        """The code nearest to zero torque."""
        return round(self._zero)

    @property
    def _zero(self) -> float:
        return self.low_code + (self.bias - self.low) / self.volts_per_code
