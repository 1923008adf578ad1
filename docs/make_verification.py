"""Make docs/verification.md and its pictures again: python docs/make_verification.py [--case NAME ...].

Every case of `tests/simulation/verification/cases.py` is computed on three meshes, each half as wide as the last.
With --case only those are computed and their tables printed; nothing is written.
"""

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from finite_element_plate import solve_plate
from numpy.typing import NDArray
from solid_comparison import section as solids
from verification_pictures import draw_mesh, draw_modes

from analysis.arrays import Real
from tests.simulation.verification.case import Case, CaseComparison, compare_all, left_out, section, summary
from tests.simulation.verification.cases import CASES

DOCS = Path(__file__).resolve().parent
PAGE = DOCS / "verification.md"
IMAGES = DOCS / "images" / "verification"
PICTURED = ("disc", "annulus", "rectangle", "fv", "triangle", "l-shape", "ellipse")
"""One case of each of these families is pictured, the first that is covered."""
REFINEMENTS = (0, 1, 2)


HEAD = """# Verification

Natural frequencies of the finite-element plate (Reissner-Mindlin, shear factor 5/6, rotary inertia) beside known
ones. This page is written by `python docs/make_verification.py`.

- *exact*: solutions of the same plate theory. Discs and annuli by Bessel functions, rectangles on hard simple
  supports by Navier and Levy (`tests/simulation/verification`); these are tested against thin plates, printed
  values and an independent Ritz solution.
- *converged*: values of an independent finite-element solution of the same theory on fine meshes. Published
  values, of thin plates or coarse elements, stand beside them and lie up to 1.5 % off.
- The finest mesh has 150 to 320 cells of degree 6 and 12,000 to 26,000 unknowns, the middle one a third of that.
  Cells get smaller towards corners; the rotation along curved and oblique hard supports is held by a penalty.
- *soft* simple support holds the deflection, *hard* the rotation along the edge too.
- *order*: exponent of the mesh size with which the frequencies change over three meshes, each half as wide as the
  last; a dash where they change by rounding only. Modes are numbered from the lowest, rigid motions left out.
  Strips along the edges keep their width, and where all three meshes are good to some 1e-6 the order says nothing.
"""


@dataclass(frozen=True)
class Solved:
    """What a solver gives for one case on one mesh.

    Attributes
    ----------
    frequency : (K,) ndarray
        Bending modes, rigid motions included, Hz, ascending.
    cells : list of (P, 2) ndarray
        Outline of every cell of the mesh, m.
    points, triangles : (N, 2) ndarray, m, and (T, 3) ndarray
        What deflections are drawn on.
    deflection : (K, N) ndarray
        Of every mode at the points.
    """

    frequency: Real
    cells: list[Real] = field(repr=False)
    points: Real = field(repr=False)
    triangles: NDArray[np.int_] = field(repr=False)
    deflection: Real = field(repr=False)


def solve_with_the_finite_element_plate(case: Case, refinement: int) -> Solved:
    """Compute one case. The one place that knows the solver."""
    return Solved(*solve_plate(case, refinement))


def frequencies(case: Case, refinement: int) -> Real:
    """Natural frequencies of one case on one mesh, Hz."""
    return solve_with_the_finite_element_plate(case, refinement).frequency


def pictures(comparison: CaseComparison) -> dict[str, str]:
    """Draw mesh and modes of a case; their captions and paths from the page."""
    case = comparison.case
    coarsest, solved = (solve_with_the_finite_element_plate(case, REFINEMENTS[k]) for k in (0, -1))
    draw_mesh(coarsest.cells, IMAGES / f"{case.name}-mesh.png")
    first, count = case.rigid_motions, min(8, case.reference.size)
    titles = [f"{value / case.unit:.5g}" for value in comparison.frequency[-1][:count]]
    modes = solved.deflection[first : first + count]
    draw_modes(solved.points, solved.triangles, modes, titles, IMAGES / f"{case.name}-modes.png")
    here = IMAGES.relative_to(DOCS).as_posix()
    return {"Coarsest mesh": f"{here}/{case.name}-mesh.png", "Modes": f"{here}/{case.name}-modes.png"}


def page() -> str:
    """Compute everything and return the text of the page."""
    done, missing = compare_all(CASES, frequencies, REFINEMENTS)
    parts = [HEAD, "## Summary\n", summary(done), solids()]
    if missing:
        parts.append(left_out(CASES, missing))
    parts.append("## Cases\n")
    to_draw = set(PICTURED)
    for comparison in done:
        family = next((f for f in PICTURED if comparison.case.name.startswith(f)), "")
        drawn = pictures(comparison) if family in to_draw else {}
        to_draw.discard(family)
        parts.append(section(comparison, drawn))
    return "\n".join(parts)


def main() -> None:
    """Write the page, or print the tables of some cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [case.name for case in CASES]
    parser.add_argument("--case", action="append", choices=names, metavar="NAME", help="; ".join(names))
    chosen = parser.parse_args().case
    if chosen:
        some = [case for case in CASES if case.name in chosen]
        done, missing = compare_all(some, frequencies, REFINEMENTS)
        print("\n".join(section(comparison) for comparison in done) + left_out(some, missing))
        return
    PAGE.write_text(page(), encoding="utf-8")
    print(f"{PAGE} and pictures in {IMAGES} made again; look at them before committing")


if __name__ == "__main__":
    main()
