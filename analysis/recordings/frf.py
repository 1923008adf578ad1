"""Frequency response functions of a campaign: coherence and variance per line, and which lines to leave out.

The sweeps of one of several actuators that drove the plate in turn.
"""

import hashlib
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.channel import transfer_unit
from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes
from analysis.estimation.ringing import ringing
from analysis.experiment import Experiment
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.labelled import Labelled, LabelledArrays
from analysis.recordings.campaign import Campaign
from analysis.recordings.frf_campaign import AnyCampaign, FrfCampaign, FrfSweep, Noise
from analysis.recordings.h1 import sweep_h1
from analysis.recordings.mains import mains_lines, other_fundamentals
from analysis.recordings.noise_power import noise_power, rough_power, single_repeat_power


def still_ringing(campaign: Campaign) -> str:
    """Say which response rings most where its record ends; empty where all are at rest."""
    tail, rate = campaign.experiment.protocol.tail, campaign.experiment.acquisition.sample_rate
    names = [output.id for output in campaign.experiment.outputs]
    seen = [
        (found, sweep, name)
        for sweep in campaign.sweeps
        for name, response in zip(names, sweep.responses, strict=True)
        if (found := ringing(response.astype(float), rate, tail)) is not None
    ]
    if not seen:
        return ""
    worst, sweep, name = max(seen, key=lambda one: one[0].share)
    where = f"{name} at {sweep.temperature:.1f} °C ({len(seen)} of {len(campaign.sweeps) * len(names)} responses)"
    return f"{where} {worst.message(tail, 'lengthen protocol.tail')}"


ROUNDING_NOISE = 1e-12
"""Noise below this share of an FRF is that of rounding in double precision: no converter is so good."""

LONGEST_SHOWN = 60
"""Letters of a value that a message shows."""

HARMONICS_APART = 6.0
"""Spacings of lines between harmonics of the mains below which none is left out: three lines go for each harmonic,
which would then be half of all."""


