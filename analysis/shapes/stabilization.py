"""How many modes there are: the complex mode indicator function, and which poles stay as the order rises."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.estimation.transfer import MeasuredTransfer
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
