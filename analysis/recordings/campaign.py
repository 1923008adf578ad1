"""Recorded sweeps of one experiment over temperature, and how many of those that its protocol asks for are there.

Volts at the cards become units of the plate here, and nowhere else.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from analysis.channel import Channel
from analysis.experiment import Experiment


@dataclass(frozen=True)
class Sweep:
    """The repeats of one sweep at one temperature step, direction and level.

    Attributes
    ----------
    step : int
        Place in the order recorded.
    direction : str
        ``up`` or ``down``.
    level : float
        Amplitude of the drive: V, or N of a force; of the generator, V, where Flexura drove an exciter.
    oven_temperature_start, oven_temperature_end : float
        Oven reading before the first and after the last repeat, degrees Celsius.
    start_time : str
        ISO 8601.
    drive : (R, M) ndarray
        Generator voltage of every repeat, V; or the force, N.
    responses : (K, R, M) ndarray
        Of every output, in its unit: V across a sensor patch, for example.
    plate_temperature_start, plate_temperature_end : float or None
        Reading of a thermocouple on the plate at the same moments, degrees Celsius; None without one.
    source : int
        Which of `Experiment.inputs` drove.
    doubt : str
        Why its temperature may be wrong, as the rig noted it; empty if it is believed.
    """

    step: int
    direction: Literal["up", "down"]
    level: float
    oven_temperature_start: float
    oven_temperature_end: float
    start_time: str
    drive: NDArray[np.float32]
    responses: NDArray[np.float32]
    plate_temperature_start: float | None = None
    plate_temperature_end: float | None = None
    source: int = 0
    doubt: str = ""

    def __post_init__(self) -> None:
        if self.drive.ndim != 2 or self.responses.ndim != 3 or self.responses.shape[1:] != self.drive.shape:
            raise ValueError(
                f"sweep {self.step}: drive {self.drive.shape} and responses {self.responses.shape} "
                "must be (R, M) and (K, R, M)"
            )
        if (self.plate_temperature_start is None) != (self.plate_temperature_end is None):
            raise ValueError(f"sweep {self.step}: a plate temperature at its start or end only; both or neither")

    @property
    def oven_temperature(self) -> float:
        """Mean oven reading during the sweep, degrees Celsius."""
        return 0.5 * (self.oven_temperature_start + self.oven_temperature_end)

    @property
    def temperature(self) -> float:
        """Mean temperature of the plate, degrees Celsius; the oven's where the plate has no sensor."""
        if self.plate_temperature_start is None or self.plate_temperature_end is None:
            return self.oven_temperature
        return 0.5 * (self.plate_temperature_start + self.plate_temperature_end)


State = Literal["running", "interrupted", "ended", "incomplete"]


@dataclass(frozen=True)
class CampaignExtent:
    """Sweeps of a campaign that lacks some of its protocol's.

    Attributes
    ----------
    state : str
        ``running`` (a process is recording it), ``interrupted`` (it can be continued), ``ended`` (what is missing
        was given up, or was left out when the campaign was imported), or ``incomplete`` (a recorder's folder, of
        which no more is known).
    sweeps : int
        Finished ones, 1 or more.
    asked : int
        Those of the protocol.
    given_up : int
        Those of the missing ones that will not come.
    lowest, highest : float
        Temperatures of the finished sweeps, degrees Celsius.
    """

    state: State
    sweeps: int
    asked: int
    given_up: int
    lowest: float
    highest: float

    def __post_init__(self) -> None:
        if self.state not in get_args(State):
            raise ValueError(f"state {self.state!r}: one of {', '.join(get_args(State))} wanted")
        if not 1 <= self.sweeps < self.asked or not 0 <= self.given_up <= self.asked - self.sweeps:
            raise ValueError(
                f"{self.sweeps} of {self.asked} sweeps, {self.given_up} given up: 1 or more of more, and no more "
                "given up than are missing"
            )
        if not self.lowest <= self.highest:
            raise ValueError(f"sweeps from {self.lowest:g} to {self.highest:g} °C: two ascending values wanted")

    @classmethod
    def of(cls, state: State, temperature: Sequence[float], missing: int, given_up: int = 0) -> "CampaignExtent":
        """Return the extent of a campaign of which sweeps are there.

        Parameters
        ----------
        state : str
        temperature : sequence of float
            Of every finished sweep, °C.
        missing : int
            How many more the protocol asks for.
        given_up : int
            How many of these will not come.
        """
        count = len(temperature)
        return cls(state, count, count + missing, given_up, min(temperature), max(temperature))

    @property
    def said(self) -> str:
        """State, sweeps and temperatures: ``interrupted, 20 of 31 sweeps, 15 to 45 °C``."""
        gone = f" ({self.given_up} given up)" if self.given_up and self.state != "ended" else ""
        low, high = f"{self.lowest:z.0f}", f"{self.highest:z.0f}"
        span = low if low == high else f"{low} to {high}"
        state = "ended with sweeps missing" if self.state == "ended" else self.state
        return f"{state}, {self.sweeps} of {self.asked} sweeps{gone}, {span} °C"

    @property
    def note(self) -> str:
        """Say what the results of such a campaign are worth."""
        onward = (
            "the missing ones were given up, or left out when the campaign was imported"
            if self.state == "ended"
            else "results hold for these; do the same again when more sweeps are there"
        )
        return f"the campaign is not complete: {self.said}; {onward}"