@dataclass(frozen=True)
class Frf(Labelled):
    """FRFs of a campaign, one row per sweep in the order recorded.

    Attributes
    ----------
    temperature : (T,) ndarray
        Mean reading during the sweep, on the plate if there was a sensor on it, else the oven's, degrees Celsius.
    direction : tuple of str
        ``up`` or ``down``, per sweep.
    level : (T,) ndarray
        Drive amplitude, V or N.
    frequency : (F,) ndarray
        Hz, even spacing, inside the protocol's band.
    h : (T, K, F) complex ndarray
        H1 = G_yu / G_uu, in `units`.
    variance : (T, K, F) ndarray
        E|h - H|^2 of the estimate (real and imaginary part together), units squared.
    coherence : (T, K, F) ndarray
        Of a single repeat, 0 to 1.
    excluded : (F,) bool ndarray
        Lines at mains harmonics: shown, never fitted.
    channels : tuple of str
        Sensor names.
    notes : tuple of str
        What was left out or looks wrong, for people.
    labels, units : tuple of str
        Name with unit, and unit, of every channel's transfer; of sensor volts by drive volts where empty. Those of
        the first input come first, then those of the next.
    level_units : tuple of str
        Of the levels of each input; as `units` have it where empty.
    source : (T,) int ndarray or None
        Which input drove each sweep; None where there is but one.
    sources : tuple of str
        Names of the inputs; empty where there is but one.
    repeats_dof : (T,) int ndarray or None
        Degrees of freedom that a sweep's repeats give the variance of one line, before it is averaged over lines;
        0 for one repeat. None where they are not known.
    at_rest : bool
        Whether all responses came to rest within their records, which have no window.
    shift : (T,) ndarray or None
        By how much all frequencies moved over the repeats of each sweep, see `analysis.recordings.h1`; None where
        that is not known.
    """

    temperature: NDArray[np.float64]
    direction: tuple[str, ...]
    level: NDArray[np.float64]
    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    variance: NDArray[np.float64]
    coherence: NDArray[np.float64]
    excluded: NDArray[np.bool_]
    channels: tuple[str, ...]
    notes: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    level_units: tuple[str, ...] = ()
    source: NDArray[np.int_] | None = None
    sources: tuple[str, ...] = ()
    repeats_dof: NDArray[np.int_] | None = None
    at_rest: bool = False
    shift: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        by_sweep = dict.fromkeys(("temperature", "direction", "level", "source", "repeats_dof", "shift"), "T")
        arrays = dict.fromkeys(("h", "variance", "coherence"), "T K F")
        check_shapes(self, **by_sweep, channels="K", frequency="F", excluded="F", **arrays)
        check_finite(self, "temperature", "h", "variance")
        check_ascending(self, "frequency")
        check_range(self, 0.0, np.inf, "frequency", unit="Hz")
        check_range(self, 0.0, np.inf, "variance")
        if self.source is not None and ((self.source < 0) | (self.source >= len(self.sources))).any():
            raise ValueError(f"source {self.source} must name one of {len(self.sources)} inputs for each sweep")

    def __repr__(self) -> str:
        """Sweeps, temperatures, channels and lines in one line, and the notes, a line each."""
        t, lines = self.temperature, self.frequency
        sweeps = f"{len(t)} sweeps, {t.min():z.1f} to {t.max():z.1f} °C, sensors {', '.join(self.channels)}"
        band = f"{len(lines)} lines from {lines[0]:g} to {lines[-1]:g} Hz"
        return "\n  ".join([f"<Frf: {sweeps}, {band}>", *self.notes])

    @property
    def driven_by(self) -> NDArray[np.int_]:
        """Which input drove each sweep: (T,) int ndarray."""
        return np.zeros(len(self.temperature), dtype=int) if self.source is None else self.source

    @property
    def driving(self) -> list[int]:
        """Inputs that drove, ascending."""
        return [int(source) for source in np.unique(self.driven_by)]

    def of_source(self, source: int) -> "Frf":
        """Return the sweeps that one input drove, of those there are."""
        source = _number("source", source, max(len(self.sources), 1))
        return self._only(np.flatnonzero(self.driven_by == source))

    def label(self, channel: int, sweep: int = 0) -> str:
        """Name a channel's transfer in a sweep, with its unit."""
        place = self._place(channel, sweep)
        return self.labels[place] if self.labels else f"{self.channels[channel]}/drive [V/V]"

    def unit(self, channel: int, sweep: int = 0) -> str:
        """Return the unit of a channel's transfer in a sweep."""
        place = self._place(channel, sweep)
        return self.units[place] if self.units else "V/V"

    def level_unit(self, sweep: int = 0) -> str:
        """Return the unit of the level at which a sweep was driven."""
        sweep = _number("sweep", sweep, len(self.temperature))
        return self.level_units[self.driven_by[sweep]] if self.level_units else self.unit(0, sweep).split("/")[-1]

    def drive(self, sweep: int) -> str:
        """Say how a sweep was driven: ``10 V``, and ``2 N at hammer`` where there are several inputs."""
        sweep = _number("sweep", sweep, len(self.temperature))
        where = f" at {self.drives[sweep]}" if self.sources else ""
        return f"{self.level[sweep]:g} {self.level_unit(sweep)}{where}"

    @property
    def drives(self) -> tuple[str, ...]:
        """Name of the input that drove each sweep; empty where there is one."""
        return tuple(self.sources[k] for k in self.driven_by) if self.sources else ()

    def labelled(self) -> LabelledArrays:
        """FRFs, variance and coherence over sweep, channel and frequency."""
        lines = ("sweep", "channel", "frequency")
        units = dict.fromkeys(self.units) or {self.unit(0): None}
        levels = dict.fromkeys(self.level_unit(sweep) for sweep in range(len(self.temperature)))
        driven = {} if not self.sources else {"drive": (("sweep",), np.array(self.drives))}
        return LabelledArrays(
            {"h": (lines, self.h), "variance": (lines, self.variance), "coherence": (lines, self.coherence)},
            {
                "temperature": (("sweep",), self.temperature),
                "direction": (("sweep",), np.array(self.direction)),
                "level": (("sweep",), self.level),
                **driven,
                "channel": (("channel",), np.array(self.channels)),
                "frequency": (("frequency",), self.frequency),
                "excluded": (("frequency",), self.excluded),
            },
            {"h": " or ".join(units), "temperature": "degC", "frequency": "Hz", "level": " or ".join(levels)},
            self.notes,
        )

    def _place(self, channel: int, sweep: int) -> int:
        channel = _number("channel", channel, len(self.channels))
        sweep = _number("sweep", sweep, len(self.temperature))
        return len(self.channels) * int(self.driven_by[sweep]) + channel

    @property
    def noise_floor(self) -> NDArray[np.float64]:
        """Noise of each sweep over its lines, as a share of rms|h|: (T,) ndarray."""
        used = ~self.excluded
        noise = self.variance[:, :, used].sum((1, 2))
        return np.asarray(np.sqrt(noise / (np.abs(self.h[:, :, used]) ** 2).sum((1, 2))))

    def require_noise(self) -> None:
        """Raise ValueError where a sweep's repeats tell no noise, so that its lines cannot be weighed."""
        used = ~self.excluded
        noise, size = self.variance[:, :, used].min(-1), (np.abs(self.h[:, :, used]) ** 2).mean(-1)
        for sweep, channel in np.argwhere(~(noise > ROUNDING_NOISE**2 * size))[:1]:
            raise ValueError(
                f"channel {self.channels[channel]} at {self.temperature[sweep]:.1f} °C ({self.direction[sweep]}): "
                "lines without variance, as no measurement has them. If they are copies of one recording, record "
                "at least two repeats of each sweep; if they were computed, add noise, 0.1 % of their rms"
            )

    def without(self, sweeps: Sequence[int], why: str) -> "Frf":
        """Return the FRFs without some sweeps, and a note for each, which `why` goes on.

        Raises TypeError for what are no numbers of sweeps and no text, ValueError for a sweep that is not there,
        where none would be left, and for an empty text.
        """
        count = len(self.temperature)
        if isinstance(sweeps, str | bytes) or not isinstance(sweeps, Iterable):
            raise TypeError(
                f"sweeps {_shown(sweeps)}: allowed is a list: each an integer, the sweep's number from 0"
            )
        given = list(dict.fromkeys(_whole("sweeps", s) for s in sweeps))
        wrong = [s for s in given if not 0 <= s < count]
        if wrong or len(given) == count:
            raise ValueError(
                f"sweeps {', '.join(map(str, wrong or given))}: 0 to {count - 1}, not all, are allowed"
            )
        if not _text("why", why).strip():
            raise ValueError("why '': allowed is a text that says why they are left out")
        kept = np.setdiff1d(np.arange(count), given)
        left_out = (
            f"sweep at {self.temperature[s]:.1f} °C ({self.direction[s]}, {self.drive(s)}) left out: {why}"
            for s in given
        )
        return replace(self._only(kept), notes=(*self.notes, *left_out))

    def _only(self, kept: NDArray[np.int_]) -> "Frf":
        return replace(
            self,
            temperature=self.temperature[kept],
            direction=tuple(self.direction[s] for s in kept),
            level=self.level[kept],
            h=self.h[kept],
            variance=self.variance[kept],
            coherence=self.coherence[kept],
            source=None if self.source is None else self.source[kept],
            repeats_dof=None if self.repeats_dof is None else self.repeats_dof[kept],
            shift=None if self.shift is None else self.shift[kept],
        )

    def on(self, experiment: Experiment, name: str = "FRFs as values") -> FrfCampaign:
        """Return them as a campaign of a declared plate, whose variances are stated: what stages take.

        Lines of `excluded` are found again, as for FRFs that were read; how far frequencies moved over the repeats
        is not kept. Raises ValueError where channels or inputs are not those that `experiment` declares, in order,
        and TypeError for what is no experiment.
        """
        if not isinstance(experiment, Experiment):
            raise TypeError(
                f"experiment {_shown(experiment)}: allowed is an Experiment, the plate's declaration; write "
                "experiment = flexura.load(folder).experiment"
            )
        _text("name", name)
        declared = tuple(one.id for one in experiment.outputs), tuple(one.id for one in experiment.inputs)
        if self.channels != declared[0] or (self.sources or declared[1][:1]) != declared[1]:
            drives = ", ".join(self.sources) or "one input"
            raise ValueError(
                f"FRFs of {', '.join(self.channels)} driven by {drives}; the plate declares "
                f"{', '.join(declared[0])} driven by {', '.join(declared[1])}"
            )
        stated: tuple[Noise, ...] = tuple("variance" for _ in self.channels)
        dof = np.zeros(len(self.temperature), dtype=int) if self.repeats_dof is None else self.repeats_dof
        sweeps = tuple(
            FrfSweep(
                temperature=float(self.temperature[s]),
                h=self.h[s],
                noise=stated,
                variance=self.variance[s],
                coherence=self.coherence[s],
                direction="up" if self.direction[s] == "up" else "down",
                level=float(self.level[s]),
                source=int(self.driven_by[s]),
                repeats_dof=int(dof[s]),
            )
            for s in range(len(self.temperature))
        )
        values = (self.temperature, self.frequency, self.h, self.variance)
        digest = hashlib.sha256(b"".join(np.ascontiguousarray(one).tobytes() for one in values)).hexdigest()
        return FrfCampaign(name, experiment, self.frequency, sweeps, {name: digest}, self.notes, self.at_rest)

    def turned(self, inverted: Sequence[str], source: int = 0) -> "Frf":
        """Return the FRFs with the sign of `inverted` channels turned in sweeps of an input, and a note on it."""
        if not inverted:
            return self
        unknown = [one for one in inverted if one not in self.channels]
        if isinstance(inverted, str) or unknown:
            raise ValueError(f"channels {inverted!r}: allowed is a list: each of {', '.join(self.channels)}")
        wrong = np.isin(self.channels, list(inverted)) & (self.driven_by == source)[:, None]
        every = set(inverted) == set(self.channels)
        many = every and len(inverted) > 1
        names = f"all {len(inverted)} channels are" if many else f"channel {', '.join(inverted)} is"
        there = (
            ", there or at what drives; a force that is counted along the motion pushes from below "
            '(side = "bottom" of its [[drive]])'
            if every
            else ""
        )
        driven = f" with {self.sources[source]} driven" if self.sources else ""
        note = (
            f"{names} inverted{driven}: wiring, patch polarity, or an accelerometer on the other side{there}; "
            "what follows is with the sign turned"
        )
        return replace(self, h=np.where(wrong, -1.0, 1.0)[:, :, None] * self.h, notes=(*self.notes, note))


