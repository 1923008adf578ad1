"""Thermometer stage: the temperature of a panel from what one of its patches answers while the others play."""

import math
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.arrays import Real
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from analysis.rendering.following import TemperatureProgramme
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.exports.shipment import Shipment, shipment
from app.files.results.run_folder import run_folder
from app.files.sound_file import opened_sound
from app.sound.temperatures import programme, require_covered
from app.stages.panel.laws import laws_for, range_of
from app.summaries import thermometer as said
from app.summaries.numbers import extent_record, led

if TYPE_CHECKING:  # a run is told to be of another kind before what computes is imported
    from app.sound.listening import ListeningPanel, PlayedSignals
    from app.sound.stretch import RecordingStretch

RANGES = {"snr": (-20.0, 120.0), "stretch": (0.25, 30.0), "largest_sigma": (0.01, 10.0)}
"""dB; seconds of sound to a reading: shorter ones hold no decay of a resonance; K."""


@dataclass(frozen=True, kw_only=True)
class ThermometerRequest:
    """A recording of what was played and answered, or a sound to simulate it with.

    Attributes
    ----------
    run : Path
        Run folder with laws.h5 and filters.h5 or compensation.h5.
    drive, response : Path or None
        Sound files of the volts on every patch, and of the listening patch's charge.
    simulate : Path or None
        Instead of both: a sound, played and answered by the twin.
    temperature : str or None
        Of the simulated panel, as for `RenderRequest`.
    sensor : str or None
        Patch used as sensor; the panel's last where it is None.
    snr : float
        Between simulated response and white noise, dB.
    seed : int
        Of the simulated noise.
    stretch : float
        Seconds of sound to a reading.
    largest_sigma : float
        K above which a reading is refused.
    twin : Path or None
        Twin file whose laws are taken.
    """

    run: Path
    drive: Path | None = None
    response: Path | None = None
    simulate: Path | None = None
    temperature: str | None = None
    sensor: str | None = None
    snr: float = 20.0
    seed: int = 0
    stretch: float = 1.0
    largest_sigma: float = 1.0
    twin: Path | None = None

    def __post_init__(self) -> None:
        """Raise UnsuitedOptionError for options that exclude each other, and numbers outside their ranges."""
        if self.simulate is None and (self.drive is None or self.response is None):
            raise UnsuitedOptionError(
                "name --drive and --response of a recording, or --simulate SOUND --temperature T"
            )
        if self.simulate is not None and (self.drive is not None or self.response is not None):
            raise UnsuitedOptionError("--simulate takes the place of --drive and --response")
        if (self.simulate is None) != (self.temperature is None):
            raise UnsuitedOptionError("--simulate and --temperature belong together")
        for name, (low, high) in RANGES.items():
            value = getattr(self, name)
            if not low <= value <= high:
                option = name.replace("_", "-")
                raise UnsuitedOptionError(f"--{option} {value:g}: allowed are {low:g} to {high:g}")
        if self.seed < 0:
            raise UnsuitedOptionError(f"--seed {self.seed}: allowed are 0 and more")


@dataclass(frozen=True)
class MeasuredTemperatures:
    """Result of the thermometer stage.

    Attributes
    ----------
    stretches : list of RecordingStretch
        A reading each, and the track through all.
    by_laws : float
        Standard deviation of the last temperature by the law of E, K; infinite where there is none.
    true : (n,) ndarray or None
        Temperatures of a simulated panel, degrees Celsius.
    file : Path or None
        thermometer.csv; None where nothing was written.
    extent : CampaignExtent or None
        Of the campaign that the laws come from.
    notes : tuple of str
        For people.
    """

    stretches: "list[RecordingStretch]"
    by_laws: float
    true: Real | None
    file: Path | None
    extent: CampaignExtent | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)

    @property
    def accepted(self) -> bool:
        """Whether a reading was accepted."""
        return any(not stretch.reading.refused for stretch in self.stretches)

    def record(self) -> dict[str, Any]:
        """Return what ``--json`` prints; null where a reading was refused."""
        found = said.record(self.stretches, self.by_laws, self.true, self.file)
        return found | extent_record(self.extent)

    def __repr__(self) -> str:
        """Say in one line how warm the panel was at the end."""
        if not self.accepted:
            where = "" if self.file is None else f"; {self.file}"
            return f"none of {len(self.stretches)} stretches gives a temperature{where}"
        return f"{led(self.extent)}{said.summary(self.stretches, self.by_laws, self.true, self.file)}"


def compute(request: ThermometerRequest, out: Path | None, report: Progress) -> MeasuredTemperatures:
    """Read a panel's temperature, and write ``thermometer.csv`` where a folder is named for it.

    Parameters
    ----------
    request : ThermometerRequest
    out : Path or None
        Folder for the file.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        For a run or sounds that cannot be used, a patch that the panel does not have, and temperatures outside
        what laws or filters cover.
    """
    sent = shipment(request.run, None, "thermometer")
    origin = laws_for(request.run, request.twin, "thermometer")
    laws = sent.panel.plate.grown(origin.laws)
    span = range_of(sent.panel, laws, origin.path, origin.extent)
    place = _sensor(sent, request.sensor)

    from app.sound.listening import ListeningPanel, listened
    from app.sound.stretch import write_stretches
    from app.twins.panel_twin import panel_twin

    with nullcontext() if out is None else run_folder(request.run, out):
        panel = ListeningPanel(panel_twin(sent.panel, laws, report), laws, place)
        signals, course = _signals(request, sent, panel, report)
        band = sent.panel.filters.edges
        stretches = listened(panel, signals, band, span, request.stretch, request.largest_sigma, report)
    true = None if course is None else course.at([one.time for one in stretches])
    file = None if out is None else write_stretches(stretches, out, true)
    refused = sorted({one.reading.refused for one in stretches} - {""})[:3]
    last = stretches[-1].temperature
    by_laws = math.inf if all(one.reading.refused for one in stretches) else panel.law_sigma(last)
    notes = (*origin.notes, *(f"refused: {reason}" for reason in refused))
    return MeasuredTemperatures(stretches, by_laws, true, file, origin.extent, notes)


def _sensor(sent: Shipment, sensor: str | None) -> int:
    """Index of the sensing patch; ResultFileError if there is none."""
    names = [patch.id for patch in sent.panel.patch]
    if len(names) < 2:
        raise ResultFileError(
            "a panel that is its own thermometer has two or more patches: one listens to the others"
        )
    if sensor is None:
        return len(names) - 1
    if sensor not in names:
        raise ResultFileError(f"--sensor {sensor}: no patch of this panel; allowed: {', '.join(names)}")
    return names.index(sensor)


def _signals(
    request: ThermometerRequest, sent: Shipment, panel: "ListeningPanel", report: Progress
) -> "tuple[PlayedSignals, TemperatureProgramme | None]":
    """Return drive and response, and the course of a simulated panel's temperature."""
    from app.sound.listening import recorded, simulated

    if request.simulate is not None and request.temperature is not None:
        with opened_sound(request.simulate, sent.filters.sample_rate) as sound:
            course = programme(request.temperature, sound.seconds)
            require_covered(sent, panel.laws, course)
            report("Simulated panel", 0.0)
            noise = np.random.default_rng(request.seed)
            signals = simulated(sound, sent, panel, course, request.snr, noise)
            report("Simulated panel", 1.0)
            return signals, course
    if request.drive is None or request.response is None:
        raise TypeError("neither a recording nor a simulation")  # excluded by the request
    with opened_sound(request.drive) as played, opened_sound(request.response) as measured:
        return recorded(played, measured, panel, sent.names, sent.panel.filters.edges[1]), None
