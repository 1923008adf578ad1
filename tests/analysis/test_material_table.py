import numpy as np
import pytest

from analysis.material import Material, laws_through

T = np.array([-10.0, 5.0, 20.0, 40.0, 70.0])


def test_passes_through_the_values_and_claims_no_band() -> None:
    values = Material(
        np.geomspace(3e9, 1e9, 5), np.linspace(0.34, 0.43, 5), np.array([0.04, 0.05, 0.07, 0.06, 0.05])
    )
    laws = laws_through(T, values)
    back = laws.at(T)
    np.testing.assert_allclose(back.youngs_modulus, values.youngs_modulus, rtol=1e-12)
    np.testing.assert_allclose(back.poisson_ratio, values.poisson_ratio, rtol=1e-12)
    np.testing.assert_allclose(back.loss_factor, values.loss_factor, rtol=1e-12)
    assert not laws.sigma(T).youngs_modulus.any()
    assert laws.temperature_range == (-10.0, 70.0)


def test_a_cubic_law_is_met_between_the_values() -> None:
    def cubic(t: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        return np.asarray(0.3 + 1e-3 * t + 1e-5 * t**2 - 1e-7 * t**3)

    laws = laws_through(T, Material(np.exp(cubic(T)), cubic(T), np.exp(cubic(T))))
    between = np.linspace(-10.0, 70.0, 41)
    np.testing.assert_allclose(laws.at(between).poisson_ratio, cubic(between), rtol=1e-9)
    np.testing.assert_allclose(np.log(laws.at(between).youngs_modulus), cubic(between), rtol=1e-9)


@pytest.mark.parametrize("temperature", [T[:3], T[::-1], T * 0.0])
def test_too_few_or_disordered_temperatures_are_refused(temperature: np.ndarray) -> None:  # type: ignore[type-arg]
    values = np.ones(temperature.size)
    with pytest.raises(ValueError, match="at least 4"):
        laws_through(temperature, Material(values, values, values))