def _whole(keyword: str, value: object) -> int:
    """Return a whole number; True is none, though Python counts with it."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise TypeError(f"{keyword} {_shown(value)}: allowed is an integer")
    return int(value)


def _number(keyword: str, value: object, count: int) -> int:
    """Return the number of one of `count` things, from 0."""
    number = _whole(keyword, value)
    if not 0 <= number < count:
        raise ValueError(f"{keyword} {number}: 0 to {count - 1} allowed")
    return number


def _text(keyword: str, value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{keyword} {_shown(value)}: allowed is a text")
    return value


def _shown(value: object) -> str:
    shown = repr(value)
    return shown if len(shown) <= LONGEST_SHOWN and "\n" not in shown else f"of type {type(value).__name__}"


def campaign_frf(campaign: AnyCampaign, *, mains: float = 50.0) -> Frf:
    """H1 of every sweep and sensor of a campaign, inside the protocol's band; FRFs read as such, with their noise.

    Lines at harmonics of `mains` [Hz] are excluded, and those of any other hum that the noise shows.
    Raises ValueError where the sweeps differ in length, so that they share no frequency lines.
    """
    if isinstance(campaign, FrfCampaign):
        return _given(campaign, mains)
    samples, rate = campaign.sweeps[0].drive.shape[1], campaign.experiment.acquisition.sample_rate
    grid = np.fft.rfftfreq(samples, 1.0 / rate).astype(np.float64)
    low, high = campaign.experiment.protocol.band
    inside = np.flatnonzero((grid >= low - 1e-9) & (grid <= high + 1e-9))
    lines = slice(int(inside[0]), int(inside[-1]) + 1)
    frequency, record = grid[lines], samples / rate
    frf = _all_sweeps(campaign, lines, frequency, mains_lines(frequency, mains, record))
    if rings := still_ringing(campaign):  # leakage has lines of its own, some where a hum would have them
        return replace(frf, notes=(*frf.notes, rings), at_rest=False)
    hums = _hums(frf)
    if not hums:
        return frf
    masked = np.any([frf.excluded, *(mains_lines(frequency, hum, record) for hum in hums)], axis=0)
    return _said_of_hums(_all_sweeps(campaign, lines, frequency, masked), hums)


def _hums(frf: Frf) -> list[float]:
    """Fundamentals of hum, other than the mains, that the roughness over frequency shows above the noise, Hz."""
    rough = np.array([[single_repeat_power(h) for h in sweep] for sweep in frf.h])
    ratio = rough / np.maximum(frf.variance, np.finfo(float).tiny)
    return other_fundamentals(frf.frequency, ratio, frf.excluded)


def _said_of_hums(frf: Frf, hums: Sequence[float]) -> Frf:
    found = " and ".join(f"{hum:.2f}" for hum in hums)
    return replace(frf, notes=(*frf.notes, f"mains hum at multiples of {found} Hz: these lines are left out too"))


def _given(campaign: FrfCampaign, mains: float) -> Frf:
    """FRFs that were read as such, with lines of mains hum excluded and noise smooth over the others."""
    frequency, record = campaign.frequency, 1.0 / campaign.spacing
    if mains < HARMONICS_APART * campaign.spacing:
        # most lines lie near some harmonic then, and each averages a hum with far more of the drive
        return _of_sweeps(campaign, np.zeros(len(frequency), dtype=bool))
    frf = _of_sweeps(campaign, mains_lines(frequency, mains, record))
    if all(noise == "neighbouring lines" for sweep in campaign.sweeps for noise in sweep.noise):
        return frf  # a hum is in the estimate of the noise itself
    hums = _hums(frf)
    if not hums:
        return frf
    masked = np.any([frf.excluded, *(mains_lines(frequency, hum, record) for hum in hums)], axis=0)
    return _said_of_hums(_of_sweeps(campaign, masked), hums)


def _of_sweeps(campaign: FrfCampaign, excluded: NDArray[np.bool_]) -> Frf:
    experiment, inputs, sweeps = campaign.experiment, campaign.experiment.inputs, campaign.sweeps
    dof = np.array([s.repeats_dof for s in sweeps])
    return Frf(
        temperature=np.array([s.temperature for s in sweeps]),
        direction=tuple(s.direction for s in sweeps),
        level=np.array([s.level for s in sweeps]),
        frequency=campaign.frequency,
        h=np.array([s.h for s in sweeps]),
        variance=np.array([_given_variance(s, excluded) for s in sweeps]),
        coherence=np.array([s.coherence for s in sweeps]),
        excluded=excluded,
        channels=tuple(output.id for output in experiment.outputs),
        notes=campaign.notes,
        labels=tuple(label for one in inputs for label in experiment.labels(one)),
        units=tuple(transfer_unit(output, one) for one in inputs for output in experiment.outputs),
        level_units=experiment.level_units,
        source=np.array([s.source for s in sweeps]) if len(inputs) > 1 else None,
        sources=tuple(one.id for one in inputs) if len(inputs) > 1 else (),
        repeats_dof=dof if dof.all() else None,
        at_rest=campaign.at_rest,
    )


def _given_variance(sweep: FrfSweep, excluded: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Variance (K, F) of the FRFs of a sweep."""
    made = []
    for noise, h, given in zip(sweep.noise, sweep.h, sweep.variance, strict=True):
        if noise != "variance":
            given = noise_power(rough_power(h) if noise == "neighbouring lines" else given, h, excluded)
        made.append(given)
    return np.array(made)


