"""Grid on which fields of N actuators are evaluated, and their energies as N by N quadratic forms.

The field of filters R is U = Φ A R with Φ real (K, r) and A the twin's amplitudes (r, N). Every quantity except
the peak of U is quadratic, so the K grid points drop out: energies are Rᴴ P R, and the pseudo-inverse of H = Φ A
follows from P = Hᴴ W H and Hᴴ W φ.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Mask, Real
from analysis.experiment import Plate
from analysis.focusing.panel import Panel
from analysis.geometry.loop import Loop

POINTS_ALONG_CELL = 8
"""Points along each side of a cell, to compute the part of it on the plate."""


@dataclass(frozen=True)
class Grid:
    """Midpoints of equal cells over the box around a plate; those off the plate are left out.

    Attributes
    ----------
    points : (K, 2) ndarray
        m.
    area : (K,) ndarray
        Of each cell on the plate, m2; their sum is the plate's area.
    target : (K,) ndarray
        Share of each cell the target covers: the target shape φ(x, y) of paper eq. (1), 1 inside and 0
        outside, so that a target cutting through cells keeps its true area.
    length : (float, float)
        Of the plate: of the box around it, m.
    center : (float, float)
        Of the target, m.
    spots : (S, 2) ndarray, optional
        Centres of the target's parts, m, where it has several.
    """

    points: Real
    area: Real
    target: Real
    length: tuple[float, float]
    center: tuple[float, float]
    spots: Real | None = None

    def __post_init__(self) -> None:
        count = len(self.area)
        if self.points.shape != (count, 2) or self.target.shape != (count,):
            raise ValueError(
                f"points {self.points.shape}, area {self.area.shape} and target {self.target.shape} "
                "must be (K, 2), (K,) and (K,)"
            )
        if not self.target.any():
            raise ValueError("the target covers no cell of the grid")

    @classmethod
    def of(cls, panel: Panel) -> Self:
        """Grid of a panel, x slowest."""
        plate = panel.plate
        lengths = (plate.length_x, plate.length_y)
        middles = [
            plate.bounds[0][axis] + (np.arange(count) + 0.5) / count * lengths[axis]
            for axis, count in enumerate(panel.grid)
        ]
        points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 2)
        loops, cell = panel.target_loops, (lengths[0] / panel.grid[0], lengths[1] / panel.grid[1])
        # Parts do not overlap, so their shares add up; corners may touch.
        target = (
            _rectangle(panel)
            if panel.target.plain
            else np.minimum(sum(_share(loop.contains, (loop,), points, cell) for loop in loops), 1.0)
        )
        area = np.full(len(points), lengths[0] * lengths[1] / len(points))
        if plate.outline is not None or plate.hole:
            points, area, target = _cut(plate, points, area, target, panel.grid)
        spots = np.array([loop.centroid for loop in loops])
        return cls(points, area, target, lengths, panel.target_center, spots)

    @property
    def centers(self) -> Real:
        """Centres (S, 2) of the target's parts, m."""
        return np.array([self.center]) if self.spots is None else self.spots

    @property
    def target_share(self) -> float:
        """Area of the target over area of the plate."""
        return float(self.area @ self.target / self.area.sum())


