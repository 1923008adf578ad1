"""Plates of a trial: polymer plates of random geometry, outline, drive and sensors, and as they are built.

Every effect of the library is possible on plates driven by patches; without a sensor patch some are not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from analysis.declaration.tolerances import Tolerances
from analysis.declaration.transducers import Drive, Sensor
from analysis.experiment import Attachment, Patch, Plate, Point
from app.files.declarations.experiment import AcquiredExperiment
from app.files.declarations.simulation_section import Laws
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.fineness import Fineness

PATCH_EDGE = 0.02
"""Edge of every patch, m."""
LEAST_PATCH_DISTANCE = 0.012
"""Distance between two patches along either axis, and from the edge, m: leaves space to move the first sensor."""
MODES_IN_BAND = (11.0, 15.0)
"""Number of modes in the band, by Weyl's law, at room temperature: enough to distinguish effects."""
LOWEST_FREQUENCY = 100.0
"""Lower end of bands, Hz."""
Driven = Literal["patch", "exciter", "two patches"]
DRIVEN: tuple[Driven, ...] = get_args(Driven)
"""How plates are driven, in turn: by a patch, by an exciter, by one patch and then another."""
OUTWARD = 0.02
"""Largest distance of a quadrilateral plate's corners outside a rectangle's, along either axis, m."""
ACCELEROMETER_MASS = 6e-4
"""kg."""
OTHER_MESH = Fineness(MeshRecipe(spacing=0.055, strip=1.07, edge_strip=1.27, growth=0.9), degree=9, tolerance=2e-9)
"""Mesh of the simulated measurement: other cells and another degree than the twin's."""


