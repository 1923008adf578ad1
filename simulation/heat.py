"""Heat conduction in a plate, with its own profile through the thickness, and temperatures in a weather.

rho c dT/dt = k (T_xx + T_yy + T_zz),    outward heat flow k dT/dn = a (T_air - T) + q on faces and edges,

a the coefficient of heat transfer and q the heat absorbed (Carslaw and Jaeger, Conduction of Heat in Solids, 1959,
1.6 to 1.9). Galerkin's method with products of the twin's functions in the plane and Legendre polynomials through
the thickness, T = sum_k P_k(2z/h) T_k(x, y): three of them follow the parabola of a plate warmed evenly exactly.

Over time it is solved step by step. Two implicit stages with the same matrix (Alexander, SIAM J. Numer. Anal. 14,
1977, 1006-1021): of second order, and what is much faster than a step, as the first moments of sun on a face, dies
out instead of ringing on.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, kron
from scipy.sparse.linalg import SuperLU, splu

from analysis.arrays import Mask, Real
from analysis.declaration.plate import Plate
from analysis.progress import Progress
from analysis.weather.declared_weather import FaceAir, Weather
from simulation.meshing.plate_mesh import PlateMesh
from simulation.shell.edges import line_blocks
from simulation.shell.rigidity import W
from simulation.shell.space import ShapeSpace

Face = Literal["front", "back"]
Place = Literal["front", "back", "middle", "bending"]
LAYER_POLYNOMIALS = 5
"""Polynomials through the thickness. With them a slab of Biot number 2 (a panel in air has 0.1) is within 0.4 % of
its first difference a tenth of L²/a after it begins to cool on both faces; with three or four, within 4 %."""


@dataclass(frozen=True)
class HeatModel:
    """Matrices of C dT/dt + G T = b; unknowns are those of T_0 in the plane, then of T_1, ...

    Attributes
    ----------
    space : ShapeSpace
        Of N functions.
    layers : int
        Polynomials L through the thickness.
    capacity : (L N, L N) csr_matrix
        J/K.
    conductance : (L N, L N) csr_matrix
        Of conduction, and of the heat transfer at faces and edges, W/K.
    thickness : (cells,) ndarray, m
    """

    space: ShapeSpace
    layers: int
    capacity: csr_matrix
    conductance: csr_matrix
    thickness: Real

    @classmethod
    def of(
        cls,
        space: ShapeSpace,
        thickness: Real,
        *,
        density: float,
        specific_heat: float,
        conductivity: float,
        front: float | Real = 0.0,
        back: float | Real = 0.0,
        edges: Sequence[tuple[Mask, float]] = (),
        layers: int = LAYER_POLYNOMIALS,
    ) -> Self:
        """Assemble a plate.

        Parameters
        ----------
        thickness : (cells,) ndarray, m
        density : float
            kg/m3.
        specific_heat : float
            J/(kg K).
        conductivity : float
            W/(m K).
        front, back : float or (Q,) ndarray
            Coefficients of heat transfer of the faces, W/(m2 K), at the space's points of quadrature.
        edges : sequence of ((E,) ndarray of bool, float)
            Mesh edges, and their coefficient of heat transfer, W/(m2 K); no heat flows through the others.
        """
        half = 0.5 * space.spread(thickness)
        own, across = legendre(layers)
        inside, through = space.product("0", "0", weight=half), space.product("0", "0", weight=1.0 / half)
        slopes = space.product("x", "x", weight=half) + space.product("y", "y", weight=half)
        capacity = density * specific_heat * kron(np.diag(own), inside)
        conductance = conductivity * (kron(np.diag(own), slopes) + kron(across, through))
        for face, transfer in ((ends("front", layers), front), (ends("back", layers), back)):
            spread = space.product("0", "0", weight=np.broadcast_to(transfer, half.shape))
            conductance = conductance + kron(np.outer(face, face), spread)
        for chosen, transfer in edges:
            conductance = conductance + kron(np.diag(own), _along(space, chosen, thickness, transfer))
        return cls(space, layers, csr_matrix(capacity), csr_matrix(conductance), thickness)

    def on_face(self, place: Face, flow: float | Real) -> Real:
        """Load (L N,), W, of heat that flows into a face, W/m2, all over or (Q,) at the points of quadrature."""
        weight = np.broadcast_to(np.asarray(flow, dtype=float), self.space.dx.shape)
        return np.asarray(np.kron(ends(place, self.layers), self.space.moments("0", weight)))

    def on_edges(self, chosen: Mask, flow: float) -> Real:
        """Load (L N,), W, of heat that flows into chosen mesh edges (E,), W/m2."""
        own, _ = legendre(self.layers)
        line = _along(self.space, chosen, self.thickness, flow) @ self._one
        return np.asarray(np.kron(own * np.eye(self.layers)[0], line))

    def uniform(self, temperature: float) -> Real:
        """Coefficients (L N,) of one temperature everywhere, °C."""
        return np.asarray(np.kron(np.eye(self.layers)[0], temperature * self._one))

    def seen(self, coefficients: Real, place: Place) -> Real:
        """Return coefficients (..., N) of the temperature of a face or in the middle, or as bending weighs it.

        Bending stiffness is the integral of E z**2: its change with temperature follows, to first order, the mean
        of T over the thickness weighted with z**2. What is left out is the square of the change of E across the
        thickness: 3e-4 of the stiffness where a face is 3 K warmer than the other.

        Parameters
        ----------
        coefficients : (..., L N) ndarray
            K.
        """
        parts = coefficients.reshape(*coefficients.shape[:-1], self.layers, -1)
        found: Real = np.einsum("k,...kn->...n", ends(place, self.layers), parts)
        return found

    @property
    def _one(self) -> Real:
        """Coefficients (N,) of the function that is one."""
        one = np.zeros(self.space.size)
        one[: len(self.space.mesh.points)] = 1.0
        return one


def ends(place: Place, layers: int) -> Real:
    """Return what each polynomial (L,) contributes at z = h/2, -h/2 or 0, or to the mean weighted with z**2."""
    k = np.arange(layers)
    if place == "front":
        return np.ones(layers)
    if place == "back":
        return np.where(k % 2, -1.0, 1.0)
    if place == "middle":
        return np.array([np.polynomial.legendre.legval(0.0, row) for row in np.eye(layers)])
    return np.array([1.0, 0.0, 0.4, *np.zeros(layers)])[:layers]


def legendre(layers: int) -> tuple[Real, Real]:
    """Integrals over -1 to 1 of P_i P_i, (L,), and of P_i' P_j', (L, L)."""
    i, j = np.indices((layers, layers))
    lower = np.minimum(i, j)
    slopes = np.where((i + j) % 2, 0.0, lower * (lower + 1.0))
    return np.asarray(2.0 / (2.0 * np.arange(layers) + 1.0)), np.asarray(slopes)


def _along(space: ShapeSpace, chosen: Mask, thickness: Real, transfer: float) -> csr_matrix:
    """Integral along mesh edges of half the thickness times a coefficient, (N, N)."""
    halves = 0.5 * _at_edges(space, thickness)
    found = csr_matrix((space.size, space.size))
    for half in np.unique(halves[chosen]):
        edges = np.flatnonzero(chosen & (halves == half))
        for _, _, functions, block in line_blocks(space, edges, {W: None}, transfer * half):
            edge, i, j = np.nonzero(np.ones(block.shape, dtype=bool))
            places = (functions[edge, i], functions[edge, j])
            found = found + csr_matrix(coo_matrix((block[edge, i, j], places), shape=found.shape))
    return csr_matrix(found)


def _at_edges(space: ShapeSpace, thickness: Real) -> Real:
    """Thickness (E,) of a cell at each mesh edge."""
    mesh = space.mesh
    found = np.zeros(len(mesh.edges))
    quads = len(mesh.quads)
    found[mesh.quad_edges] = thickness[:quads, None]
    found[mesh.triangle_edges] = thickness[quads:, None]
    return found


SHARE = 1.0 - np.sqrt(0.5)
"""Of a step, at which the first stage stands."""
ROUNDING = 1e-12
"""Share of all conductances up to which what is left of them, when every place is as warm, is rounding."""


def march(model: HeatModel, load: Callable[[float], Real], start: Real, step: float, count: int) -> Iterator[Real]:
    """Yield coefficients (L N,) after every step.

    Parameters
    ----------
    load : callable
        Heat that flows in, (L N,), W, at a time, s.
    start : (L N,) ndarray
        Coefficients at the time 0.
    step : float
        s.
    count : int
        Number of steps.
    """
    solver = _factors(model.capacity + SHARE * step * model.conductance)
    here = start
    for number in range(count):
        now = number * step
        first = solver.solve(load(now + SHARE * step) - model.conductance @ here)
        between = here + (1.0 - SHARE) * step * first
        second = solver.solve(load(now + step) - model.conductance @ between)
        here = between + SHARE * step * second
        yield here


def settled(model: HeatModel, load: Real) -> Real:
    """Return coefficients (L N,) of the state of rest under a load (L N,), W.

    Raises
    ------
    ValueError
        Where no face and no edge gives heat to anything: then there is none.
    """
    uniform = model.uniform(1.0)
    conducted = float(np.abs(model.conductance.data).sum())
    if not float(uniform @ (model.conductance @ uniform)) > ROUNDING * conducted:
        raise ValueError("no face and no edge exchanges heat: the plate never comes to rest")
    return np.asarray(_factors(model.conductance).solve(load))


def _factors(matrix: csr_matrix) -> SuperLU:
    """Factors of a symmetric matrix; by the order for those that are not, they take eight times as long."""
    return splu(
        csc_matrix(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


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