@dataclass(frozen=True)
class EnergyForms:
    """Energies of N actuators' fields over temperature and frequency.

    Attributes
    ----------
    plate : (T, F, N, N) ndarray
        Hermitian: ∫ |U|² over the plate is Rᴴ plate R, m4/V2.
    target : (T, F, N, N) ndarray
        The same over the target.
    aim : (T, F, N) ndarray
        Hᴴ W φ: inner product of each actuator's field with the target shape, m3/V.
    """

    plate: Complex
    target: Complex
    aim: Complex

    def __post_init__(self) -> None:
        shape = self.aim.shape
        if len(shape) != 3 or self.plate.shape != (*shape, shape[-1]) or self.target.shape != self.plate.shape:
            raise ValueError(
                f"plate {self.plate.shape}, target {self.target.shape} and aim {self.aim.shape} must be "
                "(T, F, N, N), (T, F, N, N) and (T, F, N)"
            )

    @classmethod
    def joined(cls, forms: Sequence["EnergyForms"]) -> Self:
        """Forms of several sets of temperatures, one after the other."""
        parts = zip(*((one.plate, one.target, one.aim) for one in forms), strict=True)
        return cls(*(np.concatenate(part) for part in parts))

    def weighted(self, kappa: float) -> Self:
        """Forms whose `plate` weights the energy outside the target with `kappa`: Hᴴ W H of the design."""
        if kappa not in self._weighted:
            plate = self.target + kappa * (self.plate - self.target)
            self._weighted[kappa] = type(self)(plate, self.target, self.aim)
        return self._weighted[kappa]

    def damped(self, tolerance: float) -> Complex:
        """Return Hᴴ W H + tolerance² s₁² I, (T, F, N, N): `plate` with Tikhonov's regularisation."""
        damping = tolerance**2 * self.largest[..., None, None]
        return np.asarray(self.plate + damping * np.eye(self.plate.shape[-1]), dtype=np.complex128)

    @cached_property
    def largest(self) -> Real:
        """Largest eigenvalue (T, F) of `plate`: the square of the largest singular value of H, m4/V2."""
        return np.asarray(np.linalg.eigvalsh(self.plate)[..., -1])

    @cached_property
    def _weighted(self) -> dict[float, Self]:
        """Cache of weighted forms: the design of filters and that of taps use the same ones."""
        return {}

    def at(self, temperatures: NDArray[np.intp] | slice, lines: NDArray[np.bool_] | slice = slice(None)) -> Self:
        """Forms of some temperatures (by index) and lines."""
        return type(self)(
            self.plate[temperatures][:, lines],
            self.target[temperatures][:, lines],
            self.aim[temperatures][:, lines],
        )


@dataclass(frozen=True)
class FieldSpace:
    """The space of a twin's deflection shapes, with its inner products over the plate and over the target.

    Attributes
    ----------
    deflection : (K, r) ndarray
        Deflection of every generalised coordinate at the grid's points.
    grid : Grid
    plate : (p, r) ndarray
        Square root of Φᵀ W Φ: |plate a|² is the energy of the field Φ a over the plate, m2.
    target : (q, r) ndarray
        The same over the target.
    aim : (r,) ndarray
        Φᵀ W φ for a target displacement of 1 m, m2.
    """

    deflection: Real
    grid: Grid
    plate: Real
    target: Real
    aim: Real

    @classmethod
    def of(cls, deflection: Real, grid: Grid) -> Self:
        """Compute the inner products of `deflection` (K, r) over a grid of K points."""
        if deflection.ndim != 2 or len(deflection) != len(grid.area):
            raise ValueError(f"deflection {deflection.shape} does not belong to a grid of {len(grid.area)} points")
        root = np.sqrt(grid.area)[:, None] * deflection
        inside = grid.target > 0.0
        covered = np.sqrt(grid.target[inside])[:, None] * root[inside]
        return cls(
            deflection,
            grid,
            np.asarray(np.linalg.qr(root, mode="r")),
            np.asarray(np.linalg.qr(covered, mode="r")),
            deflection.T @ (grid.area * grid.target),
        )

    def restricted(self, basis: Real) -> Self:
        """Return the space in the coordinates of `basis` (r, s), with deflection @ basis."""
        plate, target = (np.asarray(np.linalg.qr(part @ basis, mode="r")) for part in (self.plate, self.target))
        return type(self)(self.deflection @ basis, self.grid, plate, target, basis.T @ self.aim)

    def asked(self, displacement: float) -> float:
        """φᵀ W φ of a target `displacement`, m4: the value of `aim` for a field equal to the target shape."""
        return displacement**2 * float(self.grid.area @ self.grid.target**2)

    def forms(self, amplitudes: Iterable[Complex], displacement: float = 1.0) -> EnergyForms:
        """Energy forms of `amplitudes`, one (N, F, r) array per temperature; an iterator saves memory.

        `displacement` is the desired one of the target, m per unit of audio signal.
        """
        plate, target, aim = [], [], []
        for amplitude in amplitudes:
            plate.append(_gram(self.plate, amplitude))
            target.append(_gram(self.target, amplitude))
            aim.append(displacement * (amplitude.conj() @ self.aim).T)
        return EnergyForms(np.array(plate), np.array(target), np.array(aim))

    def at_point(self, amplitude: Complex, point: tuple[float, float]) -> Complex:
        """Deflection (N, F) of every actuator at the grid point nearest to `point`, m/V."""
        nearest = np.argmin(np.sum((self.grid.points - np.asarray(point)) ** 2, axis=1))
        deflection: Complex = amplitude @ self.deflection[nearest]
        return deflection


