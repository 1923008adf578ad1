"""Output modules as their maker describes them: how far they reach, how finely, how fast."""

import math
from dataclasses import dataclass

CHASSIS_CLOCK = 80e6
"""Clock that a CompactDAQ chassis divides for modules without a timebase of their own, Hz."""


@dataclass(frozen=True)
class OutputModule:
    """A voltage output module.

    Attributes
    ----------
    name : str
        As printed on the module.
    channels : int
    full_scale : float
        Largest magnitude it can hold, V.
    bits : int
        Of its converter.
    fastest, slowest : float
        Update rates, Hz.
    timebase : float
        What its update clock is divided from, Hz.
    divisor_step : int
        The divisors are its multiples: 256 for a delta-sigma module, 1 for one clocked by the chassis.
    """

    name: str
    channels: int
    full_scale: float
    bits: int
    fastest: float
    slowest: float
    timebase: float
    divisor_step: int

    @property
    def quantum(self) -> float:
        """Voltage of one code, V."""
        return 2.0 * self.full_scale / 2.0**self.bits

    def coerced_rate(self, asked: float) -> float:
        """Return the lowest rate it can run at that is not below `asked`, Hz.

        Raises
        ------
        ValueError
            If `asked` is outside what the module allows.
        """
        if not self.slowest * (1.0 - 1e-4) <= asked <= self.fastest * (1.0 + 1e-4):
            raise ValueError(
                f"update rate {asked:g} Hz; {self.name} allows {self.slowest:g} to {self.fastest:g} Hz"
            )
        # A rate read back and printed with four decimals must find itself again, hence the small excess.
        divisor = math.floor(self.timebase / self.divisor_step / asked * (1.0 + 1e-6))
        return self.timebase / self.divisor_step / divisor


NI_9260 = OutputModule("NI-9260", 2, 4.24, 24, 51_200.0, 51_200.0 / 31, 13.1072e6, 256)
NI_9263 = OutputModule("NI-9263", 4, 10.0, 16, 100e3, 1.0, CHASSIS_CLOCK, 1)

KNOWN_OUTPUTS = (NI_9260, NI_9263)
