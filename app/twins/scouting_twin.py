"""A campaign's twin with what it might have next: sensors at other places, and a known mass."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from analysis.declaration.transducers import Sensor
from analysis.effect_card import Values
from analysis.experiment import Experiment, Point
from simulation.effects.effect import Effect
from simulation.state.attached import deflection_at
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

NAME = "further"
"""Of further sensors, with their numbers."""
KNOWN_MASS: Mapping[str, str] = {"effect": "mass_at_place", "parameter": "mass"}
"""Effect by which a known mass is computed."""
SLOPE_STEP = 1e-4
"""m; over it the deflection's slope is taken."""


def with_sensors(twin: Twin[EffectPlate], points: Sequence[Point]) -> Twin[EffectPlate]:
    """Return a twin that also reads the velocity at some points, without loading the plate there.

    The deflection is interpolated between the places at which something may be attached, so that no plate is
    reduced again: good to a thousandth of its rms, which does for a plan.

    Parameters
    ----------
    twin : Twin
        With an experiment.
    points : sequence of (float, float)
        m.

    Returns
    -------
    Twin
        The further outputs are the last.

    Raises
    ------
    ValueError
        For a point off the plate, and for a twin without an experiment.
    """
    if twin.experiment is None:
        raise ValueError("a twin without an experiment declares no sensors")
    ops = twin.plate.operators
    rows = np.array([deflection_at(ops, x, y) for x, y in points])
    along_x = np.array(
        [deflection_at(ops, x + SLOPE_STEP, y) - deflection_at(ops, x - SLOPE_STEP, y) for x, y in points]
    )
    along_y = np.array(
        [deflection_at(ops, x, y + SLOPE_STEP) - deflection_at(ops, x, y - SLOPE_STEP) for x, y in points]
    )
    slopes = np.array([along_x, along_y, np.zeros_like(rows)]) / (2.0 * SLOPE_STEP)  # points have no area
    size = ops.size
    wider = replace(
        ops,
        footprints=np.vstack([ops.footprints.reshape(-1, size), rows]),
        footprint_slopes=np.concatenate([ops.footprint_slopes.reshape(3, -1, size), slopes], axis=1),
    )
    experiment = with_sensors_declared(twin.experiment, points)
    known: Mapping[str, Effect] = tolerances(experiment, ops.movable, attachable=bool(len(ops.places)))
    found = Twin.of(experiment, EffectPlate(wider), twin.library, known)
    return replace(found, peak_energy=twin.peak_energy)


def with_sensors_declared(experiment: Experiment, points: Sequence[Point]) -> Experiment:
    """Declare velocity sensors at some points besides all that is declared."""
    taken = {one.id for one in experiment.sensor}
    names = [f"{NAME}{k}" for k in range(1, len(points) + len(taken) + 1) if f"{NAME}{k}" not in taken]
    more = [Sensor(id=name, kind="velocity", point=point) for name, point in zip(names, points, strict=False)]
    return experiment.model_copy(update={"sensor": (*experiment.sensor, *more)})


def known_mass(place: Point, mass: float) -> dict[str, Values]:
    """Return the effect that a mass of some kilograms at a place is, m."""
    return {KNOWN_MASS["effect"]: {KNOWN_MASS["parameter"]: mass, "x": place[0], "y": place[1]}}
