"""Plates as a careful workshop builds them: near what is declared, and never told."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from analysis.declaration.patch import Patch
from analysis.declaration.plate import Plate
from analysis.declaration.tolerances import Tolerances
from analysis.declaration.transducers import Drive, Sensor
from analysis.experiment import Attachment, Point
from app.blind_trial.plates import PlateKind
from app.files.declarations.experiment import AcquiredExperiment
from app.files.declarations.simulation_section import Laws

CAREFUL = Tolerances()
"""Of a workshop whose tolerances nobody declares."""

LEAST_AREA = 0.1
"""Of a contact, over the declared one: under less a Mindlin plate gives way without bound."""

Transducer = TypeVar("Transducer", Drive, Sensor)


def as_built(kind: PlateKind, rng: np.random.Generator) -> PlateKind:
    """Return a plate whose dimensions and places are off by the tolerances of a careful workshop.

    What lies on it is measured from the corner at the origin, with an error of its own.

    Parameters
    ----------
    kind : PlateKind
        As declared.
    rng : numpy.random.Generator

    Returns
    -------
    PlateKind
    """
    return replace(
        kind,
        plate=_plate(kind.plate, rng),
        patches=tuple(_patch(patch, rng) for patch in kind.patches),
        strings=tuple(_attachment(one, rng) for one in kind.strings),
        cables=tuple(_attachment(one, rng) for one in kind.cables),
        drives=tuple(_transducer(one, rng) for one in kind.drives),
        sensors=tuple(_transducer(one, rng) for one in kind.sensors),
    )


def as_it_is(experiments: Sequence[AcquiredExperiment], rng: np.random.Generator) -> list[AcquiredExperiment]:
    """Return experiments whose simulated plate has its laws over what the oven's thermometer reads.

    Parameters
    ----------
    experiments : sequence of AcquiredExperiment
        Of one plate, as built.
    rng : numpy.random.Generator

    Returns
    -------
    list of AcquiredExperiment
    """
    found: list[AcquiredExperiment] = []
    laws: Laws | None = None
    for one in experiments:
        if one.simulation is None:
            raise ValueError("an experiment that simulates nothing has no plate")
        laws = laws or as_read(one.simulation.laws, one.oven.room_temperature, rng)
        found.append(one.model_copy(update={"simulation": one.simulation.model_copy(update={"laws": laws})}))
    return found


def as_read(laws: Laws, room: float, rng: np.random.Generator) -> Laws:
    """Return laws over what the oven's thermometer reads, which is off at the room's temperature and in slope.

    Parameters
    ----------
    laws : Laws
        Over the plate's temperature.
    room : float
        Degrees Celsius.
    rng : numpy.random.Generator

    Returns
    -------
    Laws
    """
    offset, slope = rng.normal(0.0, [CAREFUL.oven_offset, CAREFUL.oven_slope])
    reading = room + (np.array(laws.temperature) - room - offset) / (1.0 + slope)
    return laws.model_copy(update={"temperature": tuple(reading.tolist())})


def _plate(plate: Plate, rng: np.random.Generator) -> Plate:
    low, high = np.array(plate.bounds)
    stretch = 1.0 + rng.normal(0.0, CAREFUL.length, 2) / (high - low)
    thickness, mass = 1.0 + rng.normal(0.0, [CAREFUL.thickness, CAREFUL.mass])
    table = plate.model_dump(exclude_none=True) | {
        "thickness": plate.thickness * thickness,
        "mass": plate.mass * mass,
        "length_x": plate.length_x * stretch[0],
        "length_y": plate.length_y * stretch[1],
    }
    if plate.outline is not None:
        del table["length_x"], table["length_y"]
        table["outline"]["points"] = [tuple(stretch * point) for point in table["outline"]["points"]]
    return Plate.model_validate(table)


def _patch(patch: Patch, rng: np.random.Generator) -> Patch:
    table = patch.model_dump(exclude_none=True)
    return Patch.model_validate(
        table
        | {
            "center": _moved(patch.center, CAREFUL.patch_place, rng),
            "size": _moved(patch.size, CAREFUL.patch_size, rng),
            "thickness": patch.thickness * (1.0 + rng.normal(0.0, CAREFUL.patch_thickness)),
        }
    )


def _attachment(one: Attachment, rng: np.random.Generator) -> Attachment:
    return one.model_copy(update={"point": _moved(one.point, CAREFUL.attachment_place, rng)})


def _transducer(one: Transducer, rng: np.random.Generator) -> Transducer:
    if one.point is None:
        return one
    found: dict[str, Any] = {"point": _moved(one.point, CAREFUL.transducer_place, rng)}
    if one.mass:
        found["mass"] = max(one.mass + rng.normal(0.0, CAREFUL.transducer_mass), 0.0)
    area = max(1.0 + rng.normal(0.0, CAREFUL.transducer_contact), LEAST_AREA)
    if radius := one.contact_radius:
        found["radius"] = radius * area**0.5
    return one.model_copy(update=found)


def _moved(place: Point, tolerance: float, rng: np.random.Generator) -> Point:
    x, y = place + rng.normal(0.0, tolerance, 2)
    return float(x), float(y)
