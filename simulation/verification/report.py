"""Comparison of a solver's frequencies with the known ones: errors and order of convergence.

It is written as Markdown: one table over all cases, and one for every case.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
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


def summary(comparisons: Sequence[CaseComparison]) -> str:
    """Table with a row for every case: its largest error, what is allowed, and the order of convergence."""
    lines = [
        "| case | compared with | modes | largest error | allowed | order | |",
        "|---|---|---|---|---|---|---|",
    ]
    for done in comparisons:
        case = done.case
        verdict = "met" if done.passed else "**missed**"
        lines.append(
            f"| [{case.title}](#{anchor(case.title)}) | {case.kind} | {case.reference.size} "
            f"| {percent(done.worst)} | {percent(case.tolerance)} | {exponent(done.order)} | {verdict} |"
        )
    return "\n".join(lines) + "\n"


def section(comparison: CaseComparison, pictures: Mapping[str, str] | None = None) -> str:
    """One case: what it is compared with, its table of modes, its pictures.

    Parameters
    ----------
    pictures : mapping from caption to path
    """
    case = comparison.case
    lines = [f"### {case.title}", ""]
    lines += [f"Reference: {case.source}.", ""]
    for caption, path in (pictures or {}).items():
        lines += [f"![{caption}]({path})", ""]
    return "\n".join(lines) + "\n" + modes(comparison)


def modes(comparison: CaseComparison) -> str:
    """Table with a row for every mode of a case, in the unit its reference is known in."""
    case = comparison.case
    unit = "Hz" if case.length is None else "ω a² √(ρh/D)"
    published = [*case.published, *[float("nan")] * (case.reference.size - len(case.published))]
    beside = bool(case.published)
    head = ["mode", f"computed, {unit}", "reference", "error", "order", *(["published"] if beside else [])]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for number, (row, other) in enumerate(zip(comparison.rows, published, strict=True), start=1):
        cells = [
            f"{number}",
            f"{row.computed / case.unit:.6g}",
            f"{row.reference / case.unit:.6g}",
            percent(row.error, signed=True),
            exponent(row.order),
        ]
        if beside:
            cells.append("" if np.isnan(other) else f"{other:g}")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def left_out(cases: Sequence[Case], reasons: Mapping[str, str]) -> str:
    """List of the cases that were not computed, by reason; empty where there are none."""
    lines = []
    for why in dict.fromkeys(reasons.values()):
        titles = [case.title for case in cases if reasons.get(case.name) == why]
        lines += [f"Not computed ({why}):", "", *(f"- {title}" for title in titles), ""]
    return "\n".join(lines)


def anchor(heading: str) -> str:
    """Return what a link to a heading of the same page is called."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def percent(share: float, *, signed: bool = False) -> str:
    """Return a relative error in percent with two digits."""
    value = 100.0 * share
    text = np.format_float_positional(abs(value), precision=2, fractional=False, unique=False, trim="-")
    if abs(value) < 1e-7:
        return "0 %"
    return f"{'-' if value < 0 else '+' if signed else ''}{text} %"


def exponent(order: float) -> str:
    """Return an order of convergence with one decimal; a dash where there is none."""
    return "–" if np.isnan(order) else f"{order:.1f}"
