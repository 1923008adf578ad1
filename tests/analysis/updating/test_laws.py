"""Laws recover smooth truths, their bands cover them, and nothing is extrapolated."""

import numpy as np
import pytest

from analysis.experiment import Protocol
from analysis.material import Material, MaterialSigma
from analysis.updating.laws import fit_laws, laws_of_sweeps

READING = 0.035
PROTOCOL = Protocol(
    sweep="linear",
    band=(100.0, 900.0),
    sweep_duration=1.0,
    tail=0.1,
    repeats=2,
    ramp_rate=0.4,
    temperatures=(15.0, 25.0, 35.0, 45.0),
    directions=("up",),
    levels=(0.5, 1.0, 2.0),
)


def truth(t):
    return Material(
        1.0e9 + 2.25e9 / (1 + np.exp((t - 22.0) / 12.0)),
        0.34 + 0.135 / (1 + np.exp((40.0 - t) / 8.0)),
        0.035 + 0.05 * np.exp(-(((t - 15.0) / 15.0) ** 2)),
    )


def estimates(rng: np.random.Generator, t, scale: float = 1.0):
    """Noisy estimates at readings that miss the plate's temperature by the reading's own noise."""
    real = truth(t + READING * rng.standard_normal(len(t)))
    sigma = MaterialSigma(3e-5 * real.youngs_modulus, np.full(len(t), 1e-4), 2e-3 * real.loss_factor)
    parts = [
        getattr(real, n) + scale * getattr(sigma, n) * rng.standard_normal(len(t))
        for n in ("youngs_modulus", "poisson_ratio", "loss_factor")
    ]
    return Material(*parts), sigma


def test_bands_cover_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(2)
    t, fine = np.arange(0.0, 61.0, 2.0), np.arange(1.0, 60.0)
    inside = []
    for _ in range(30):
        laws = fit_laws(t, *estimates(rng, t), reading_sigma=READING)
        value, band, real = laws.at(fine), laws.sigma(fine), truth(fine)
        inside.append(
            [
                (np.abs(getattr(value, n) - getattr(real, n)) < 1.96 * getattr(band, n)).mean()
                for n in ("youngs_modulus", "poisson_ratio", "loss_factor")
            ]
        )
    np.testing.assert_allclose(np.mean(inside, axis=0), 0.95, atol=0.04)


def test_readings_worse_than_stated_widen_the_band() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 61.0, 2.0)
    material, sigma = estimates(rng, t)
    modulus = material.youngs_modulus * (1 + 0.01 * rng.standard_normal(len(t)))
    shaken = Material(modulus, material.poisson_ratio, material.loss_factor)
    calm = fit_laws(t, material, sigma, reading_sigma=READING).sigma(30.0).youngs_modulus[0]
    wide = fit_laws(t, shaken, sigma, reading_sigma=READING).sigma(30.0).youngs_modulus[0]
    assert wide > 3 * calm


def test_modulus_never_rises_however_noisy() -> None:
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 61.0, 2.0)
    flat = np.full(len(t), 2e9) * (1 + 0.02 * rng.standard_normal(len(t)))
    material = Material(flat, np.full(len(t), 0.4), np.full(len(t), 0.05))
    sigma = Material(1e-5 * flat, np.full(len(t), 1e-3), np.full(len(t), 1e-3))
    modulus = fit_laws(t, material, sigma).at(np.linspace(0, 60, 601)).youngs_modulus
    assert (np.diff(modulus) <= 1e-6 * modulus[1:]).all()


def test_an_exact_line_comes_back_exactly() -> None:
    t = np.linspace(0.0, 60.0, 13)
    line = Material(3e9 * np.exp(-0.02 * t), 0.34 + 0.002 * t, 0.08 * np.exp(-0.01 * t))
    small = Material(1e-6 * line.youngs_modulus, np.full(13, 1e-6), 1e-6 * line.loss_factor)
    laws = fit_laws(t, line, small)
    fine = np.linspace(0.0, 60.0, 50)
    np.testing.assert_allclose(laws.at(fine).youngs_modulus, 3e9 * np.exp(-0.02 * fine), rtol=1e-6)
    np.testing.assert_allclose(laws.at(fine).poisson_ratio, 0.34 + 0.002 * fine, rtol=1e-6)


def test_refuses_to_extrapolate_and_too_few_temperatures() -> None:
    t = np.linspace(10.0, 50.0, 9)
    material, sigma = estimates(np.random.default_rng(5), t)
    laws = fit_laws(t, material, sigma)
    with pytest.raises(ValueError, match=r"temperature 60 °C is outside the laws' range, 10 to 50 °C"):
        laws.at([20.0, 60.0])
    with pytest.raises(ValueError, match="not extrapolated"):
        fit_laws(t, material, sigma, temperature_range=(0.0, 60.0))
    with pytest.raises(ValueError, match="at least 3 different temperatures"):
        fit_laws(t[:2], Material(*[getattr(material, n)[:2] for n in vars(material)]), sigma)


def test_legs_and_levels_at_two_temperatures_are_no_third_one() -> None:
    """A campaign of several levels, interrupted: its readings differ by hundredths at one set-point."""
    t = np.array([14.98, 15.03, 15.08, 25.01])
    material, sigma = estimates(np.random.default_rng(5), t)
    assert laws_of_sweeps(t, material, sigma, np.ones(4, dtype=bool), PROTOCOL) is None
    with pytest.raises(ValueError, match="at least 3 different temperatures; there are 2"):
        fit_laws(t, material, sigma)
    more = np.append(t, 35.0)
    material, sigma = estimates(np.random.default_rng(5), more)
    assert laws_of_sweeps(more, material, sigma, np.ones(5, dtype=bool), PROTOCOL) is not None
