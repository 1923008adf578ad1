"""Functions of the reference cells: counts, slopes, traces, independence, and rules of quadrature."""

import numpy as np
import pytest

from simulation.shell.shape_functions import (
    bow_coefficients,
    kernels,
    lobatto,
    quad_functions,
    quad_rule,
    triangle_functions,
    triangle_rule,
)

KINDS = [
    (quad_functions, quad_rule, lambda p: (p + 1) ** 2, 4),
    (triangle_functions, triangle_rule, lambda p: (p + 1) * (p + 2) // 2, 3),
]


@pytest.mark.parametrize("degree", [1, 2, 5, 8])
@pytest.mark.parametrize(("functions", "rule", "count", "corners"), KINDS)
def test_functions_are_as_many_as_polynomials_and_independent(functions, rule, count, corners, degree):
    places, weights = rule(2 * degree)
    value = functions(degree, places).value
    assert len(value) == count(degree)
    gram = (value * weights) @ value.T
    scale = 1.0 / np.sqrt(np.diag(gram))
    assert np.linalg.matrix_rank(gram * scale * scale[:, None], tol=1e-10) == count(degree)
    assert value[:corners].sum(axis=0) == pytest.approx(1.0)


@pytest.mark.parametrize(("functions", "rule", "count", "corners"), KINDS)
def test_slopes_are_differences(functions, rule, count, corners):
    places, _ = rule(7)
    slope = functions(8, places).slope
    for axis in range(2):
        step = np.zeros((2, 1))
        step[axis] = 1e-6
        difference = (functions(8, places + step).value - functions(8, places - step).value) / 2e-6
        assert slope[axis] == pytest.approx(difference, abs=1e-7)


def test_insides_vanish_on_the_edges():
    s = np.linspace(-1.0, 1.0, 7)
    t, one = 0.5 * (s + 1.0), np.ones(7)
    square = np.hstack([[s, -one], [s, one], [-one, s], [one, s]])
    assert quad_functions(6, square).value[4 * 6 :] == pytest.approx(0.0, abs=1e-14)
    triangle = np.hstack([[t, 0 * t], [0 * t, t], [t, 1 - t]])
    assert triangle_functions(6, triangle).value[3 * 6 :] == pytest.approx(0.0, abs=1e-14)


def test_both_cells_have_the_same_functions_on_an_edge():
    s = np.linspace(-1.0, 1.0, 7)
    rows = lobatto(6, s)[0]
    assert quad_functions(6, np.stack([s, -np.ones(7)])).value[4:9] == pytest.approx(rows)
    assert triangle_functions(6, np.stack([0.5 * (s + 1.0), np.zeros(7)])).value[3:8] == pytest.approx(rows)


@pytest.mark.parametrize("order", [2, 5, 12, 19, 20, 23])
def test_rules_are_exact_to_their_order(order):
    (x, y), weights = quad_rule(order)
    even = order - order % 2
    assert weights @ (x**even * y**even) == pytest.approx(4.0 / (even + 1) ** 2)
    (x, y), weights = triangle_rule(order)
    assert weights @ x**order == pytest.approx(1.0 / ((order + 1) * (order + 2)))


def test_kernels_times_the_bubble_are_the_functions():
    s = np.linspace(-0.9, 0.9, 9)
    assert (1 - s**2) * kernels(8, s)[0] == pytest.approx(lobatto(8, s)[0])


def test_derivatives_of_the_functions_are_orthonormal():
    nodes, weights = np.polynomial.legendre.leggauss(12)
    slope = lobatto(8, nodes)[1]
    assert (slope * weights) @ slope.T == pytest.approx(np.eye(7), abs=1e-12)


def test_bows_take_a_chord_to_its_curve():
    def arc(t):
        angle = 0.2 + 0.7 * np.asarray(t)
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    s = np.linspace(-1.0, 1.0, 11)
    ends = arc(np.array([0.0, 1.0]))
    chord = 0.5 * np.outer(1 - s, ends[0]) + 0.5 * np.outer(1 + s, ends[1])
    for degree, miss in ((2, 3e-3), (4, 3e-5), (8, 1e-9)):
        found = chord + lobatto(degree, s)[0].T @ bow_coefficients(arc, degree)
        assert np.abs(found - arc(0.5 * (s + 1.0))).max() < miss
    assert not bow_coefficients(lambda t: np.outer(t, [3.0, 4.0]), 8).any()
