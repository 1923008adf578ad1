"""B-splines against scipy's, and against polynomials that they reproduce."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from analysis.b_splines import derivative, design_matrix


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_values_and_derivatives_are_those_of_scipy(degree: int) -> None:
    rng = np.random.default_rng(3)
    inner = np.sort(rng.uniform(0.0, 4.0, 9))
    knots = np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, 4.0)])
    x = np.concatenate([[0.0, 4.0], inner, rng.uniform(0.0, 4.0, 50)])
    design = design_matrix(x, knots, degree)
    np.testing.assert_allclose(design.toarray(), BSpline.design_matrix(x, knots, degree).toarray(), atol=1e-14)
    coefficients = rng.normal(size=design.shape[1])
    x = x[11:]  # at a knot the derivative of a straight line jumps
    slope = design_matrix(x, knots[1:-1], degree - 1) @ derivative(coefficients, knots, degree)
    np.testing.assert_allclose(slope, BSpline(knots, coefficients, degree).derivative()(x), rtol=1e-10)


def test_the_splines_sum_to_one_and_have_straight_lines_at_the_mean_knots() -> None:
    knots = np.concatenate([np.zeros(4), [0.3, 0.5, 1.1], np.full(4, 2.0)])
    x = np.linspace(0.0, 2.0, 41)
    design = design_matrix(x, knots, 3)
    greville = np.array([knots[k + 1 : k + 4].mean() for k in range(design.shape[1])])
    np.testing.assert_allclose(design @ np.ones(len(greville)), 1.0, atol=1e-14)
    np.testing.assert_allclose(design @ greville, x, atol=1e-14)
    np.testing.assert_allclose(derivative(greville, knots, 3), 1.0, atol=1e-13)
