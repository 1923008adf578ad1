import numpy as np
from scipy.interpolate import BSpline

from analysis.cubic_basis import cubic_basis

KNOTS = np.concatenate([np.full(3, -5.0), np.array([-5.0, -1.0, 0.5, 0.6, 7.0, 20.0]), np.full(3, 20.0)])


def test_b_splines_equal_those_of_scipy_ends_and_knots_included(rng):
    place = np.concatenate([rng.uniform(-5.0, 20.0, 200), KNOTS])
    exact = BSpline.design_matrix(place, KNOTS, 3).toarray()
    np.testing.assert_allclose(cubic_basis(place, KNOTS), exact, rtol=0, atol=1e-15)


def test_they_hold_every_cubic_by_its_blossom():
    """Coefficients of a cubic x³ are the products of three neighbouring knots."""
    place = np.linspace(-5.0, 20.0, 101)
    coefficients = KNOTS[1:-3] * KNOTS[2:-2] * KNOTS[3:-1]
    np.testing.assert_allclose(cubic_basis(place, KNOTS) @ coefficients, place**3, rtol=1e-12, atol=1e-9)
