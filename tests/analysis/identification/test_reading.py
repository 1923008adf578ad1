import numpy as np
import pytest

from analysis.identification.modes import read_poles
from analysis.identification.pole_residue import to_parameters, to_poles


def test_hysteretic_reading_gives_back_stiffness_and_loss_factor() -> None:
    """A mode of k(1 + j eta) has its pole at j w sqrt(1 + j eta), exactly."""
    f, eta = np.array([64.0, 300.0, 1450.0]), np.array([0.03, 0.085, 0.3])
    poles = 2j * np.pi * f * np.sqrt(1 + 1j * eta)
    read = read_poles(poles, np.zeros((3, 2, 2)))
    np.testing.assert_allclose(read.frequency_hz, f, rtol=1e-13)
    np.testing.assert_allclose(read.loss_factor, eta, rtol=1e-12)


def test_viscous_reading_gives_back_frequency_and_damping_ratio() -> None:
    f, zeta = np.array([64.0, 1450.0]), np.array([0.001, 0.2])
    read = read_poles(2 * np.pi * f * (-zeta + 1j * np.sqrt(1 - zeta**2)), np.zeros((2, 2, 2)), "viscous")
    np.testing.assert_allclose(read.frequency_hz, f, rtol=1e-13)
    np.testing.assert_allclose(read.damping_ratio, zeta, rtol=1e-13)
    np.testing.assert_allclose(read.loss_factor, 2 * zeta, rtol=1e-13)


def test_the_two_readings_differ_by_a_quarter_of_the_squared_loss_factor() -> None:
    poles = 2j * np.pi * np.array([200.0]) * np.sqrt(1 + 0.08j)
    f = [read_poles(poles, np.zeros((1, 2, 2)), kind).frequency_hz[0] for kind in ("hysteretic", "viscous")]
    assert f[1] / f[0] - 1 == pytest.approx(0.08**2 / 4, rel=0.02)


@pytest.mark.parametrize("kind", ["hysteretic", "viscous"])
def test_deviations_are_those_of_scattered_poles(kind) -> None:
    pole = np.array([2j * np.pi * 200.0 * np.sqrt(1 + 0.2j)])
    covariance = np.array([[4e-6, 3e-6], [3e-6, 9e-4]])
    draws = np.random.default_rng(1).multivariate_normal(to_parameters(pole)[0], covariance, 20000)
    scattered = read_poles(to_poles(draws), np.zeros((20000, 2, 2)), kind)
    read = read_poles(pole, covariance[None], kind)
    for name in ("frequency_hz", "damping_ratio", "loss_factor"):
        assert getattr(read, f"sigma_{name}")[0] == pytest.approx(getattr(scattered, name).std(), rel=0.03)


def test_a_reading_that_does_not_exist_is_refused() -> None:
    with pytest.raises(ValueError, match="damping 'viscose': hysteretic or viscous"):
        read_poles(np.array([-1.0 + 100j]), np.zeros((1, 2, 2)), "viscose")  # type: ignore[arg-type]
