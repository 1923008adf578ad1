"""What another program estimated of a plate over temperature: FRFs, or natural frequencies and damping."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from analysis.arrays import Complex, Real, Whole
from analysis.experiment import Experiment
from analysis.recordings.campaign import Campaign, CampaignExtent

Noise = Literal["variance", "coherence", "neighbouring lines"]
"""Where the variance of a sweep's FRFs comes from; the last where the files give none."""


@dataclass(frozen=True)
class FrfSweep:
    """The FRFs of all outputs from one input, at one temperature, direction and level.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    h : (K, F) complex ndarray
        Of every output, in its SI unit by that of the input.
    noise : tuple of str
        Of every output: ``variance``, as stated; ``coherence``, as it follows line by line, not yet smooth over
        frequency; ``neighbouring lines``, not known, `variance` is not used.
    variance : (K, F) ndarray
        E|h - H|^2.
    coherence : (K, F) ndarray
        1 where it is not known.
    direction : str
        ``up`` or ``down``.
    level : float
        Amplitude of the drive, V or N; 1 where it is not known.
    source : int
        Which of `Experiment.inputs` drove.
    repeats_dof : int
        As in `analysis.recordings.frf.Frf`; 0 where it is not known.
    """

    temperature: float
    h: Complex
    noise: tuple[Noise, ...]
    variance: Real
    coherence: Real
    direction: Literal["up", "down"] = "up"
    level: float = 1.0
    source: int = 0
    repeats_dof: int = 0

    def __post_init__(self) -> None:
        shape = self.h.shape
        alike = {self.variance.shape, self.coherence.shape, (len(self.noise), shape[-1])}
        if self.h.ndim != 2 or alike != {shape}:
            raise ValueError(
                f"h {self.h.shape}, variance {self.variance.shape} and coherence {self.coherence.shape} of a "
                "sweep; the same (K, F) wanted"
            )
        if not np.isfinite(self.h).all():
            raise ValueError(f"FRFs at {self.temperature:g} °C hold values that are not finite")


@dataclass(frozen=True)
class FrfCampaign:
    """FRFs of one declared plate, in the order read.

    Attributes
    ----------
    name : str
        For people: the folder's name.
    experiment : Experiment
        As declared; its protocol states what is known of how the FRFs were measured.
    frequency : (F,) ndarray
        Hz, even spacing.
    sweeps : tuple of FrfSweep
    hashes : dict
        SHA-256 of every file they were read from, by name.
    notes : tuple of str
        What the files do not say, for people.
    at_rest : bool
        As in `analysis.recordings.frf.Frf`.
    extent : None
        As of a `Campaign` of which no sweep is missing.
    """

    name: str
    experiment: Experiment
    frequency: Real
    sweeps: tuple[FrfSweep, ...]
    hashes: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    at_rest: bool = False
    extent: CampaignExtent | None = None

    def __post_init__(self) -> None:
        if not self.sweeps:
            raise ValueError(f"plate {self.name!r} has no FRFs")
        outputs, inputs = len(self.experiment.outputs), len(self.experiment.inputs)
        for sweep in self.sweeps:
            if sweep.h.shape != (outputs, len(self.frequency)) or not 0 <= sweep.source < inputs:
                raise ValueError(
                    f"FRFs {sweep.h.shape} of input {sweep.source} at {sweep.temperature:g} °C; "
                    f"({outputs}, {len(self.frequency)}) of {inputs} inputs are declared"
                )

    def __repr__(self) -> str:
        """Name, sweeps, temperatures and sensors in one line."""
        temperature = [sweep.temperature for sweep in self.sweeps]
        sensors = ", ".join(output.id for output in self.experiment.outputs)
        return (
            f"<FrfCampaign {self.name!r}: FRFs of {len(temperature)} sweeps, {min(temperature):z.1f} to "
            f"{max(temperature):z.1f} °C, sensors {sensors}>"
        )

    @property
    def spacing(self) -> float:
        """Distance of the lines, Hz."""
        return float(self.frequency[-1] - self.frequency[0]) / (len(self.frequency) - 1)


AnyCampaign = Campaign | FrfCampaign
"""What model updating, identification and the gap take: time signals, or FRFs as such."""


@dataclass(frozen=True)
class ModesAtTemperature:
    """Modes at one temperature.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    frequency : (J,) ndarray
        Hz, ascending, of hysteretic damping: sqrt(Re k)/2 pi of the pole's k = -pole^2.
    sigma : (J,) ndarray
        Standard deviations, Hz; NaN where they are not known.
    loss_factor, sigma_loss_factor : (J,) ndarray
        Im k / Re k; NaN where they are not known.
    number : (J,) int ndarray
        Of the mode, from 1 for the lowest elastic one; 0 where it is not known.
    """

    temperature: float
    frequency: Real
    sigma: Real
    loss_factor: Real
    sigma_loss_factor: Real
    number: Whole

    def __post_init__(self) -> None:
        shape = self.frequency.shape
        for name in ("sigma", "loss_factor", "sigma_loss_factor", "number"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; {shape} wanted")
        if not shape[0] or not (self.frequency > 0.0).all() or (np.diff(self.frequency) < 0.0).any():
            raise ValueError(f"frequencies at {self.temperature:g} °C must ascend from above 0 Hz")
        if (self.sigma <= 0.0).any() or (self.sigma_loss_factor <= 0.0).any() or (self.loss_factor <= 0.0).any():
            raise ValueError(f"standard deviations and damping at {self.temperature:g} °C must be above 0")