@dataclass(frozen=True)
class Campaign:
    """An experiment and what was recorded of it, in the order recorded.

    Attributes
    ----------
    name : str
        For people: the folder's name.
    experiment : Experiment
        As declared.
    sweeps : tuple of Sweep
        One for each temperature step, direction and level.
    hashes : dict
        SHA-256 of every file the campaign was read from, by name.
    level_units : tuple of str
        Of the levels of each input, where these are not in the inputs' own units: volts before an exciter.
    extent : CampaignExtent or None
        Where sweeps of the protocol are missing, how many are there; None where none is.
    """

    name: str
    experiment: Experiment
    sweeps: tuple[Sweep, ...]
    hashes: dict[str, str] = field(default_factory=dict)
    level_units: tuple[str, ...] = ()
    extent: CampaignExtent | None = None

    def __post_init__(self) -> None:
        if not self.sweeps:
            raise ValueError(f"campaign {self.name!r} holds no sweep")
        outputs, inputs = len(self.experiment.outputs), len(self.experiment.inputs)
        for sweep in self.sweeps:
            if not 0 <= sweep.source < inputs:
                raise ValueError(
                    f"sweep {sweep.step}: driven by input {sweep.source}; {inputs} are declared, from 0"
                )
            if sweep.responses.shape[0] != outputs:
                raise ValueError(
                    f"sweep {sweep.step}: {sweep.responses.shape[0]} responses; {outputs} sensors are declared"
                )

    def as_read(self) -> Self:
        """Return the campaign declared as its sweeps say: temperatures are the plate's, where all carry these."""
        if any(sweep.plate_temperature_start is None for sweep in self.sweeps):
            return self
        oven = self.experiment.oven.model_copy(update={"reading": "plate"})
        return replace(self, experiment=self.experiment.model_copy(update={"oven": oven}))

    def __repr__(self) -> str:
        """Name, sweeps, temperatures and sensors in one line: arrays of a recording would fill screens."""
        temperature = [sweep.temperature for sweep in self.sweeps]
        sensors = ", ".join(output.id for output in self.experiment.outputs)
        if self.extent is not None:
            return f"<Campaign {self.name!r}: {self.extent.said}, sensors {sensors}>"
        return (
            f"<Campaign {self.name!r}: {len(temperature)} sweeps, {min(temperature):z.1f} to "
            f"{max(temperature):z.1f} °C, sensors {sensors}>"
        )


@dataclass(frozen=True)
class Sensitivity:
    """What a channel's transducer, its conditioner included, gives at the card.

    Attributes
    ----------
    channel : Channel
    volts : float
        V per unit of the channel; 1 for one that is read in volts.
    """

    channel: Channel
    volts: float = 1.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.volts) and self.volts > 0.0):
            raise ValueError(f"channel {self.channel.id!r}: {self.volts:g} V/{self.channel.unit}; above 0 allowed")
        if self.channel.unit == "V" and self.volts != 1.0:
            raise ValueError(f"channel {self.channel.id!r} is read in volts, {self.volts:g} V/V; 1 allowed")


@dataclass(frozen=True)
class Sensitivities:
    """Those of all channels of a campaign.

    Attributes
    ----------
    drive : Sensitivity
        Of what is recorded of the input: the generator's volts (1 V/V), or the force sensor.
    responses : (K,) tuple of Sensitivity
    """

    drive: Sensitivity
    responses: tuple[Sensitivity, ...]

    @property
    def units(self) -> tuple[str, ...]:
        """Of the drive, then of each response."""
        return tuple(one.channel.unit for one in (self.drive, *self.responses))

    def measured(self, sweep: Sweep) -> Sweep:
        """Return a sweep recorded in volts in the units of its channels; volts stay what they are, bit by bit."""
        if len(sweep.responses) != len(self.responses):
            raise ValueError(f"{len(sweep.responses)} responses; {len(self.responses)} sensitivities are declared")
        volts = np.array([one.volts for one in self.responses], dtype=sweep.responses.dtype)
        return replace(
            sweep,
            drive=sweep.drive / sweep.drive.dtype.type(self.drive.volts),
            responses=sweep.responses / volts[:, None, None],
        )
