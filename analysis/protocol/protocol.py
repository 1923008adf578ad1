"""Sweep, programme and limits together: all settings of a campaign."""

from dataclasses import dataclass

from analysis import experiment
from analysis.protocol.limits import Limits
from analysis.protocol.programme import Programme
from analysis.protocol.set_points import Leg, legs
from analysis.protocol.sweep import SweepSettings

OVERHEAD = 0.5
"""Time to set the cards up for one repeat and to bring them to rest again, s."""


@dataclass(frozen=True)
class AcquisitionProtocol:
    """What is measured when.

    Attributes
    ----------
    sweep : SweepSettings
    programme : Programme
    limits : Limits
    measured_force : bool
        Whether what is recorded of the drive is the force on the plate, not the generator's own voltage.
    settling : float
        Silence before every repeat, in which sensors settle, s.
    responses : tuple of str
        What messages call the responses: sensor and terminal. Empty where they are numbered.
    thermocouples : tuple of str
        Their terminals, for messages. Empty where the sensors on the plate are numbered.
    """

    sweep: SweepSettings
    programme: Programme
    limits: Limits
    measured_force: bool = False
    settling: float = 0.0
    responses: tuple[str, ...] = ()
    thermocouples: tuple[str, ...] = ()

    @property
    def legs(self) -> tuple[Leg, ...]:
        """Every sweep asked for."""
        return legs(self.programme, self.sweep)

    def response(self, number: int) -> str:
        """Name a response, from 0, for people."""
        return f"response {self.responses[number] if self.responses else number + 1}"

    def plate_sensors(self, count: int) -> tuple[str, ...]:
        """Name `count` sensors on the plate for people."""
        if len(self.thermocouples) == count:
            return tuple(f"the plate's thermocouple {terminal}" for terminal in self.thermocouples)
        if count == 1:
            return ("the plate's sensor",)
        return tuple(f"the plate's sensor {number + 1}" for number in range(count))

    @property
    def count(self) -> int:
        """How many sweeps that is."""
        return len(self.programme.temperatures) * len(self.programme.legs) * len(self.sweep.levels)

    @property
    def sweep_seconds(self) -> float:
        """How long one sweep with all its repeats takes, s."""
        return self.sweep.repeats * (self.sweep.record + OVERHEAD + self.settling)

    @property
    def sweep_travel(self) -> float:
        """How far the ramp goes meanwhile, K."""
        return self.sweep_seconds * self.programme.ramp_rate / 60.0

    def seconds(
        self, temperature: float, leg: int = 0, *, ramping: bool = False, start: float | None = None
    ) -> float:
        """Estimate the time to the end, s, lags of oven and plate left aside.

        Parameters
        ----------
        temperature : float
            Now, degrees Celsius.
        leg : int
            The leg under way.
        ramping : bool
            Whether its ramp has begun; otherwise the way to its start and the soak come first.
        start : float, optional
            Where the ramp of the leg under way is begun again, degrees Celsius; else at the leg's start.

        Returns
        -------
        float
            s.
        """
        programme, total, here = self.programme, 0.0, temperature
        for one in self.legs[leg:]:
            if not (ramping and one.number == leg):
                begin = start if start is not None and one.number == leg else one.start
                total += 60.0 * abs(begin - here) / programme.to_start
                total += max(programme.soak_before, programme.settling.lasting)
                here = begin
            total += 60.0 * abs(one.end - here) / programme.ramp_rate
            here = one.end
        return total + programme.soak_after

    def recorded(self) -> experiment.Protocol:
        """Return what a recorded campaign declares of the same sweeps."""
        sweep, programme = self.sweep, self.programme
        return experiment.Protocol(
            sweep=sweep.kind,
            band=sweep.band,
            sweep_duration=sweep.duration,
            taper=sweep.taper,
            tail=sweep.tail,
            repeats=sweep.repeats,
            ramp_rate=programme.ramp_rate,
            temperatures=programme.temperatures,
            directions=programme.legs,
            levels=sweep.levels,
        )
