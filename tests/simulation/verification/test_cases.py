"""Every case describes the plate its frequencies belong to, checked by an independent thin-plate element."""

import re
from dataclasses import replace

import numpy as np
import pytest
import skfem
from scipy.sparse.linalg import eigsh
from skfem.helpers import dd, ddot, eye, trace

from analysis.geometry.shapes import circle, rectangle
from simulation.verification.cases import CASES
from simulation.verification.exact_cases import disc_case, rectangle_case
from simulation.verification.published import PUBLISHED, STEEL


def named(name):
    (case,) = (case for case in CASES if case.name == name)
    return case


def test_names_are_unique_and_fit_for_files():
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z0-9.-]+", name) for name in names)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_references_ascend_and_stay_below_the_stiffest_of_bending(case):
    assert case.reference.size >= 6
    assert np.all(np.diff(case.reference) > -1e-9 * case.reference[0])
    assert case.reference[0] > 0
    assert len(case.published) <= case.reference.size
    shown = case.unit * np.array(case.published)
    assert shown == pytest.approx(case.reference[: shown.size], rel=0.016)


def test_exact_references_are_printed_ones_in_hertz():
    """The clamped disc: 10.213 sqrt(D / rho h) / 2 pi a^2 with D = 6410 N m, rho h = 27 kg/m2."""
    disc = named("disc-clamped-0.01")
    assert disc.rigidity == pytest.approx(70e9 * 1e-6 / (12 * 0.91))
    assert disc.reference[0] == pytest.approx(10.213 * np.sqrt(disc.rigidity / 27) / (2 * np.pi), rel=5e-6)
    assert named("annulus-free-free-0.1").area == pytest.approx(np.pi * (1 - 0.09), rel=1e-12)


def test_fv12_is_a_square_of_navier_size():
    """In Hz, of a square of 10 m: the free thin one's first values of w a^2 sqrt(rho h / D) are 13.468, 19.596."""
    case = named("fv12")
    unit = np.sqrt(case.rigidity / (STEEL.density * 0.05)) / (2 * np.pi * 100)
    assert case.reference[0] / unit == pytest.approx(13.468, rel=2e-3)
    assert case.reference[1] / unit == pytest.approx(19.596, rel=2e-3)


@pytest.mark.parametrize(
    ("case", "left"),
    [
        (disc_case(0.1, "free"), 3),
        (disc_case(0.1, "soft"), 0),
        (rectangle_case(0.1, "free", "free"), 0),
        (named("fv16"), 0),
        (replace(named("fv12"), supports=("soft", "free", "free", "free")), 1),
        (replace(named("fv12"), supports=("soft", "hard", "free", "free")), 0),
    ],
    ids=["free", "soft", "two edges", "cantilever", "hinged along one edge", "two edges at a corner"],
)
def test_rigid_motions_that_supports_leave(case, left):
    assert case.rigid_motions == left


def meshed(case, refinements):
    """Triangles: of a disc made an ellipse, or fanned from a point from which all of a polygon is seen."""
    if "ellipse" in case.name:
        return skfem.MeshTri.init_circle(refinements).scaled([1.0, 0.5])
    outline = case.outline.polygon
    middle = np.array([0.25, 0.25]) if "l-shape" in case.name else np.array(case.outline.centroid)
    points = np.vstack([outline, middle]).T
    around = np.arange(len(outline))
    fan = np.stack([around, np.roll(around, -1), np.full(len(outline), len(outline))])
    return skfem.MeshTri(points, fan).refined(refinements)


def thin_frequencies(case, refinements):
    """Kirchhoff plate by Morley triangles, free or clamped all round, Hz."""
    basis = skfem.Basis(meshed(case, refinements), skfem.ElementTriMorley())
    nu = case.material.poisson_ratio

    @skfem.BilinearForm
    def bending(u, v, _):
        curvature = dd(u)
        return ddot((1 - nu) * curvature + nu * eye(trace(curvature), 2), dd(v))

    @skfem.BilinearForm
    def inertia(u, v, _):
        return u * v

    k, m = case.rigidity * bending.assemble(basis), inertia.assemble(basis)
    m = case.material.density * case.thickness * m
    if case.supports[0] == "clamped":
        inside = basis.complement_dofs(basis.get_dofs())
        k, m = k[inside][:, inside], m[inside][:, inside]
    shift = -((2 * np.pi * 0.3 * case.reference[0]) ** 2)
    start = np.random.default_rng(0).standard_normal(k.shape[0])
    squares = eigsh(k, case.rigid_motions + 4, m, sigma=shift, v0=start, return_eigenvectors=False)
    return np.sqrt(np.sort(np.abs(squares)))[case.rigid_motions :] / (2 * np.pi)


@pytest.mark.parametrize("name", [c.name for c in PUBLISHED if c.name not in ("fv16", "fv22")])
def test_thin_cases_are_near_an_independent_thin_plate(name):
    """Within 1.5 % of a Kirchhoff solution, extrapolated: outline, size, supports and unit are right."""
    case = named(name)
    coarse, fine = (thin_frequencies(case, refinements) for refinements in (4, 5))
    extrapolated = fine + (fine - coarse) / 3
    assert extrapolated == pytest.approx(case.reference[:4], rel=0.015)


def test_wrong_cases_are_refused():
    case = named("fv12")
    with pytest.raises(ValueError, match="fv12: 4 curves, supports of 1"):
        replace(case, supports=("free",))
    with pytest.raises(ValueError, match="support is 'glued'"):
        replace(case, supports=("free", "free", "free", "glued"))
    with pytest.raises(ValueError, match="1 holes, supports of 0"):
        replace(case, holes=(circle((5.0, 5.0), 1.0),))
    with pytest.raises(ValueError, match="tolerance is 0"):
        replace(case, tolerance=0.0)
    assert replace(case, outline=rectangle((0.0, 0.0), (2.0, 1.0))).area == pytest.approx(2.0)
