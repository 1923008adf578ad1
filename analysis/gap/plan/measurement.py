"""Measurements that could be made next: campaigns on the same plate with their sweeps, and tools in the hand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Real
from analysis.declaration.plate import Plate
from analysis.experiment import Experiment, Protocol
from analysis.gap.data.groups import LawSmoothness, TemperatureGroups
from analysis.gap.data.preparation import compressed, grouped
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.state import GapState, clipped_laws, plain_state
from analysis.gap.thresholds import SHARPEST
from analysis.material import MaterialBox
from analysis.recordings.frf import Frf

MOST_TEMPERATURES = 8
"""Temperatures of a planned campaign, at most: more take oven time in proportion, and tell effects apart no better
than their number's square root."""
CHANNEL = "further"
"""Beginning of the names of outputs that the recorded campaign lacks."""
PREPARED = 0.5
"""Hours to bring plate and oven to the start of a campaign, and to look at the first sweeps."""
REST = 1.0 / 6.0
"""Hours of rest at the start of every leg."""
APPROACH = 3.0
"""K/min on the way to the start of a leg."""
LEAD = 4.0
"""K of ramp before the first and after the last temperature."""
AT_REST = 0.75
"""Hours for each temperature where the oven rests at it."""
FASTER, LOUDER, WIDER, FURTHER = 2.0, 3.0, 1.25, 0.35
"""Factors on ramp rate, drive level, upper end of the band; and on the range of temperatures, at each end."""
MORE = 1.2
"""Least factor on a rate or a level: less is no other measurement."""
SENSORS = (3, 3)
"""Places along x and y that are tried for a further sensor."""
KNOWN_MASS = 0.02
"""Of the plate's mass: some grams, which shift modes by as much as a real load and are weighed to a thousandth."""
OVEN_FIXED = ("draught_gradient", "thermal_gradient")
"""Effects that stay with the oven when the plate is turned by half a turn; their amplitudes then change sign."""

Readings = Mapping[tuple[str, str], float]
"""Standard deviations with which parameters of effects, (effect, parameter), are measured by hand."""


