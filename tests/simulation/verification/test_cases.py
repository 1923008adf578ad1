"""Every case describes the plate its frequencies belong to, checked by an independent element."""

import re
from dataclasses import replace

import numpy as np
import pytest
import skfem
from scipy.sparse import block_diag, bmat
from scipy.sparse.linalg import eigsh

from analysis.geometry.loop import circle, rectangle
from tests.simulation.verification.cases import CASES, STEEL, disc_case, rectangle_case


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
    """Triangles: curved ones of an ellipse, or fanned from a point from which all of a polygon is seen."""
    if case.name.startswith(("disc", "ellipse")):
        _, high = case.outline.bounds
        return skfem.MeshTri2.init_circle(refinements).scaled(high)
    outline = case.outline.polygon
    middle = np.array([0.25, 0.25]) if "l-shape" in case.name else case.outline.polygon.mean(axis=0)
    points = np.vstack([outline, middle]).T
    around = np.arange(len(outline))
    fan = np.stack([around, np.roll(around, -1), np.full(len(outline), len(outline))])
    return skfem.MeshTri(points, fan).refined(refinements)


def by_triangles(case, refinements):
    """Elastic frequencies of the Mindlin plate by triangles of degree 4 for w and both rotations, Hz."""
    basis = skfem.Basis(meshed(case, refinements), skfem.ElementTriP4())

    def integral(form):
        return skfem.BilinearForm(form).assemble(basis)

    xx = integral(lambda u, v, _: u.grad[0] * v.grad[0])
    yy = integral(lambda u, v, _: u.grad[1] * v.grad[1])
    xy = integral(lambda u, v, _: u.grad[1] * v.grad[0])
    x0, y0 = (integral(lambda u, v, _, k=k: u * v.grad[k]) for k in (0, 1))
    m = integral(lambda u, v, _: u * v)
    e, nu, rho = case.material.youngs_modulus, case.material.poisson_ratio, case.material.density
    h, d = case.thickness, case.rigidity
    s, g = 5 / 6 * e / (2 * (1 + nu)) * h, (1 - nu) / 2
    stiffness = bmat(
        [
            [s * (xx + yy), s * x0, s * y0],
            [s * x0.T, d * (xx + g * yy) + s * m, d * (nu * xy + g * xy.T)],
            [s * y0.T, d * (nu * xy.T + g * xy), d * (yy + g * xx) + s * m],
        ],
        format="csc",
    )
    mass = rho * block_diag([h * m, h**3 / 12 * m, h**3 / 12 * m], format="csc")
    if case.name == "fv16":
        held = basis.get_dofs(lambda x: x[0] < 1e-9).all()
    else:
        held = basis.get_dofs().all() if case.supports[0] == "clamped" else np.array([], int)
    kept = np.setdiff1d(np.arange(3 * basis.N), np.concatenate([held, held + basis.N, held + 2 * basis.N]))
    shift = -((2 * np.pi * 0.3 * case.reference[0]) ** 2)
    squares = eigsh(
        stiffness[kept][:, kept],
        case.rigid_motions + 6,
        mass[kept][:, kept],
        sigma=shift,
        v0=np.random.default_rng(0).standard_normal(kept.size),
        return_eigenvectors=False,
    )
    return np.sqrt(np.sort(np.abs(squares)))[case.rigid_motions :] / (2 * np.pi)


INDEPENDENT = {
    "disc-free-0.1": 2e-5,
    "disc-free-0.2": 1e-5,
    "disc-clamped-0.1": 1e-5,
    "fv15": 1e-4,
    "fv22": 1e-5,
    "triangle-free": 3e-4,
    "triangle-clamped": 1e-4,
    "ellipse-clamped": 4e-5,
    "ellipse-free": 7e-4,
    "fv12": 1e-3,
    "fv16": 1e-3,
    "l-shape-free": 3e-3,
    "l-shape-clamped": 1.2e-2,
}
"""How close uniform triangles come: layers at free edges and re-entrant corners keep them from the rest."""


@pytest.mark.parametrize("name", INDEPENDENT)
def test_references_are_met_by_an_independent_element(name):
    """Outline, size, supports, material and unit are those the frequencies belong to."""
    case = named(name)
    error = by_triangles(case, 3) / case.reference[:6] - 1
    assert np.abs(error).max() < INDEPENDENT[name]


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
