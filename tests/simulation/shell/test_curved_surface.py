"""Strains of a curved surface: none of rigid motions, and those of a ring that breathes."""

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.experiment import Plate
from simulation.shell.rigidity import THX, THY, CurvedSurface, U, V, W

SIDES = (0.3, 0.2)
POINTS = np.random.default_rng(3).uniform(0.02, 0.18, (40, 2))
STEP = 1e-6


def plate(**curvature: object) -> Plate:
    return Plate.model_validate(
        {"length_x": SIDES[0], "length_y": SIDES[1], "thickness": 0.003, "mass": 0.2, "curvature": curvature}
    )


BUMPY = plate(height=((0.0, 0.004, 0.002), (0.003, 0.005, 0.0), (-0.006, 0.0, 0.001)))


def places(of: Plate, points: Real) -> Real:
    return np.column_stack([points, of.height(points)])


def normal(of: Plate, points: Real) -> Real:
    found = np.column_stack([-of.slope(points), np.ones(len(points))])
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def strains(of: Plate, displacement: object, director: object) -> Real:
    """All eight (8, K) of displacements and directors (K, 3), functions of points (K, 2)."""
    values = {}
    for letter, axis in (("x", 0), ("y", 1)):
        step = STEP * np.eye(2)[axis]
        for first, motion in ((U, displacement), (THX, director)):
            slope = (motion(POINTS + step) - motion(POINTS - step)) / (2 * STEP)
            values |= {(first + k, letter): slope[:, k] for k in range(3 if first == U else 2)}
    turn = director(POINTS)
    values |= {(THX, "0"): turn[:, 0], (THY, "0"): turn[:, 1]}
    forms = CurvedSurface.of(of, POINTS).strains
    return np.array([sum(factor * values[key] for key, factor in form.items()) for form in forms])


@pytest.mark.parametrize("axis", range(3))
def test_rigid_motions_strain_nothing(axis: int) -> None:
    unit = np.eye(3)[axis]
    shifted = strains(BUMPY, lambda p: np.tile(unit, (len(p), 1)), lambda p: np.zeros((len(p), 3)))
    turned = strains(BUMPY, lambda p: np.cross(unit, places(BUMPY, p)), lambda p: np.cross(unit, normal(BUMPY, p)))
    assert np.abs(shifted).max() < 1e-9
    assert np.abs(turned).max() < 1e-7


@pytest.mark.parametrize(("key", "hoop"), [("radius_x", 0), ("radius_y", 1)])
def test_a_cylinder_that_breathes_stretches_along_its_hoop(key: str, hoop: int) -> None:
    """Displacement e along the outward normal, which stays: the strain is e times the curvature along the hoop."""
    curved = plate(**{key: -0.5})
    surface = CurvedSurface.of(curved, POINTS)
    found = strains(curved, lambda p: 1e-3 * normal(curved, p), lambda p: np.zeros((len(p), 3)))
    slope = surface.slope[hoop]
    curvature = 2.0 / (1.0 + slope**2) ** 1.5  # of the parabola of this radius at its apex
    other = 1 - hoop
    np.testing.assert_allclose(found[hoop], 1e-3 * curvature, rtol=1e-6)
    assert np.abs(found[[other, 2, 6, 7]]).max() < 1e-9


def test_the_area_is_that_of_the_graph() -> None:
    surface = CurvedSurface.of(BUMPY, POINTS)
    step = STEP * np.eye(2)
    tangents = [(places(BUMPY, POINTS + d) - places(BUMPY, POINTS - d)) / (2 * STEP) for d in step]
    np.testing.assert_allclose(surface.area, np.linalg.norm(np.cross(*tangents), axis=1), rtol=1e-8)
    with pytest.raises(ValueError, match="flat"):
        CurvedSurface.of(BUMPY.model_copy(update={"curvature": None}), POINTS)


def test_fields_are_numbered_as_those_of_the_shell() -> None:
    form = CurvedSurface.of(BUMPY, POINTS).strains[0]
    assert {field for field, _ in form} <= {U, V, W}
    assert {THX, THY} <= {field for field, _ in CurvedSurface.of(BUMPY, POINTS).strains[3]}
