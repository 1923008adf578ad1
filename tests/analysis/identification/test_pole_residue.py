import numpy as np

from analysis.identification.pole_residue import NONE, REAL_E_F, fill_columns, pole_columns, synthesis


def test_synthesis_is_the_receptance_of_a_single_oscillator() -> None:
    m, f0, zeta = 0.3, 120.0, 0.04
    w0 = 2 * np.pi * f0
    frequency = np.linspace(10.0, 300.0, 50)
    w = 2 * np.pi * frequency
    pole = w0 * (-zeta + 1j * np.sqrt(1 - zeta**2))
    residue = 1 / (2j * m * pole.imag)
    found = synthesis(frequency, np.array([pole]), np.array([[residue]]), NONE, np.zeros((1, 0), complex))[0]
    np.testing.assert_allclose(found, 1 / (m * (w0**2 - w**2 + 2j * zeta * w0 * w)), rtol=1e-12)


def test_residual_terms_are_flexibility_and_inertia() -> None:
    frequency = np.array([10.0, 100.0])
    none = np.zeros(0, complex), np.zeros((1, 0), complex)
    found = synthesis(frequency, *none, REAL_E_F, np.array([[2.0, 3.0]], complex))
    np.testing.assert_allclose(found[0], 2.0 - 3.0 / (2 * np.pi * frequency) ** 2)


def test_derivative_columns_are_the_derivative() -> None:
    s = 2j * np.pi * np.linspace(50.0, 150.0, 21)
    pole, residue, step = complex(-20.0, 600.0), 0.7 - 0.3j, (1.0 + 2.0j) * 1e-5
    columns, moved = np.empty((2, 2, len(s)), dtype=complex)
    fill_columns(s, np.array([pole]), columns, moved)
    np.testing.assert_allclose(columns, pole_columns(s, np.array([pole])), rtol=1e-12)
    change = residue * step
    ahead = pole_columns(s, np.array([pole + step]))
    behind = pole_columns(s, np.array([pole - step]))
    numeric = residue.real * (ahead - behind)[0] / 2 + residue.imag * (ahead - behind)[1] / 2
    np.testing.assert_allclose(change.real * moved[0] + change.imag * moved[1], numeric, rtol=1e-6)
