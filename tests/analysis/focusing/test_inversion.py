import numpy as np
import pytest

from analysis.focusing.energy import EnergyForms
from analysis.focusing.methods import invert, tikhonov


def dense(space, amplitudes):
    """H weighted by the square root of the area, (F, K, N), and the weighted target shape."""
    root = np.sqrt(space.grid.area)
    return np.einsum("k,kr,nfr->fkn", root, space.deflection, amplitudes), root * space.grid.target


@pytest.fixture
def plate(supported):
    frequency = np.linspace(90.0, 800.0, 15)
    amplitudes = [supported.amplitudes(e, 0.33, 0.06, frequency) for e in (2.2e9, 1.2e9)]
    return supported.space, amplitudes


def test_with_a_vanishing_tolerance_tikhonov_is_the_pseudo_inverse(plate):
    space, amplitudes = plate
    filters = invert(space.forms(amplitudes), 1e-7).filters
    for t, amplitude in enumerate(amplitudes):
        transfer, shape = dense(space, amplitude)
        exact = np.linalg.pinv(transfer) @ shape
        np.testing.assert_allclose(filters[t], exact, rtol=0, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("tolerance", [0.3, 0.01])
def test_both_regularisations_equal_the_dense_singular_value_form(plate, tolerance):
    space, amplitudes = plate
    forms = space.forms(amplitudes)
    tikhonov, truncated = (invert(forms, tolerance, kind) for kind in ("tikhonov", "truncation"))
    for t, amplitude in enumerate(amplitudes):
        transfer, shape = dense(space, amplitude)
        u, s, vh = np.linalg.svd(transfer, full_matrices=False)
        image = np.einsum("fkn,k->fn", u.conj(), shape)
        gains = (s / (s**2 + (tolerance * s[:, :1]) ** 2), np.where(s > tolerance * s[:, :1], 1.0 / s, 0.0))
        for found, gain in zip((tikhonov, truncated), gains, strict=True):
            exact = np.einsum("fnm,fn->fm", vh.conj(), gain * image)
            np.testing.assert_allclose(found.filters[t], exact, rtol=0, atol=1e-9 * np.abs(exact).max())
        np.testing.assert_array_equal(truncated.rank[t], np.sum(s > tolerance * s[:, :1], axis=1))
        np.testing.assert_allclose(truncated.condition[t], s[:, 0] / s[:, -1], rtol=1e-6)


def test_a_square_invertible_transfer_reaches_the_target_exactly(rng):
    """Six points, six actuators: H R = φ."""
    transfer = rng.normal(size=(1, 4, 6, 6)) + 1j * rng.normal(size=(1, 4, 6, 6))
    shape = np.array([0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    adjoint = transfer.conj().swapaxes(-1, -2)
    forms = EnergyForms(adjoint @ transfer, adjoint * shape @ transfer, adjoint @ shape)
    filters = invert(forms, 1e-7).filters
    np.testing.assert_allclose(
        np.einsum("tfkn,tfn->tfk", transfer, filters), np.broadcast_to(shape, (1, 4, 6)), atol=1e-9
    )


def test_truncation_drops_what_is_too_weak():
    plate = np.zeros((3, 2, 2, 2), dtype=complex)
    plate[..., 0, 0] = 1.0
    plate[..., 1, 1] = [[0.5, 0.5], [0.5, 1e-6], [1e-6, 1e-6]]
    forms = EnergyForms(plate, plate, np.ones((3, 2, 2), dtype=complex))
    inverse = invert(forms, 0.1, "truncation")
    np.testing.assert_array_equal(inverse.rank, [[2, 2], [2, 1], [1, 1]])
    np.testing.assert_allclose(inverse.filters[2], [[1.0, 0.0], [1.0, 0.0]])


def test_a_silent_actuator_is_left_silent():
    """A zero column of H must not become NaN in either regularisation."""
    plate = np.zeros((1, 1, 2, 2), dtype=complex)
    plate[..., 0, 0] = 4.0
    forms = EnergyForms(plate, plate, np.array([[[2.0, 0.0]]], dtype=complex))
    for kind in ("tikhonov", "truncation"):
        np.testing.assert_allclose(invert(forms, 1e-3, kind).filters[0, 0], [0.5, 0.0], atol=1e-6)


def test_nonsense_is_refused(plate):
    forms = plate[0].forms(plate[1])
    with pytest.raises(ValueError, match="outside 1e-7 to 1"):
        invert(forms, 0.0)
    with pytest.raises(ValueError, match="tikhonov or truncation"):
        invert(forms, 0.1, "ridge")


@pytest.mark.parametrize("tolerance", [1e-3, 0.01, 0.3])
def test_tikhonov_without_singular_values_gives_the_same_filters(plate, tolerance):
    space, amplitudes = plate
    forms = space.forms(amplitudes)
    expected = invert(forms, tolerance).filters
    np.testing.assert_allclose(tikhonov(forms, tolerance), expected, rtol=0, atol=1e-9 * np.abs(expected).max())
