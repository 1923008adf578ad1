"""Local expansions of the laws against differences of the laws themselves."""

import numpy as np
import pytest

from analysis.material import Material, MaterialLaws, laws_through

T = np.linspace(-10.0, 70.0, 9)


@pytest.fixture
def laws() -> MaterialLaws:
    bend = np.tanh((T - 30.0) / 25.0)
    return laws_through(T, Material(2e9 - 1e9 * bend, 0.38 + 0.04 * bend, 0.07 - 0.02 * bend**2))


def logs(laws: MaterialLaws, temperature: float) -> np.ndarray:
    found = laws.at(temperature)
    return np.array([np.log(found.youngs_modulus[0]), found.poisson_ratio[0], np.log(found.loss_factor[0])])


@pytest.mark.parametrize("temperature", [-5.0, 12.3, 30.0, 64.0])
def test_value_slope_and_curvature_are_those_of_differences(laws: MaterialLaws, temperature: float) -> None:
    local, step = laws.local(temperature), 0.02
    colder, here, warmer = (logs(laws, temperature + shift) for shift in (-step, 0.0, step))
    assert local.reference == temperature
    np.testing.assert_allclose(local.value, here, rtol=1e-12)
    np.testing.assert_allclose(local.slope, (warmer - colder) / (2 * step), atol=1e-7)
    np.testing.assert_allclose(local.curvature, (warmer - 2 * here + colder) / step**2, atol=2e-6)


def test_a_few_kelvins_away_only_the_third_order_is_missing(laws: MaterialLaws) -> None:
    errors = []
    for away in (0.5, 1.0, 2.0):
        local, exact = laws.local(22.0), laws.at(22.0 + away)
        errors.append(abs(np.log(local.youngs_modulus(22.0 + away) / exact.youngs_modulus[0])))
        assert local.poisson_ratio(22.0 + away) == pytest.approx(exact.poisson_ratio[0], abs=1e-4)
        assert local.loss_factor(22.0 + away) == pytest.approx(exact.loss_factor[0], rel=2e-3)
    orders = np.log2(np.array(errors[1:]) / np.array(errors[:-1]))
    assert (orders > 2.8).all()


@pytest.mark.parametrize("edge", [-10.0, 70.0])
def test_reaches_to_the_edges_and_no_further(laws: MaterialLaws, edge: float) -> None:
    assert np.isfinite(laws.local(edge).slope).all()
    with pytest.raises(ValueError, match="not extrapolated"):
        laws.local(edge * 1.01)