def _all_sweeps(
    campaign: Campaign, lines: slice, frequency: NDArray[np.float64], excluded: NDArray[np.bool_]
) -> Frf:
    samples = campaign.sweeps[0].drive.shape[1]
    experiment, inputs = campaign.experiment, campaign.experiment.inputs
    names = tuple(output.id for output in experiment.outputs)
    for sweep in campaign.sweeps:
        if sweep.drive.shape[1] != samples:
            raise ValueError(f"sweep {sweep.step} has {sweep.drive.shape[1]} samples, the first one {samples}")
    with ThreadPoolExecutor(2) as executor:  # transforms and sorting release the interpreter lock
        rows = executor.map(lambda sweep: sweep_h1(sweep, lines, excluded, names), campaign.sweeps)
    h, variance, coherence, repeats_dof, shift, notes = zip(*rows, strict=True)
    part = () if campaign.extent is None else (campaign.extent.note,)
    return Frf(
        temperature=np.array([s.temperature for s in campaign.sweeps]),
        direction=tuple(s.direction for s in campaign.sweeps),
        level=np.array([s.level for s in campaign.sweeps]),
        frequency=frequency,
        h=np.array(h),
        variance=np.array(variance),
        coherence=np.array(coherence),
        excluded=excluded,
        channels=names,
        notes=(*part, *(note for said in notes for note in said)),
        labels=tuple(label for one in inputs for label in experiment.labels(one)),
        units=tuple(transfer_unit(output, one) for one in inputs for output in experiment.outputs),
        level_units=campaign.level_units,
        source=np.array([s.source for s in campaign.sweeps]) if len(inputs) > 1 else None,
        sources=tuple(one.id for one in inputs) if len(inputs) > 1 else (),
        repeats_dof=np.array(repeats_dof),
        at_rest=True,
        shift=np.array(shift),
    )