@dataclass(frozen=True)
class PlateKind:
    """Plate and instruments common to its campaigns.

    Attributes
    ----------
    plate : Plate
    patches : tuple of Patch
    strings, cables : tuple of Attachment
    band : tuple of float
        Hz.
    drives : tuple of Drive
        Forces; none where patches drive.
    sensors : tuple of Sensor
        Of motion; none where patches alone are read.
    """

    plate: Plate
    patches: tuple[Patch, ...]
    strings: tuple[Attachment, ...]
    cables: tuple[Attachment, ...]
    band: tuple[float, float]
    drives: tuple[Drive, ...] = ()
    sensors: tuple[Sensor, ...] = ()

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs that drive it, in turn."""
        patches = (patch.id for patch in self.patches if patch.role == "actuator")
        return (*patches, *(drive.id for drive in self.drives))

    def record(self) -> dict[str, Any]:
        """Return it for a file."""
        return {
            "plate": self.plate.model_dump(),
            "patch": [patch.model_dump() for patch in self.patches],
            "string": [attached.point for attached in self.strings],
            "cable": [attached.point for attached in self.cables],
            "band": self.band,
            "drive": [drive.model_dump() for drive in self.drives],
            "sensor": [sensor.model_dump() for sensor in self.sensors],
        }


def plate_kind(number: int, rng: np.random.Generator) -> PlateKind:
    """Draw the plate of a number: kinds of drive alternate, and so do rectangles and quadrilaterals."""
    return draw_plate(rng, DRIVEN[number % len(DRIVEN)], rectangular=number % 2 == 0)


def draw_plate(rng: np.random.Generator, driven: Driven = "patch", *, rectangular: bool = True) -> PlateKind:
    """Draw a plate of 2.5 to 3.5 mm with one to three sensors, two strings and a cable.

    Parameters
    ----------
    rng : numpy.random.Generator
    driven : str
        One of `DRIVEN`. A plate on an exciter is read by an accelerometer, a laser and, in half of the cases, a
        patch; others by one or two patches.
    rectangular : bool
        If False, a quadrilateral: a rectangle with its corners moved outwards.

    Returns
    -------
    PlateKind
    """
    a, b = (round(float(rng.uniform(*limits)), 3) for limits in ((0.21, 0.27), (0.17, 0.21)))
    thickness = round(float(rng.uniform(0.0025, 0.0035)), 4)
    density = float(rng.uniform(900.0, 1300.0))
    plate = Plate(length_x=a, length_y=b, thickness=thickness, mass=round(density * a * b * thickness, 5))
    left, right = float(rng.uniform(0.030, 0.050)), a - float(rng.uniform(0.030, 0.050))
    spare = b - 2.0 * LEAST_PATCH_DISTANCE - 3.0 * PATCH_EDGE - 2.0 * LEAST_PATCH_DISTANCE
    shares = spare * np.sort(rng.uniform(0.0, 1.0, 3))
    rows = [
        LEAST_PATCH_DISTANCE + 0.5 * PATCH_EDGE + k * (PATCH_EDGE + LEAST_PATCH_DISTANCE) + float(share)
        for k, share in enumerate(shares)
    ]
    further = bool(rng.random() < 0.5)
    along = float(rng.uniform(0.018, 0.026))
    modes = float(rng.uniform(*MODES_IN_BAND))
    patches = [_patch("S1", "sensor", left, rows[0])]
    drives: tuple[Drive, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    if driven == "exciter":
        drives = (Drive(id="exciter", point=_millimetres(right, rows[2])),)
        sensors = (
            Sensor(id="acc", kind="acceleration", point=_millimetres(right, rows[1]), mass=ACCELEROMETER_MASS),
            Sensor(id="laser", kind="velocity", point=_millimetres(left, rows[2])),
        )
        patches = patches if further else []
    else:
        patches = [_patch("A1", "actuator", right, rows[2]), *patches]
        patches += [_patch("S2", "sensor", right, rows[1])] if further else []
        patches += [_patch("A2", "actuator", left, rows[2])] if driven == "two patches" else []
    if not rectangular:
        plate = _quadrilateral(plate, rng)
    return PlateKind(
        plate=plate,
        patches=tuple(patches),
        strings=tuple(Attachment(point=_millimetres(x * a, b - 0.004)) for x in (0.12, 0.86)),
        cables=(Attachment(point=_millimetres(left + along, rows[0] + 0.3 * along)),),
        band=(LOWEST_FREQUENCY, _band_end(plate, modes)),
        drives=drives,
        sensors=sensors,
    )


def _patch(name: str, role: str, x: float, y: float) -> Patch:
    return Patch.model_validate(
        {"id": name, "role": role, "center": _millimetres(x, y), "size": (PATCH_EDGE,) * 2, "thickness": 5e-4}
    )


def _quadrilateral(plate: Plate, rng: np.random.Generator) -> Plate:
    """Return a plate of the same thickness and density whose corners lie outside the rectangle's."""
    away = rng.uniform(0.0, OUTWARD, (4, 2))
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = 0.5 * (1 + signs) * [plate.length_x, plate.length_y] + signs * away
    table = {
        "outline": {"kind": "polygon", "points": [_millimetres(*corner) for corner in corners]},
        "thickness": plate.thickness,
    }
    area = Plate.model_validate({**table, "mass": plate.mass}).area
    return Plate.model_validate({**table, "mass": round(plate.density * area * plate.thickness, 5)})


def _band_end(plate: Plate, modes: float, youngs_modulus: float = 1.9e9) -> float:
    """Frequency, Hz, to which a free plate has so many modes by Weyl's law, N = S f sqrt(3) / (h c), to 10 Hz."""
    speed = np.sqrt(youngs_modulus / (plate.density * (1.0 - 0.38**2)))
    end = modes * plate.thickness * speed / (np.sqrt(3.0) * plate.area)
    return float(np.round(end, -1))


def _millimetres(x: float, y: float) -> Point:
    return round(float(x), 3), round(float(y), 3)


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
        patches=tuple(_built_patch(patch, rng) for patch in kind.patches),
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


def _built_patch(patch: Patch, rng: np.random.Generator) -> Patch:
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