def _gram(root: Real, amplitude: Complex) -> Complex:
    """Gram matrices (F, N, N) of root · a for `amplitude` a (N, F, r)."""
    count, lines, _ = amplitude.shape
    flat = amplitude.reshape(count * lines, -1)
    image = (flat.real @ root.T + 1j * (flat.imag @ root.T)).reshape(count, lines, -1).transpose(1, 2, 0)
    gram: Complex = image.conj().transpose(0, 2, 1) @ image
    return gram


def _rectangle(panel: Panel) -> Real:
    """Share (K,) of the cells that one rectangle along the plate's sides covers, exactly."""
    cover = []
    (low_corner, high_corner), plate = panel.target_loops[0].bounds, panel.plate
    lengths = (plate.length_x, plate.length_y)
    for axis, count in enumerate(panel.grid):
        edges = np.linspace(0.0, 1.0, count + 1)
        low, high = (
            (corner[axis] - plate.bounds[0][axis]) / lengths[axis] for corner in (low_corner, high_corner)
        )
        overlap = np.minimum(edges[1:], high) - np.maximum(edges[:-1], low)
        cover.append(np.clip(np.round(overlap * count, 9), 0.0, 1.0))
    return np.asarray(np.outer(*cover).ravel())


def _cut(plate: Plate, points: Real, area: Real, target: Real, count: tuple[int, int]) -> tuple[Real, Real, Real]:
    """Leave out points off the plate; the parts of their cells on it are added to the nearest cell kept."""
    from scipy.spatial import cKDTree

    borders = (plate.loop, *plate.hole_loops)
    share = _share(plate.contains, borders, points, (plate.length_x / count[0], plate.length_y / count[1]))
    kept = plate.contains(points)
    if not kept.any():
        raise ValueError(f"no point of a grid of {count[0]} by {count[1]} lies on the plate; take a finer one")
    covered = target * area  # the target lies on the plate
    slivers = np.flatnonzero(~kept & (share > 0.0))
    nearest = cKDTree(points[kept]).query(points[slivers])[1]
    found, aimed = (share * area)[kept], covered[kept]
    np.add.at(found, nearest, (share * area)[slivers])
    np.add.at(aimed, nearest, covered[slivers])
    edge = np.abs(found / area[kept] - 1.0) > 1e-9
    found[edge] *= 1.0 + (plate.area - found.sum()) / found[edge].sum()
    return points[kept], found, np.minimum(aimed / found, 1.0)


def _share(
    contains: Callable[[Real], Mask], borders: Sequence[Loop], points: Real, cell: tuple[float, float]
) -> Real:
    """Share (K,) of the cells about `points` (K, 2) that lies within a region of these `borders`."""
    inside = contains(points)
    away = np.min([loop.distance(points) for loop in borders], axis=0)
    cut = np.flatnonzero(away <= 0.51 * np.hypot(*cell))
    steps = (np.arange(POINTS_ALONG_CELL) + 0.5) / POINTS_ALONG_CELL - 0.5
    fine = np.stack(np.meshgrid(steps * cell[0], steps * cell[1]), axis=-1).reshape(-1, 2)
    share = inside.astype(float)
    samples = (points[cut, None] + fine).reshape(-1, 2)
    share[cut] = contains(samples).reshape(len(cut), -1).mean(axis=1)
    return share