def sweeps_of_actuator(frf: Frf, actuator: str | None) -> Frf:
    """Return the sweeps of an actuator, the first unless named, with a note where others drove too.

    Raises ValueError for one that did not drive.
    """
    if actuator is None and not frf.sources:
        return frf
    if actuator is not None and actuator not in frf.sources:
        known = ", ".join(frf.sources) or "none, only one drove the plate"
        raise ValueError(f"actuator {actuator!r} drove no sweep; allowed: {known}")
    source = 0 if actuator is None else frf.sources.index(actuator)
    note = f"modes of the sweeps that {frf.sources[source]} drove, of {', '.join(frf.sources)}: --actuator ID"
    return replace(frf.of_source(source), notes=(*frf.notes, note))


def sweeps_of_modes(frf: Frf, tracked: TrackedModes) -> NDArray[np.int_]:
    """Find the sweeps that modes were identified from: all, or those of one actuator.

    Parameters
    ----------
    frf : Frf
        T sweeps.

    Returns
    -------
    (T,) int ndarray
        Place of every sweep in `tracked`, -1 where it is not one of them. Of several actuators whose sweeps have
        the same temperatures, it is the one whose FRFs the modes miss least.
    """
    places = np.full(len(frf.temperature), -1)
    rows = (np.flatnonzero(frf.driven_by == source) for source in frf.driving)
    fitting = [some for some in rows if _same_sweeps(frf, some, tracked)]
    if fitting:
        own = min(fitting, key=lambda some: _missed(frf, some[0], tracked)) if len(fitting) > 1 else fitting[0]
        places[own] = np.arange(len(own))
    return places


def _same_sweeps(frf: Frf, rows: NDArray[np.int_], tracked: TrackedModes) -> bool:
    return bool(np.array_equal(frf.temperature[rows], tracked.temperature))


def _missed(frf: Frf, row: int, tracked: TrackedModes) -> float:
    """Share of a sweep's FRFs, in power, that the first modes leave inside the band they were found in."""
    modes = tracked.modes[0]
    inside = (frf.frequency >= modes.band[0]) & (frf.frequency <= modes.band[1]) & ~frf.excluded
    h = frf.h[row][:, inside]
    return float((np.abs(h - modes.synthesis(frf.frequency[inside])) ** 2).sum() / (np.abs(h) ** 2).sum())
