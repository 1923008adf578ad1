"""Cases of docs/make_verification.py by today's tensor mesh: upright rectangles alone."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from analysis.experiment import Plate
from analysis.geometry.curves import Segment
from simulation.meshing.recipe import MeshRecipe
from simulation.mindlin import FIELDS, assemble
from simulation.shell.factors import factorize
from simulation.verification.case import Case
from simulation.verification.report import NotCovered

Real = NDArray[np.float64]
EDGES = ("bottom", "right", "top", "left")
LONGEST = 0.4
"""Length to which plates are scaled, m: `Plate` is for plates of a laboratory."""
DEGREE = 4
DRAWN = 61


def solve_rectangle(case: Case, refinement: int) -> tuple[Real, list[Real], Real, NDArray[np.int_], Real]:
    """Frequencies, cells, points, triangles and deflections, as `Solved` has them."""
    sides, corner = _sides(case)
    scale = LONGEST / sides.max()
    thickness, (length_x, length_y) = scale * case.thickness, scale * sides
    mass = case.material.density * thickness * length_x * length_y
    plate = Plate(length_x=length_x, length_y=length_y, thickness=thickness, mass=mass)
    spacing = float(min(length_x, length_y)) / 2.0 / 2**refinement
    strip = min(thickness, 0.4 * spacing)
    recipe = MeshRecipe(degree=DEGREE, spacing=spacing, strip=strip, edge_strip=strip, thinned=False)
    model = assemble(plate, recipe=recipe, supports=_held(case))
    bending = np.flatnonzero(model.unknowns >= 2 * model.space.size)
    material = case.material
    stiffness = model.stiffness(material.youngs_modulus, material.poisson_ratio)[bending][:, bending]
    inertia = model.mass[bending][:, bending]
    shift = -((2.0 * np.pi * 0.5 * case.reference[0] / scale) ** 2)
    squares, vectors = eigsh(
        stiffness,
        case.rigid_motions + case.reference.size,
        inertia,
        sigma=shift,
        OPinv=LinearOperator(stiffness.shape, matvec=factorize(stiffness - shift * inertia).solve, dtype=float),
        v0=np.random.default_rng(0).standard_normal(bending.size),
    )
    order = np.argsort(squares)
    frequency = scale * np.sqrt(np.abs(squares[order])) / (2.0 * np.pi)
    x, y = np.meshgrid(np.linspace(0.0, length_x, DRAWN), np.linspace(0.0, length_y, DRAWN))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    deflection = (model.deflection(points)[:, bending] @ vectors[:, order]).T
    mesh = model.space.basis.mesh
    cells = [corner + cell / scale for cell in np.moveaxis(mesh.p[:, mesh.t], 0, -1).transpose(1, 0, 2)]
    return frequency, cells, corner + points / scale, _triangles(), deflection


def _sides(case: Case) -> tuple[Real, Real]:
    curves = case.outline.curves
    straight = len(curves) == 4 and all(isinstance(curve, Segment) for curve in curves)
    low, high = case.outline.bounds
    if not straight or case.holes or not np.isclose(np.prod(high - low), case.outline.area, rtol=1e-9):
        raise NotCovered("the present mesh takes upright rectangles only")
    return high - low, low


def _held(case: Case) -> dict[str, tuple[str, ...]]:
    held = {}
    for edge, support in zip(EDGES, case.supports, strict=True):
        along = "thx" if edge in ("bottom", "top") else "thy"
        fields = {"free": (), "soft": ("w",), "hard": ("w", along), "clamped": FIELDS}
        held[edge] = tuple(fields[support])
    return held


def _triangles() -> NDArray[np.int_]:
    number = np.arange(DRAWN**2).reshape(DRAWN, DRAWN)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    return np.vstack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
