"""Modules as their maker describes them: voltage inputs, voltage outputs, thermocouples.

Of inputs and outputs, the rates they can run at and the voltage they can hold; thermocouple modules are slow, with
a timing of their own.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class InputModule:
    """An input module, whose rate is its master timebase over `oversampling` times n.

    Attributes
    ----------
    name : str
        As printed on the module.
    timebases : tuple of float
        Master timebases it may run on, Hz: its own first, then those it may take from a neighbour.
    divisors : range
        The n allowed.
    channels : int
    full_scale : float
        Largest magnitude it is sure to convert, V.
    bits : int
        Of its converter.
    input_resistance : float
        Between the two inputs of a channel, ohm.
    filter_delay : float
        Of its decimation filter, in samples.
    fixed_delay : float
        On top of it, whatever the rate, s.
    noise : float
        Of a channel at rest, V rms.
    coupling_corner : float
        Where AC coupling has lost 3 dB, Hz; 0 where it can only couple DC.
    iepe : bool
        Whether it can feed sensors with a constant current.
    oversampling : int
        256 of a delta-sigma converter, 1 of one that converts on command.
    """

    name: str
    timebases: tuple[float, ...]
    divisors: range
    channels: int
    full_scale: float
    bits: int
    input_resistance: float
    filter_delay: float
    fixed_delay: float
    noise: float
    coupling_corner: float
    oversampling: int = 256
    iepe: bool = False

    @property
    def on_demand(self) -> bool:
        """Whether it converts a single value when it is asked: a delta-sigma converter cannot."""
        return self.oversampling == 1

    @property
    def quantum(self) -> float:
        """Voltage of one code, V."""
        return 2.0 * self.full_scale / 2.0**self.bits

    def rates(self) -> tuple[float, ...]:
        """Every sample rate on the module's own timebase, Hz, fastest first."""
        return tuple(self.timebases[0] / self.oversampling / n for n in self.divisors)

    def nearest_rate(self, asked: float) -> tuple[float, int]:
        """Return the rate on the module's own timebase nearest to `asked` (Hz), and its n."""
        fastest = self.timebases[0] / self.oversampling
        exact = int(fastest / max(asked, 1e-9))
        near = {min(max(n, self.divisors[0]), self.divisors[-1]) for n in (exact, exact + 1)}
        divisor = min(near, key=lambda n: abs(fastest / n - asked))
        return fastest / divisor, divisor

    def coerced_rate(self, asked: float) -> float:
        """Return the rate the driver sets when asked for `asked` Hz: the lowest that is not below it.

        Raises
        ------
        ValueError
            If the module cannot run that fast.
        """
        fastest = self.timebases[0] / self.oversampling
        if not 0.0 < asked <= fastest / self.divisors[0] * (1.0 + 1e-4):
            slowest, quickest = (fastest / n for n in (self.divisors[-1], self.divisors[0]))
            raise ValueError(f"sample rate {asked:g} Hz; {self.name} allows {slowest:.5g} to {quickest:g} Hz")
        # A rate that was read back and printed must find itself again among the few of a delta-sigma module.
        divisor = math.floor(fastest / asked * (1.0 + (1e-9 if self.on_demand else 1e-4)))
        return fastest / min(max(divisor, self.divisors[0]), self.divisors[-1])

    def delay(self, rate: float) -> float:
        """Time from a voltage at the input to the sample that shows it, s."""
        return self.filter_delay / rate + self.fixed_delay

    def can_run_at(self, rate: float) -> bool:
        """Whether `rate` (Hz, as read back) is one the hardware can have run at, to 1 ppm."""
        for timebase in self.timebases:
            divisor = round(timebase / self.oversampling / rate)
            if divisor in self.divisors and math.isclose(
                rate, timebase / self.oversampling / divisor, rel_tol=1e-6
            ):
                return True
        return False


NI_9234 = InputModule(
    name="NI-9234",
    timebases=(13.1072e6, 12.8e6),  # 12.8 MHz: what most other C Series modules export
    divisors=range(1, 32),
    channels=4,
    full_scale=5.0,
    bits=24,
    input_resistance=305e3,
    filter_delay=38.4,
    fixed_delay=3.2e-6,
    noise=50e-6,
    coupling_corner=0.5,
    iepe=True,
)

NI_9215 = InputModule(
    name="NI-9215",
    timebases=(80e6,),  # of the chassis
    divisors=range(800, 80_000_001),
    channels=4,
    full_scale=10.0,
    bits=16,
    input_resistance=1e9,
    filter_delay=0.0,
    fixed_delay=0.0,
    noise=3.7e-4,
    coupling_corner=0.0,
    oversampling=1,
)

KNOWN = (NI_9234, NI_9215)
WITH_IEPE = ("NI 9230", "NI 9231", "NI 9232", "NI 9233", "NI 9234", "NI 9250", "USB-4431", "USB-4432")
"""Modules and boards that feed IEPE sensors, as the driver calls them."""


def find_module(name: str) -> InputModule | None:
    """Return the module called `name`, however it is spaced ("NI 9234", "ni-9234"), or None if unknown."""
    wanted = _bare(name).removeprefix("ni")
    return next((module for module in KNOWN if _bare(module.name).removeprefix("ni") == wanted), None)


def _bare(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())


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


@dataclass(frozen=True)
class ThermocoupleModule:
    """A multiplexed thermocouple input module with cold-junction compensation built in.

    Attributes
    ----------
    name : str
        As printed on the module.
    channels : int
    rate : float
        Conversions per second, all channels together, Hz.
    noise : float
        Of one reading with a type K thermocouple, K rms.
    """

    name: str
    channels: int
    rate: float
    noise: float

    def duration(self, channels: int) -> float:
        """Time one reading of so many channels takes, s."""
        return channels / self.rate


NI_9211 = ThermocoupleModule("NI-9211", channels=4, rate=14.0, noise=0.02)
NI_9213 = ThermocoupleModule("NI-9213", channels=16, rate=18.0, noise=0.02)
