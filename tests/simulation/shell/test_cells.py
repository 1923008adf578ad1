"""Rules of quadrature against integrals in closed form."""

from math import factorial

import numpy as np
import pytest

from simulation.shell.cells import quad_rule, triangle_rule


@pytest.mark.parametrize("order", [2, 7, 16, 19, 20, 24, 28])
def test_triangle_rules_are_exact_up_to_their_order(order: int) -> None:
    """The integral of x**i y**j over the unit triangle is i! j! / (i + j + 2)!."""
    (x, y), weights = triangle_rule(order)
    assert x.min() > 0.0
    assert y.min() > 0.0
    assert (x + y).max() < 1.0
    for i in range(order + 1):
        for j in range(order + 1 - i):
            exact = factorial(i) * factorial(j) / factorial(i + j + 2)
            assert weights @ (x**i * y**j) == pytest.approx(exact, rel=1e-9), (i, j)


@pytest.mark.parametrize("order", [3, 20])
def test_quadrilateral_rules_are_exact_up_to_their_order(order: int) -> None:
    (x, y), weights = quad_rule(order)
    for i in range(order + 1):
        exact = 4.0 / (i + 1) ** 2 if i % 2 == 0 else 0.0
        assert weights @ (x * y) ** i == pytest.approx(exact, abs=1e-12), i
    assert np.isclose(weights.sum(), 4.0)
