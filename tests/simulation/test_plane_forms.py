"""Weighed energies of polynomial motions, against integrals by hand."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from simulation.meshing.recipe import MeshRecipe, mesh_lines
from simulation.plane_forms import MODULI, ShearForm, plane_form, shell_matrix, weighted_sum
from simulation.shape_space import ShapeSpace

A, B = 0.2, 0.1
RECIPE = MeshRecipe(degree=4, spacing=0.05, edge_strip=0.05, thinned=False)


@pytest.fixture(scope="module")
def space() -> ShapeSpace:
    return ShapeSpace.on(mesh_lines(A, [], RECIPE), mesh_lines(B, [], RECIPE), RECIPE)


@pytest.fixture(scope="module")
def motion(space):
    """Functions of x and y -> their coefficients, exact up to degree 4."""
    x, y = space.quadrature_points
    mass = space.product("0", "0").tocsc()

    def of(function):
        chosen = np.arange(space.basis.nelems)
        moments = np.einsum(
            "edq,eq->ed", space.at_quadrature("0", chosen), space.basis.dx * (function(x, y) + 0.0 * x)
        )
        load = np.zeros(space.size)
        np.add.at(load, np.asarray(space.basis.element_dofs).T, moments)
        return spsolve(mass, load)

    return of


def energy(blocks, u, v):
    (a, b), (c, d) = blocks
    return u @ (a @ u) + u @ (b @ v) + v @ (c @ u) + v @ (d @ v)


def test_the_four_energies_of_a_quadratic_motion(space, motion):
    """Of u = x**2 + x y, v = y**2: e_x = 2 x + y, e_y = 2 y, g_xy = x; weight 1 + x, over 0.2 x 0.1."""
    u, v = motion(lambda x, y: x**2 + x * y), motion(lambda x, y: y**2)
    weight = 1.0 + space.quadrature_points[0]

    def integral(m, n):
        return A ** (m + 1) / (m + 1) * B ** (n + 1) / (n + 1)

    def weighed(m, n):
        return integral(m, n) + integral(m + 1, n)

    by_hand = {
        "q11": 4.0 * weighed(2, 0) + 4.0 * weighed(1, 1) + weighed(0, 2),
        "q22": 4.0 * weighed(0, 2),
        "q12": 2.0 * (4.0 * weighed(1, 1) + 2.0 * weighed(0, 2)),
        "q66": weighed(2, 0),
    }
    for modulus in MODULI:
        assert energy(plane_form(space, modulus, weight), u, v) == pytest.approx(by_hand[modulus], rel=1e-10)


def test_energies_over_some_elements_add_up(space, motion):
    u, v = motion(lambda x, y: x**2 * y), motion(lambda x, y: x * y**2)
    left = space.centers[0] < 0.5 * A
    for modulus in MODULI:
        parts = [plane_form(space, modulus, None, covered) for covered in (left, ~left)]
        assert energy(weighted_sum(parts), u, v) == pytest.approx(
            energy(plane_form(space, modulus), u, v), rel=1e-12
        )
        assert energy(parts[0], u, v) != pytest.approx(energy(parts[1], u, v), rel=0.1)


def test_shear_of_a_turn_is_none_and_of_a_tilt_is_half_the_story(space, motion):
    """A tilt w = 3 x with thx = -3 does not shear; w alone or thx alone does, by 9 over the area each."""
    nothing = motion(lambda x, y: 0.0)
    tilt, turn = motion(lambda x, y: 3.0 * x), motion(lambda x, y: -3.0)
    form = ShearForm.of(space)
    empty = plane_form(space, "q11", np.zeros(space.basis.dx.shape))
    shear = shell_matrix(empty, None, empty, form)

    def stored(w, thx):
        whole = np.concatenate([nothing, nothing, w, thx, nothing])
        return whole @ (shear @ whole)

    assert abs(stored(tilt, turn)) < 1e-12
    assert stored(tilt, nothing) == pytest.approx(9.0 * A * B, rel=1e-10)
    assert stored(nothing, turn) == pytest.approx(9.0 * A * B, rel=1e-10)


def test_a_layer_off_the_middle_couples_stretch_and_bending(space, motion):
    """A layer of thickness t at height z of u + z thx: coupling t z, bending t z**2, as of the motion at z."""
    t, z = 0.001, 0.002
    blocks = plane_form(space, "q11")

    def scaled(factor):
        return weighted_sum([plane_form(space, "q11", factor * np.ones(space.basis.dx.shape))])

    layer = shell_matrix(scaled(t), scaled(t * z), scaled(t * z**2), None)
    nothing = motion(lambda x, y: 0.0)
    u, thx = motion(lambda x, y: x**2), motion(lambda x, y: x * y)
    whole = np.concatenate([u, nothing, nothing, thx, nothing])
    assert abs(layer - layer.T).max() < 1e-12 * abs(layer).max()
    assert whole @ (layer @ whole) == pytest.approx(t * energy(blocks, u + z * thx, nothing), rel=1e-12)