@dataclass(frozen=True)
class Measurement:
    """A measurement that could be made next.

    Attributes
    ----------
    key : str
        Kind of it, for files and for ``--hours``.
    words : str
        What to do, one sentence.
    hours : float
        Of a laboratory.
    experiment : Experiment or None
        Declaration of the campaign; None where the recorded campaign stays and something is measured by hand.
    place : (float, float) or None
        Of a further sensor or a known mass, m.
    mass : float
        Of a known mass there, kg.
    turned : tuple of str
        Effects whose amplitudes change sign.
    readings : mapping
        Standard deviations of parameters of effects that are measured by hand.
    sharper : mapping
        The same of declared quantities.
    """

    key: str
    words: str
    hours: float
    experiment: Experiment | None = None
    place: tuple[float, float] | None = None
    mass: float = 0.0
    turned: tuple[str, ...] = ()
    readings: Readings = field(default_factory=dict)
    sharper: Mapping[tuple[str, str], float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.hours > 0.0:
            raise ValueError(f"{self.key}: {self.hours:g} hours; more than 0 are needed")


@dataclass(frozen=True)
class Reach:
    """What a rig can do; without limits where the rig is not known.

    Attributes
    ----------
    level : float
        Largest level of the drive, in its unit.
    temperatures : (float, float)
        Lowest and highest temperature, degrees Celsius.
    rate : float
        Steepest ramp, K/min.
    highest : float
        Upper end of the widest band, Hz.
    """

    level: float = np.inf
    temperatures: tuple[float, float] = (-np.inf, np.inf)
    rate: float = np.inf
    highest: float = np.inf


KINDS = (
    "both_ramps",
    "faster_ramp",
    "second_level",
    "wider_band",
    "other_temperatures",
    "further_sensor",
    "known_mass",
    "turned_plate",
    "scale",
    "micrometer",
    "calliper",
    "thermocouples",
    "channel_test",
)
"""Keys of all measurements."""


def campaigns(experiment: Experiment, reach: Reach | None = None) -> tuple[Measurement, ...]:
    """List other campaigns on a recorded plate, one change each but for the number of temperatures.

    Parameters
    ----------
    experiment : Experiment
        As recorded.
    reach : Reach, optional
        Of the rig; what it cannot do is left out.

    Returns
    -------
    tuple of Measurement
        Without places of sensors and masses, see `placed`.
    """
    now, rig = experiment.protocol, reach or Reach()
    few = now.model_copy(update={"temperatures": thinned(now.temperatures)})
    both = few.model_copy(update={"directions": ("up", "down")})
    found = []
    if len(now.directions) == 1 and now.ramp_rate > 0.0:
        found.append(_campaign(experiment, both, "both_ramps", "Record the way up and the way down, {T}."))
    rate = min(FASTER * now.ramp_rate, rig.rate)
    if rate > MORE * now.ramp_rate > 0.0:
        faster = both.model_copy(update={"ramp_rate": rate})
        words = f"Record both ramps at {rate:.3g} K/min, {{T}}."
        found.append(_campaign(experiment, faster, "faster_ramp", words))
    level = float(f"{min(LOUDER * max(now.levels), rig.level):.2g}")
    if level > MORE * max(now.levels):
        louder = few.model_copy(update={"levels": (*now.levels, level)})
        words = f"Drive it at {' and '.join(f'{one:g}' for one in louder.levels)} V, {{T}}."
        found.append(_campaign(experiment, louder, "second_level", words))
    high = float(np.floor(min(WIDER * now.band[1], rig.highest, 0.4 * experiment.acquisition.sample_rate)))
    if high > 1.05 * now.band[1]:
        wider = few.model_copy(update={"band": (now.band[0], high)})
        words = f"Sweep from {now.band[0]:g} to {high:g} Hz, {{T}}."
        found.append(_campaign(experiment, wider, "wider_band", words))
    if len(now.temperatures) > 1:
        others = widened(few.temperatures, rig.temperatures)
        if others[0] < now.temperatures[0] or others[-1] > now.temperatures[-1]:
            other = few.model_copy(update={"temperatures": others})
            found.append(_campaign(experiment, other, "other_temperatures", "Record a wider range, {T}."))
    words = "Turn the plate by half a turn about its normal, leave the rest as it is, and record again, {T}."
    found.append(replace(_campaign(experiment, few, "turned_plate", words), turned=OVEN_FIXED))
    return tuple(found)


def placed(experiment: Experiment) -> tuple[Measurement, ...]:
    """List campaigns with a further sensor, or with a known mass, at each of some places."""
    now = experiment.protocol
    few = now.model_copy(update={"temperatures": thinned(now.temperatures)})
    mass = float(f"{KNOWN_MASS * experiment.plate.mass:.1g}")
    found = []
    for x, y in places(experiment.plate):
        where = f"at x {1e3 * x:.0f}, y {1e3 * y:.0f} mm"
        words = f"Read the motion {where} too (laser, or a light accelerometer declared with its mass), {{T}}."
        found.append(replace(_campaign(experiment, few, "further_sensor", words), place=(x, y)))
    for x, y in places(experiment.plate)[::2]:
        where = f"at x {1e3 * x:.0f}, y {1e3 * y:.0f} mm"
        words = (
            f"Fix {1e3 * mass:.3g} g (weighed to 0.01 g) {where}, record again, {{T}}, and compare with "
            "--twin, so that the mass is known."
        )
        found.append(replace(_campaign(experiment, few, "known_mass", words), place=(x, y), mass=mass))
    return tuple(found)


def hand_tools(experiment: Experiment) -> tuple[Measurement, ...]:
    """List what is measured without another campaign, with the standard deviations of a careful workshop."""
    patches = [patch.id for patch in experiment.patch]
    gradient = {"gx": 0.2, "gy": 0.2}
    return (
        Measurement(
            "scale",
            "Weigh the plate as it hangs, and what is fixed to it (cables, strings, sensors), to 0.02 g.",
            0.25,
            readings={(name, "mass"): 2e-5 for name in ("point_mass", "string_mass", "accelerometer_mass")},
            sharper={("plate_mass", "share"): 2e-5 / experiment.plate.mass},
        ),
        Measurement(
            "micrometer",
            "Measure the thickness with a micrometer at nine points: the middle, the corners, the sides.",
            0.25,
            readings={
                ("thickness_taper", "tx"): 0.0015,
                ("thickness_taper", "ty"): 0.0015,
                ("thickness_crown", "cx"): 0.003,
                ("thickness_crown", "cy"): 0.003,
            },
            sharper={("plate_thickness", "share"): 0.001},
        ),
        Measurement(
            "calliper",
            "Measure where the patches sit, and both sides of the plate, with a calliper.",
            0.25,
            readings={("sensor_offset", "dx"): 1e-4, ("sensor_offset", "dy"): 1e-4},
            sharper={
                **{(f"patch_place {name}", axis): 1e-4 for name in patches for axis in ("dx", "dy")},
                **{(f"plate_length_{axis}", "longer"): 1e-4 for axis in ("x", "y")},
            },
        ),
        Measurement(
            "thermocouples",
            "Put thermocouples on the middle and on all sides of the plate, and repeat a ramp without sweeps.",
            1.0 + oven_hours(experiment.protocol.model_copy(update={"directions": ("up",)})),
            readings={
                **{(name, g): s for name in ("thermal_gradient", "draught_gradient") for g, s in gradient.items()},
                **{("thermal_crown", g): s for g, s in gradient.items()},
                ("thermal_lag", "tau"): 20.0,
            },
            sharper={("plate_lag", "behind"): 20.0},
        ),
        Measurement(
            "channel_test",
            "Connect the drive's signal to every input through a T-piece, then pull it and drive again, and "
            "compare the channels.",
            0.5,
            readings={
                ("channel_skew", "delay"): 1e-7,
                ("high_pass", "corner"): 0.2,
                ("low_pass", "time_constant"): 5e-7,
                ("feedthrough", "gain"): 1e-4,
                ("crosstalk", "gain"): 1e-4,
                ("insulation_leak", "leak25"): 0.02,
            },
        ),
    )


def oven_hours(protocol: Protocol) -> float:
    """Hours that the oven takes for a campaign: rests, approaches and ramps of all legs."""
    span = protocol.temperatures[-1] - protocol.temperatures[0]
    if protocol.ramp_rate == 0.0:
        return AT_REST * len(protocol.temperatures) * len(protocol.directions)
    ramp = (span + 2.0 * LEAD) / protocol.ramp_rate / 60.0
    back = span / APPROACH / 60.0 if len(protocol.directions) == 1 else 0.5 * span / APPROACH / 60.0
    return len(protocol.directions) * (ramp + REST) + back


def thinned(temperatures: Sequence[float]) -> tuple[float, ...]:
    """Return every so many of some temperatures, so that at most `MOST_TEMPERATURES` are left."""
    every = int(np.ceil(len(temperatures) / MOST_TEMPERATURES))
    return tuple(temperatures[::every])


def widened(temperatures: Sequence[float], allowed: tuple[float, float] = (-np.inf, np.inf)) -> tuple[float, ...]:
    """Return even temperatures further to both sides, by whole steps of those given, within those allowed.

    Parameters
    ----------
    temperatures : sequence of float
        Ascending, degrees Celsius.
    allowed : (float, float), optional

    Returns
    -------
    tuple of float
        At most `MOST_TEMPERATURES`.
    """
    step = float(np.median(np.diff(temperatures)))
    more = max(round(FURTHER * (len(temperatures) - 1)), 1)
    low, high = temperatures[0], temperatures[-1]
    below = max(min(more, int((low - allowed[0]) // step) if np.isfinite(allowed[0]) else more), 0)
    above = max(min(more, int((allowed[1] - high) // step) if np.isfinite(allowed[1]) else more), 0)
    count = len(temperatures) - 1 + below + above
    every = int(np.ceil((count + 1) / MOST_TEMPERATURES))
    return tuple(round(low + (k * every - below) * step, 6) for k in range(count // every + 1))


def places(plate: Plate) -> list[tuple[float, float]]:
    """Places on a plate at which a sensor or a mass may be put, away from the lines of symmetry, m."""
    low, high = np.array(plate.bounds)
    shares = [(np.arange(n) + 0.5) / n + 0.07 for n in SENSORS]
    grid = np.array([(x, y) for x in shares[0] for y in shares[1]])
    points = low + grid * (high - low)
    return [(round(float(x), 3), round(float(y), 3)) for x, y in points[plate.contains(points)]]


def _campaign(experiment: Experiment, protocol: Protocol, key: str, words: str) -> Measurement:
    said = f"{len(protocol.temperatures)} temperatures from {protocol.temperatures[0]:g} to "
    said += f"{protocol.temperatures[-1]:g} °C"
    if len(protocol.temperatures) == 1:
        said = f"at {protocol.temperatures[0]:g} °C"
    changed = experiment.model_copy(update={"protocol": protocol})
    return Measurement(key, words.format(T=said), PREPARED + oven_hours(protocol), changed)


def planned_sweeps(
    frf: Frf,
    recorded: GapSweeps,
    state: GapState,
    protocol: Protocol,
    box: MaterialBox,
    further: int = 0,
) -> tuple[GapSweeps, GapState]:
    """Return the sweeps of a planned campaign, with noise and no signal, and the state of the twin in it.

    Parameters
    ----------
    frf : Frf
        Recorded: its noise, over level, is that of the planned sweeps; beyond its band that at the band's ends.
    recorded : GapSweeps
        Of `frf`.
    state : GapState
        Fitted to them. Beyond their temperatures laws go on in straight lines.
    protocol : Protocol
        Of the planned campaign.
    box : MaterialBox
        Within which the twin can be asked.
    further : int
        Number of outputs that `frf` lacks, the last ones; their noise is set by `with_noise_of`.

    Returns
    -------
    sweeps : GapSweeps
    state : GapState
    """
    places = [
        (float(t), way, float(level), source)
        for way in protocol.directions
        for t in protocol.temperatures
        for level in protocol.levels
        for source in frf.driving
    ]
    frequency, excluded = _lines(frf, protocol)
    temperature = np.array([t for t, *_ in places])
    noise = {source: _noise(frf, source, frequency, protocol) for source in frf.driving}
    variance = np.array([noise[source] / level**2 for *_, level, source in places])
    variance = np.concatenate([variance, np.repeat(variance[:, :1], further, axis=1)], axis=1)
    count, channels = len(places), len(frf.channels) + further
    planned = replace(
        frf,
        temperature=temperature,
        direction=tuple(way for _, way, *_ in places),
        level=np.array([level for *_, level, _ in places]),
        frequency=frequency,
        h=np.zeros((count, channels, frequency.size), dtype=complex),
        variance=variance,
        coherence=np.ones((count, channels, frequency.size)),
        excluded=excluded,
        channels=(*frf.channels, *(f"{CHANNEL} {k + 1}" for k in range(further))),
        labels=(),
        units=(),
        source=None if frf.source is None else np.array([source for *_, source in places]),
        repeats_dof=None,
        shift=None,
    )
    groups = TemperatureGroups.of(temperature)
    laws = clipped_laws(box, laws_at(recorded, state, groups.reference))
    sharp = SHARPEST * float(np.exp(laws[:, 2].min()))
    sweeps = grouped(
        planned,
        compressed(planned, sharp),
        groups,
        laws,
        protocol=protocol,
        reading_sigma=recorded.reading_sigma,
        twin_error=recorded.twin_error,
    )
    begun = plain_state(groups, laws, state.log_gain, state.effects)
    return sweeps, replace(begun, declared=state.declared)


def laws_at(recorded: GapSweeps, state: GapState, temperature: Real) -> Real:
    """Laws (G, 3) at temperatures, degrees Celsius: between those of a fit interpolated, beyond in straight lines.

    Parameters
    ----------
    recorded : GapSweeps
    state : GapState
        Fitted to them.
    temperature : (G,) ndarray

    Returns
    -------
    (G, 3) ndarray
        log E, nu and log eta.
    """
    from scipy.interpolate import PchipInterpolator

    at, laws = recorded.groups.reference, state.laws
    if at.size == 1:
        return np.repeat(laws, len(temperature), axis=0)
    slope, _ = LawSmoothness.of(at, laws).derivatives(laws)
    found = np.asarray(PchipInterpolator(at, laws, extrapolate=True)(np.clip(temperature, at[0], at[-1])))
    for end, beyond in ((0, np.minimum(temperature - at[0], 0.0)), (-1, np.maximum(temperature - at[-1], 0.0))):
        found = found + beyond[:, None] * slope[end]
    return np.asarray(found)


def with_noise_of(sweeps: GapSweeps, size: Sequence[float], further: int) -> GapSweeps:
    """Give further outputs the noise, relative to the signal, of the first recorded one.

    Parameters
    ----------
    sweeps : GapSweeps
        As from `planned_sweeps`.
    size : sequence of float
        rms of every output's predicted signal, (K,).
    further : int
        Number of the last outputs.

    Returns
    -------
    GapSweeps
    """
    ratio = np.ones(len(size))
    ratio[-further:] = (np.asarray(size)[-further:] / size[0]) ** 2
    return replace(sweeps, compressed=tuple(one.rescaled(ratio) for one in sweeps.compressed))


def _lines(frf: Frf, protocol: Protocol) -> tuple[Real, "np.ndarray[tuple[int], np.dtype[np.bool_]]"]:
    """Lines of the planned band, with the spacing of those recorded, and which of them are left out."""
    step = float(np.median(np.diff(frf.frequency)))
    low, high = protocol.band
    below = np.arange(frf.frequency[0] - step, low - 1e-9 * step, -step)[::-1]
    above = np.arange(frf.frequency[-1] + step, high + 1e-9 * step, step)
    inside = (frf.frequency >= low - 1e-9 * step) & (frf.frequency <= high + 1e-9 * step)
    frequency = np.concatenate([below, frf.frequency[inside], above])
    left_out = np.concatenate([np.zeros(below.size, bool), frf.excluded[inside], np.zeros(above.size, bool)])
    return frequency, left_out


def _noise(frf: Frf, source: int, frequency: Real, protocol: Protocol) -> Real:
    """Variance (K, F) of one sweep from an input at a level of 1; of a logarithmic sweep's own fall beyond."""
    chosen = frf.driven_by == source
    at_one = np.median(frf.variance[chosen] * frf.level[chosen, None, None] ** 2, axis=0)
    found = np.array([np.interp(frequency, frf.frequency, row) for row in at_one])
    if protocol.sweep == "logarithmic":  # its power per line falls as 1/f
        inner = np.clip(frequency, frf.frequency[0], frf.frequency[-1])
        found = found * (frequency / inner)
    return np.asarray(found)
