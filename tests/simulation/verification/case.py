"""One verification case: a plate with known natural frequencies.

Comparison of a solver's frequencies with the known ones: errors and order of convergence.

It is written as Markdown: one table over all cases, and one for every case.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from analysis.arrays import Real
from analysis.geometry.loop import Loop


class ExactPlate(Protocol):
    """An exact solution: `Disc`, `HardRectangle` or `LevyPlate`."""

    def lowest(self, count: int) -> Real:
        """Lowest `count` frequencies w a**2 sqrt(rho h / D), ascending."""
        ...


@dataclass(frozen=True)
class CaseMaterial:
    """An isotropic material.

    Attributes
    ----------
    youngs_modulus : float
        Pa.
    poisson_ratio : float
    density : float
        kg/m3.
    """

    youngs_modulus: float
    poisson_ratio: float
    density: float


Support = Literal["free", "clamped", "soft", "hard"]
"""``soft``: w = 0; ``hard``: the rotation along the edge too; ``clamped``: w and both rotations."""

CONDITIONS: dict[Support, tuple[str, str, str]] = {
    "free": ("shear force", "bending moment", "twisting moment"),
    "clamped": ("deflection", "rotation across", "rotation along"),
    "soft": ("deflection", "bending moment", "twisting moment"),
    "hard": ("deflection", "bending moment", "rotation along"),
}
"""Quantities that vanish at an edge."""
RIGID_FREQUENCY = 0.02
"""Frequency w a**2 sqrt(rho h / D) below which a motion counts as rigid."""


@dataclass(frozen=True)
class Case:
    """A plate, its supports, and its natural frequencies of bending.

    Attributes
    ----------
    name : str
        Lower case with hyphens; used in file names.
    title : str
    outline : Loop
        m.
    thickness : float
        m.
    material : CaseMaterial
    supports : tuple of Support
        Of every curve of the outline, in its order.
    known : tuple of float or ExactPlate
        Lowest frequencies, ascending, rigid motions left out; in Hz, or as w a**2 sqrt(rho h / D).
    length : float or None
        a, m, where `known` is without unit; None where it is in Hz.
    kind : str
        ``exact`` solution of the Mindlin plate, or ``converged`` values of a finite-element solution.
    tolerance : float
        Largest relative error allowed; not below the accuracy of `known`.
    source : str
    holes : tuple of Loop
        m.
    hole_supports : tuple of tuple of Support
        Of every curve of every hole.
    count : int
        Number of frequencies of an exact solution that are compared.
    published : tuple of float
        Published values, of thin plates or coarse elements, shown with `known` in the same unit.
    """

    name: str
    title: str
    outline: Loop
    thickness: float
    material: CaseMaterial
    supports: tuple[Support, ...]
    known: tuple[float, ...] | ExactPlate
    length: float | None
    kind: Literal["exact", "converged"]
    tolerance: float
    source: str
    holes: tuple[Loop, ...] = ()
    hole_supports: tuple[tuple[Support, ...], ...] = ()
    count: int = 8
    published: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.holes) != len(self.hole_supports):
            raise ValueError(f"{self.name}: {len(self.holes)} holes, supports of {len(self.hole_supports)}")
        for loop, supports in self.loops:
            if len(loop.curves) != len(supports):
                raise ValueError(f"{self.name}: {len(loop.curves)} curves, supports of {len(supports)}")
            for support in supports:
                if support not in CONDITIONS:
                    raise ValueError(f"{self.name}: support is {support!r}; allowed: {', '.join(CONDITIONS)}")
        if not 0.0 < self.tolerance < 0.1:
            raise ValueError(f"{self.name}: tolerance is {self.tolerance:g}; allowed above 0, below 0.1")

    @property
    def loops(self) -> tuple[tuple[Loop, tuple[Support, ...]], ...]:
        """Outline and holes, each with the supports of its curves."""
        return ((self.outline, self.supports), *zip(self.holes, self.hole_supports, strict=True))

    @property
    def area(self) -> float:
        """Area of the plate without its holes, m2."""
        return self.outline.area - sum(hole.area for hole in self.holes)

    @property
    def rigidity(self) -> float:
        """Flexural rigidity D, N m."""
        m = self.material
        return m.youngs_modulus * self.thickness**3 / (12.0 * (1.0 - m.poisson_ratio**2))

    @property
    def unit(self) -> float:
        """Unit of `known`, Hz."""
        if self.length is None:
            return 1.0
        mass = self.material.density * self.thickness
        return float(np.sqrt(self.rigidity / mass)) / (2.0 * np.pi * self.length**2)

    @cached_property
    def reference(self) -> Real:
        """Lowest frequencies, rigid motions left out, Hz, ascending, (K,)."""
        known = np.array(self.known) if isinstance(self.known, tuple) else self.known.lowest(self.count)
        return np.asarray(self.unit * known)

    @property
    def rigid_motions(self) -> int:
        """Number of independent rigid motions w = c0 + c1 x + c2 y that the supports allow."""
        rows = []
        for loop, supports in self.loops:
            for curve, support in zip(loop.curves, supports, strict=True):
                if support == "free":
                    continue
                x, y = (curve.at(np.linspace(0.0, 1.0, 5)) / np.sqrt(self.outline.area)).T
                rows.append(np.stack([np.ones(5), x, y], axis=1))
                if support == "clamped":
                    rows.append(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
        return 3 - int(np.linalg.matrix_rank(np.vstack(rows), tol=1e-9)) if rows else 3


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
