"""Comparison of a solver's frequencies with the known ones: errors and order of convergence."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from simulation.verification.case import Case

Frequencies = Callable[[Case, int], Real]
"""Natural frequencies of bending of a case at one refinement, Hz, ascending, rigid motions included.

In-plane modes are left out. From one refinement to the next the mesh size halves. It raises `NotCovered` if the
solver cannot compute the case.
"""

RIGID_FREQUENCY_SHARE = 1e-3
"""Largest frequency of a rigid motion, as a share of the lowest known one."""
ROUNDING_CHANGE = 1e-9
"""Relative change below which the order cannot be determined because of rounding."""


class NotCovered(ValueError):  # noqa: N818
    """A case that the solver cannot compute, with the reason."""


@dataclass(frozen=True)
class ModeRow:
    """One mode.

    Attributes
    ----------
    computed, reference : float
        On the finest mesh, and known, Hz.
    error : float
        Relative, signed.
    order : float
        Order of convergence of the frequency in the mesh size; NaN if rounding hides it.
    """

    computed: float
    reference: float
    error: float
    order: float


@dataclass(frozen=True)
class CaseComparison:
    """One case, computed on meshes with successively halved size.

    Attributes
    ----------
    case : Case
    frequency : (R, K) ndarray
        Of every refinement, rigid motions left out, Hz.
    """

    case: Case
    frequency: Real

    @property
    def error(self) -> Real:
        """Relative errors of the finest mesh, signed, (K,)."""
        return np.asarray(self.frequency[-1] / self.case.reference - 1.0)

    @property
    def worst(self) -> float:
        """Largest relative error of the finest mesh."""
        return float(np.abs(self.error).max())

    @property
    def passed(self) -> bool:
        """Whether it stays within the case's tolerance."""
        return self.worst <= self.case.tolerance

    @property
    def order(self) -> float:
        """Order of convergence of all modes together; NaN where rounding hides it."""
        return float(convergence_order((self.frequency / self.case.reference)[:, None])[0])

    @property
    def rows(self) -> tuple[ModeRow, ...]:
        """Every mode."""
        orders = convergence_order((self.frequency / self.case.reference)[:, :, None])
        values = zip(self.frequency[-1], self.case.reference, self.error, orders, strict=True)
        return tuple(ModeRow(float(f), float(known), float(error), float(p)) for f, known, error, p in values)


def convergence_order(values: Real) -> Real:
    """Order p of values that change as h**p, from their last three meshes, h halving.

    It is log2 of the ratio of successive changes, which fall like the error, so no reference is needed.

    Parameters
    ----------
    values : (R, G, K) ndarray
        R at least 3; values of order one. The K values of a group are added.

    Returns
    -------
    (G,) ndarray
        NaN where there are fewer than three meshes or the changes are rounding.
    """
    if values.shape[0] < 3:
        return np.full(values.shape[1], np.nan)
    change = np.abs(np.diff(values[-3:], axis=0)).sum(axis=-1)
    resolved = (change > ROUNDING_CHANGE).all(axis=0)
    before, after = np.where(resolved, change, 1.0)
    return np.asarray(np.where(resolved, np.log2(before / after), np.nan))


def compare(case: Case, frequencies: Frequencies, refinements: Sequence[int] = (0, 1, 2)) -> CaseComparison:
    """Compute a case on several meshes.

    Parameters
    ----------
    frequencies : callable
        From a case and a refinement to natural frequencies of bending, Hz, ascending, rigid motions included.
    refinements : sequence of int
        Of the mesh, coarsest first.

    Raises
    ------
    ValueError
        Where frequencies are missing or a rigid motion is stiff.
    NotCovered
        Where the solver does not cover the case.
    """
    wanted, rigid = case.reference.size, case.rigid_motions
    found = []
    for refinement in refinements:
        values = np.asarray(frequencies(case, refinement), float)
        if values.size < rigid + wanted:
            raise ValueError(
                f"{case.name}: {values.size} frequencies; needed are {rigid} rigid and {wanted} others"
            )
        if rigid and values[rigid - 1] > RIGID_FREQUENCY_SHARE * case.reference[0]:
            raise ValueError(
                f"{case.name}: rigid motion {rigid} has {values[rigid - 1]:.4g} Hz; allowed up to "
                f"{RIGID_FREQUENCY_SHARE:g} of the lowest known frequency {case.reference[0]:.4g} Hz"
            )
        found.append(values[rigid : rigid + wanted])
    return CaseComparison(case, np.array(found))


def compare_all(
    cases: Iterable[Case], frequencies: Frequencies, refinements: Sequence[int] = (0, 1, 2)
) -> tuple[list[CaseComparison], dict[str, str]]:
    """Compare every case that the solver covers.

    Parameters
    ----------
    frequencies : callable
        From a case and a refinement to natural frequencies of bending, Hz, ascending, rigid motions included.
    refinements : sequence of int
        Of the mesh, coarsest first.

    Returns
    -------
    done : list of CaseComparison
    left_out : dict of str to str
        Names of the cases the solver does not cover, with the reason.

    Raises
    ------
    ValueError
        Where frequencies are missing or a rigid motion is stiff.
    """
    done: list[CaseComparison] = []
    left_out: dict[str, str] = {}
    for case in cases:
        try:
            done.append(compare(case, frequencies, refinements))
        except NotCovered as why:
            left_out[case.name] = str(why)
    return done, left_out
