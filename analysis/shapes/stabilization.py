"""How many modes there are: the complex mode indicator function, and which poles stay as the order rises.

What FRFs of one structure must fulfil whatever it is: passive at drive points, reciprocal between two points.

At a drive point the structure takes power from the force at every frequency: the real part of its mobility is not
negative (Ewins, *Modal Testing*, 2000, section 2.8). Between points H_ij = H_ji (Maxwell's theorem). Hits beside
the point, a sensor of the wrong sign or place and cross-talk break one or the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.estimation.transfer import INTEGRATED, MeasuredTransfer, along_axis, direction_sign
from analysis.identification.averaging import averaged
from analysis.identification.measured import MANY, Measured, principal_frfs
from analysis.identification.pole_residue import ResidualTerms
from analysis.identification.vector_fitting import start_poles

STABLE_FREQUENCY = 0.01
STABLE_DAMPING = 0.05
"""Relative changes from one order to the next within which a pole is stable (as is usual)."""


@dataclass(frozen=True)
class StabilizationChart:
    """Poles of every order, one after the other.

    Attributes
    ----------
    order : (P,) int ndarray
        Pole pairs of the model that each comes from.
    frequency : (P,) ndarray
        Hz.
    damping : (P,) ndarray
        Ratio.
    stable : (P,) int ndarray
        0: new, 1: stable in frequency, 2: in damping too.
    """

    order: NDArray[np.int64]
    frequency: NDArray[np.float64]
    damping: NDArray[np.float64]
    stable: NDArray[np.int64]

    def __post_init__(self) -> None:
        check_shapes(self, order="P", frequency="P", damping="P", stable="P")
        check_finite(self, "frequency", "damping")
        check_range(self, 0, 2, "stable")


def stabilization_chart(measured: Measured, terms: ResidualTerms, orders: Sequence[int]) -> StabilizationChart:
    """Run vector fitting at rising orders; each pole is held against those of the order before.

    Parameters
    ----------
    orders : sequence of int
        Rising orders, in pole pairs.
    """
    if len(measured.h) > MANY:
        measured = principal_frfs(measured).measured
    lines = averaged(measured.lines())
    low, high = float(lines.frequency[0]), float(lines.frequency[-1])
    before: tuple[NDArray[np.float64], NDArray[np.float64]] = (np.zeros(0), np.zeros(0))
    rows: list[tuple[int, float, float, int]] = []
    for order in orders:
        poles = start_poles(lines, order, terms)
        f, zeta = np.abs(poles) / (2.0 * np.pi), -poles.real / np.abs(poles)
        inside = (f >= low) & (f <= high)
        for one, damping in zip(f[inside], zeta[inside], strict=True):
            rows.append((order, float(one), float(damping), _stability(float(one), float(damping), *before)))
        before = f[inside], zeta[inside]
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return StabilizationChart(
        order=table[:, 0].astype(np.int64),
        frequency=table[:, 1],
        damping=table[:, 2],
        stable=table[:, 3].astype(np.int64),
    )


def _stability(f: float, zeta: float, others: NDArray[np.float64], dampings: NDArray[np.float64]) -> int:
    if not len(others):
        return 0
    nearest = int(np.argmin(np.abs(others - f)))
    if abs(others[nearest] / f - 1.0) > STABLE_FREQUENCY:
        return 0
    return 2 if abs(dampings[nearest] / zeta - 1.0) <= STABLE_DAMPING else 1


def cmif(transfers: Sequence[MeasuredTransfer]) -> NDArray[np.float64]:
    """Singular values of the FRFs' matrix at every line (Shih et al., IMAC 1988).

    A peak of the first is a mode; one of the second at the same line a second mode, close or repeated.

    Parameters
    ----------
    transfers : sequence of MeasuredTransfer
        That share their lines; what was not measured counts as zero.

    Returns
    -------
    (R, F) ndarray
        From the largest, R the lesser of the numbers of responses and of references.
    """
    responses = list(dict.fromkeys(one.response for one in transfers))
    references = list(dict.fromkeys(one.reference for one in transfers))
    h = np.zeros((len(transfers[0].frequency), len(responses), len(references)), dtype=complex)
    for one in transfers:
        h[:, responses.index(one.response), references.index(one.reference)] = one.h
    values: NDArray[np.float64] = np.linalg.svd(h, compute_uv=False)
    return values.T


MOST_NEGATIVE = 0.05
"""Share of the drive point's power, in squares, that may have the wrong sign: noise leaves some per mille, a point
elsewhere a quarter and more, a sensor the wrong way round all."""
MOST_APART = 0.1
"""Relative difference of two reciprocal FRFs: hits that are 2 % of a wavelength beside their points make 10 %."""


@dataclass(frozen=True)
class FrfCheck:
    """One check.

    Attributes
    ----------
    names : tuple of str
        Of the FRF, or of the two that should be equal.
    value : float
        Share of power with the wrong sign, in squares, or relative rms difference.
    passed : bool
    """

    names: tuple[str, ...]
    value: float
    passed: bool

    @property
    def sentence(self) -> str:
        """What was found, in words."""
        share = 100.0 * self.value
        per_cent = f"{share:.0f} %" if share > 10.0 else f"{share:.2g} %"
        if len(self.names) > 1:
            verdict = "" if self.passed else ": a hit or a sensor is beside its point"
            return f"reciprocity with {self.names[1]}: {per_cent} apart{verdict}"
        if self.passed:
            return f"drive point: takes power at all frequencies (wrong sign: {per_cent})"
        return f"no drive point (wrong sign: {per_cent} of the power); check the sensor's sign and place"


def checks(transfers: Sequence[MeasuredTransfer], frequency: Real) -> list[FrfCheck]:
    """Check every drive point and every pair of reciprocal FRFs.

    Parameters
    ----------
    transfers : sequence of MeasuredTransfer
        Those of another quantity than motion over force are left out.
    frequency : (F,) ndarray
        Hz.
    """
    moving = [one for one in transfers if one.quantity in INTEGRATED and one.reference_quantity == "force"]
    ends = {(along_axis(one.response), along_axis(one.reference)): one for one in moving}
    found = []
    for one in moving:
        there, here = along_axis(one.response), along_axis(one.reference)
        if there == here:
            value = _wrong_power(_mobility(one, frequency))
            found.append(FrfCheck((one.name,), value, value <= MOST_NEGATIVE))
        other = ends.get((here, there))
        if other is not None and there < here:
            a, b = _mobility(one, frequency), _mobility(other, frequency)
            value = float(np.linalg.norm(a - b) / np.sqrt(0.5 * (np.linalg.norm(a) ** 2 + np.linalg.norm(b) ** 2)))
            found.append(FrfCheck((one.name, other.name), value, value <= MOST_APART))
    return found


def _mobility(one: MeasuredTransfer, frequency: Real) -> Complex:
    """Return velocity over force, both along the positive axes."""
    sign = direction_sign(one.response) * direction_sign(one.reference)
    w = 2.0 * np.pi * np.maximum(frequency, np.finfo(float).tiny)
    return np.asarray(sign * one.h * (1j * w) ** (1 - INTEGRATED[one.quantity]))


def _wrong_power(mobility: Complex) -> float:
    """Share of the real part that is negative, in squares: they count where the structure moves, not its noise."""
    size = float((mobility.real**2).sum())
    return float((np.minimum(mobility.real, 0.0) ** 2).sum()) / size if size else 0.0
