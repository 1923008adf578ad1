"""Filters in a weather, judged: temperatures of a panel over time, and what filters lose in them.

Contrast and level that filters lose while a panel's temperatures move, by what is known of them.
"""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.focusing.energy import EnergyForms
from analysis.focusing.performance import contrast, mean_response
from analysis.progress import Progress
from analysis.radiation.measures import third_octave_levels
from analysis.weather.family import Believed, FieldDesign, OwnThermometer, TiltFamily, plane

ONE, ONE_ROBUST, SEVERAL, SEVERAL_ROBUST, TILTED, OWN, OWN_TILTED = WAYS = (
    "one thermometer",
    "one, robust filters",
    "all thermometers",
    "all, robust filters",
    "all, filters of the tilt",
    "own response",
    "own, filters of the tilt",
)


@dataclass(frozen=True)
class WeatherFields:
    """Temperatures of a panel at t moments.

    Attributes
    ----------
    time : (t,) ndarray, s
    temperature : (t, Q) ndarray, °C
        At the points of the model.
    readings : (t, K) ndarray, °C
    places : (K, 2) ndarray
        Of the thermometers, -1 to 1 over the box around the plate.
    names : tuple of str
        Of the thermometers.
    """

    time: Real
    temperature: Real
    readings: Real
    places: Real
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        check_shapes(self, time="t", temperature="t Q", readings="t K", places="K 2", names="K")
        check_finite(self, "temperature", "readings")
        check_ascending(self, "time")


@dataclass(frozen=True)
class WeatherJudgement:
    """Filters in a weather, by W ways of knowing the field; against filters designed for the field itself.

    Attributes
    ----------
    ways : tuple of str
        Of `WAYS`.
    names : tuple of str
        Of the thermometers; the first is the one of the ways with one.
    places : (K, 2) ndarray
        Of the thermometers, -1 to 1 over the box around the plate.
    time : (t,) ndarray, s
    extent : (t, 3) ndarray
        Coldest, mean and warmest place of the plate, °C.
    readings : (t, K) ndarray, °C
    believed : (W, t, 3) ndarray
        Temperature in the middle, °C, and tilts along x and y, K, for which the filters are made.
    contrast : (W, t, F) ndarray
    known : (t, F) ndarray
        Contrast of filters designed for the field.
    level : (W, t, B) ndarray
        Third-octave levels less those of the filters designed for the field, dB: of the target, or at the loud
        listener where the difference is largest, if sound is aimed at.
    price : (2,) ndarray
        Contrast that the robust filters lose on a panel without a tilt: of the mean over the band, and at the
        worst line, at the worst temperature.
    across : float
        Tilt of the family of fields, K.
    """

    ways: tuple[str, ...]
    names: tuple[str, ...]
    places: Real
    time: Real
    extent: Real
    readings: Real
    believed: Real
    contrast: Real
    known: Real
    level: Real
    price: Real
    across: float

    def __post_init__(self) -> None:
        check_shapes(self, time="t", extent="t 3", readings="t K", names="K", known="t F", price="2")
        check_shapes(self, names="K", places="K 2")
        check_shapes(self, ways="W", time="t", believed="W t 3", contrast="W t F", level="W t B")
        check_finite(self, "contrast", "known", "level")

    @property
    def lost(self) -> Real:
        """Contrast lost (W, t, 2): of the mean over the band, and at the worst line."""
        less = self.known - self.contrast
        return np.stack([less.mean(axis=-1), less.max(axis=-1)], axis=-1)

    @property
    def largest(self) -> Real:
        """Largest loss (W, 2) over time, see `lost`."""
        return np.asarray(self.lost.max(axis=1))

    @property
    def level_error(self) -> Real:
        """Largest difference of a third-octave level (W,), dB."""
        return np.asarray(np.abs(self.level).max(axis=(1, 2)))

    @property
    def widest(self) -> float:
        """Largest difference of temperature across the plate, K."""
        return float((self.extent[:, 2] - self.extent[:, 0]).max())


RESPONSE_NOISE = 0.01
"""Standard deviation of the panel's own response, share of its root mean square."""


