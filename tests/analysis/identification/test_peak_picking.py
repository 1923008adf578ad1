import numpy as np
import pytest

from analysis.identification.automatic import identify, identify_by_peaks
from analysis.identification.measured import Measured
from analysis.identification.pole_residue import REAL_E_F, synthesis

FREQUENCY = np.arange(100.0, 1000.0, 0.5)


def plate(f: np.ndarray, zeta: float, rng: np.random.Generator) -> np.ndarray:
    poles = 2 * np.pi * f * complex(-zeta, np.sqrt(1 - zeta**2))
    constants = np.array([[0.01, 0.01 * (2 * np.pi * 300) ** 2]], complex)
    clean = synthesis(FREQUENCY, poles, 1j * np.ones((1, len(f))), REAL_E_F, constants)
    noise = 0.003 * np.sqrt(np.mean(np.abs(clean) ** 2) / 2)
    return clean + noise * (rng.normal(size=clean.shape) + 1j * rng.normal(size=clean.shape))


def test_well_separated_peaks_are_found_and_refined() -> None:
    f = np.array([180.0, 310.0, 540.0, 860.0])
    modes = identify_by_peaks(Measured(FREQUENCY, plate(f, 0.01, np.random.default_rng(0))))
    read = modes.reading("viscous")
    assert modes.real.sum() == 4
    f_error = read.frequency_hz[modes.real] - f
    zeta_error = read.damping_ratio[modes.real] - 0.01
    assert (np.abs(f_error) < 4 * read.sigma_frequency_hz[modes.real]).all()
    assert (np.abs(zeta_error) < 4 * read.sigma_damping_ratio[modes.real]).all()


def test_a_mode_without_a_peak_of_its_own_is_missed() -> None:
    """The reason why this is not the default."""
    f = np.array([180.0, 310.0, 322.0, 860.0])
    measured = Measured(FREQUENCY, plate(f, 0.05, np.random.default_rng(0)))
    assert identify_by_peaks(measured).real.sum() == 3
    assert identify(measured).real.sum() == 4


def test_noise_has_no_peaks_to_pick() -> None:
    rng = np.random.default_rng(1)
    h = rng.normal(size=(1, 200)) + 1j * rng.normal(size=(1, 200))
    with pytest.raises(ValueError, match="no peak"):
        identify_by_peaks(Measured(FREQUENCY[:200], h))
