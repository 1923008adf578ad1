"""Energies of the fields of N actuators as N by N quadratic forms, for STIF and contrast.

The field of filters R is U = Φ A R with Φ real (K, r) and A the twin's amplitudes (r, N). Every quantity except
the peak of U is quadratic, so the K grid points drop out: energies are Rᴴ P R, and the pseudo-inverse of H = Φ A
follows from P = Hᴴ W H and Hᴴ W φ.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.focusing.grid import Grid


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