def judge_weather(
    design: FieldDesign,
    family: TiltFamily,
    fields: WeatherFields,
    limits: tuple[float, float],
    rng: np.random.Generator,
    report: Progress = lambda _stage, _share: None,
) -> WeatherJudgement:
    """Judge filters at every moment of a weather.

    Parameters
    ----------
    limits : (float, float)
        Of the laws, °C.
    rng : Generator
        Draws the noise of the panel's own response.
    report : callable, optional
        Called with the stage and the share done.
    """
    own = None
    if design.panel.patch and len(design.panel.patch) > 1:
        lines = design.panel.filters.frequency[design.band]
        own = OwnThermometer.of(design.model, lines, len(design.panel.patch), limits)
    last, moments = plane(fields.places, fields.readings[0]), []
    for number, (field, readings) in enumerate(zip(fields.temperature, fields.readings, strict=True), start=1):
        beliefs = _by_thermometers(fields.places, readings)
        if own is not None:
            last = own.read(_noisy(own.measured(field), rng), last)
            beliefs |= {OWN: last, OWN_TILTED: last}
        moments.append(_judged(design, family, field, beliefs))
        report("Weather", number / len(fields.time))
    believed, contrasts, level = (np.array(part) for part in zip(*moments, strict=True))
    extent = [fields.temperature.min(axis=1), fields.temperature.mean(axis=1), fields.temperature.max(axis=1)]
    return WeatherJudgement(
        ways=WAYS if own is not None else WAYS[: WAYS.index(OWN)],
        names=fields.names,
        places=fields.places,
        time=fields.time,
        extent=np.stack(extent, axis=1),
        readings=fields.readings,
        believed=believed.transpose(1, 0, 2),
        contrast=contrasts[:, 1:].transpose(1, 0, 2),
        known=contrasts[:, 0],
        level=level.transpose(1, 0, 2),
        price=family.price.max(axis=0),
        across=family.across,
    )


def _by_thermometers(places: Real, readings: Real) -> dict[str, Believed]:
    one, every = Believed(float(readings[0])), plane(places, readings)
    return {ONE: one, ONE_ROBUST: one, SEVERAL: every, SEVERAL_ROBUST: every, TILTED: every}


def _judged(
    design: FieldDesign, family: TiltFamily, field: Real, beliefs: dict[str, Believed]
) -> tuple[Real, Real, Real]:
    """Return the planes of all ways (W, 3), contrast (1 + W, F), the known field first, and levels (W, B)."""
    amplitude = design.amplitude(field)
    chosen, planes = [design.taps(design.aimed(amplitude))], []
    for way, believed in beliefs.items():
        across = believed.across if way in (TILTED, OWN_TILTED) else (0.0, 0.0)
        robust = way in (ONE_ROBUST, SEVERAL_ROBUST)
        chosen.append(family.robust_taps(believed.middle) if robust else family.taps(believed.middle, across))
        planes.append([believed.middle, *across])
    lines = design.panel.filters.frequency[design.band]
    filters = design.bank(np.array(chosen)).response(lines)
    forms = design.model.space.forms([amplitude[:, design.band]], design.panel.target.displacement)
    levels = third_octave_levels(_heard(design, forms, amplitude[:, design.band], filters), lines)
    away = levels[1:] - levels[0]
    loudest = np.abs(away).max(axis=-1).argmax(axis=1)
    contrasts = np.array([contrast(forms, one)[0] for one in filters])
    return np.array(planes), contrasts, away[np.arange(len(away)), loudest]


def _heard(design: FieldDesign, forms: EnergyForms, amplitude: Complex, filters: Complex) -> Complex:
    """Response (S, L, F) of what is aimed at to filters (S, F, N), relative to what is wanted."""
    space, sound = design.model.space, design.sound
    if sound is None:
        asked = space.asked(design.panel.target.displacement)
        return np.array([mean_response(forms, one, asked) for one in filters])
    played = np.flatnonzero(sound.loud)
    return np.array([sound.relative(space, amplitude, one, design.band)[played] for one in filters])


def _noisy(charge: Complex, rng: np.random.Generator) -> Complex:
    scale = RESPONSE_NOISE * np.sqrt(0.5 * np.mean(np.abs(charge) ** 2))
    drawn: Complex = charge + scale * (rng.standard_normal(len(charge)) + 1j * rng.standard_normal(len(charge)))
    return drawn
