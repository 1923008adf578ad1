"""Contrast and level that filters lose while a panel's temperatures move, by what is known of them."""

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.performance import contrast, mean_response
from analysis.progress import Progress
from analysis.radiation.measures import third_octave_levels
from analysis.weather.family import FieldDesign, TiltFamily
from analysis.weather.judged import (
    ONE,
    ONE_ROBUST,
    OWN,
    OWN_TILTED,
    SEVERAL,
    SEVERAL_ROBUST,
    TILTED,
    WAYS,
    WeatherFields,
    WeatherJudgement,
)
from analysis.weather.knowledge import Believed, OwnThermometer, plane

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
