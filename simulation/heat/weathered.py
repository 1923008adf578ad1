"""Temperatures of a declared plate in a declared weather."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.declaration.plate import Plate
from analysis.progress import Progress
from analysis.weather.declared_weather import FaceAir, Weather
from simulation.heat.heat_model import Face, HeatModel, march, settled
from simulation.meshing.plate_mesh import PlateMesh
from simulation.shell.space import ShapeSpace

DEGREE = 2
"""Of temperatures in the plane, on cells of the twin's mesh. On the section-2 panel half lit by the sun a third
degree changes the thermometers by 9 mK, and no place by more than 0.31 K, at the edge of the shadow."""


@dataclass(frozen=True)
class PlateTemperatures:
    """Temperatures of a plate over time, °C.

    Attributes
    ----------
    time : (t,) ndarray, s
    points : (Q, 2) ndarray, m
    bending : (t, Q) ndarray
        At the points, as bending weighs them over the thickness (`HeatModel.seen`).
    readings : (t, K) ndarray
        Of the thermometers.
    between_faces : float
        Largest difference between the faces, K.
    """

    time: Real
    points: Real
    bending: Real
    readings: Real
    between_faces: float


def plate_temperatures(
    plate: Plate,
    mesh: PlateMesh,
    thickness: Real,
    weather: Weather,
    points: Real,
    report: Progress = lambda _stage, _share: None,
    degree: int = DEGREE,
) -> PlateTemperatures:
    """Solve the heat equation of a plate.

    Parameters
    ----------
    mesh : PlateMesh
        Of the plate.
    thickness : (cells,) ndarray, m
    points : (Q, 2) ndarray, m
        Where temperatures are wanted.
    report : callable, optional
        Called with the stage and the share done.
    degree : int
        Of the temperatures in the plane.

    Raises
    ------
    ValueError
        For a thermometer off the plate, or a plate without an initial state.
    """
    space = ShapeSpace.on(mesh, degree)
    on_plate = plate.contains(np.array([one.point for one in weather.thermometer]))
    for one, inside in zip(weather.thermometer, on_plate, strict=True):
        if not inside:
            raise ValueError(
                f"thermometer {one.name!r} at {list(one.point)} m is off the plate, which spans "
                f"{[list(corner) for corner in plate.bounds]} m; move it onto the plate"
            )
    border = np.zeros(len(mesh.edges), dtype=bool)
    for name, edges in mesh.borders.items():
        border[edges.edge] |= name == "outline" or name.startswith("hole")
    model = HeatModel.of(
        space,
        thickness,
        density=plate.density,
        specific_heat=weather.heat.specific_heat,
        conductivity=weather.heat.conductivity,
        front=weather.front.convection,
        back=weather.back.convection,
        edges=[(border, weather.edge.convection)] if weather.edge else (),
    )
    load = _load(model, plate, weather, border)
    start = settled(model, load(0.0)) if weather.initial is None else model.uniform(weather.initial)
    here, places = space.values(points), space.values(np.array([one.point for one in weather.thermometer]))
    time, found = weather.times, [start]
    for number, after in enumerate(march(model, load, start, float(time[1]), len(time) - 1), start=2):
        found.append(after)
        if number % 50 == 0 or number == len(time):
            report("Heat", number / len(time))
    every = np.array(found)
    read = [model.seen(every, one.face) @ places[k].toarray()[0] for k, one in enumerate(weather.thermometer)]
    faces = (model.seen(every, "front") - model.seen(every, "back")) @ here.T
    return PlateTemperatures(
        time,
        points,
        np.asarray(model.seen(every, "bending") @ here.T),
        np.array(read).T,
        float(np.abs(faces).max()),
    )


def _load(model: HeatModel, plate: Plate, weather: Weather, border: Real) -> Callable[[float], Real]:
    """Heat that flows in, (L N,), W, at a time, s."""
    xi, zeta = plate.normalised(model.space.points)
    shapes = (np.ones_like(xi), 0.5 * xi, 0.5 * zeta)

    def of_face(face: Face, around: FaceAir) -> Callable[[float], Real]:
        air = np.array([model.on_face(face, around.convection * shape) for shape in shapes])
        sun = model.on_face(face, around.lit_at(model.space.points))
        return lambda time: around.air_at(time) @ air + around.sun_at(time) * sun

    front, back, edge = of_face("front", weather.front), of_face("back", weather.back), weather.edge
    if edge is None:
        return lambda time: front(time) + back(time)
    along = model.on_edges(np.asarray(border, dtype=bool), edge.convection)
    return lambda time: front(time) + back(time) + edge.air_at(time)[0] * along
