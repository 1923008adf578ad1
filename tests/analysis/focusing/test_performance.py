import numpy as np
import pytest
from scipy.linalg import eigh

from analysis.focusing.energy import FieldSpace
from analysis.focusing.methods import invert
from analysis.focusing.performance import area_normalised, best_contrast, contrast, mean_response, spot_error


def forms_of_shapes(grid, shapes):
    """Forms of actuators whose fields are the given real shapes (K, N), at one temperature and line."""
    amplitude = np.eye(shapes.shape[1], dtype=complex)[:, None, :]
    space = FieldSpace.of(shapes, grid)
    return space, amplitude, space.forms([amplitude])


def test_a_uniform_field_has_the_target_s_share_and_one_half_normalised(supported):
    grid = supported.grid
    _, _, forms = forms_of_shapes(grid, np.ones((len(grid.area), 1)))
    filters = np.ones((1, 1), dtype=complex)
    assert contrast(forms, filters).item() == pytest.approx(0.075)
    assert area_normalised(contrast(forms, filters), grid.target_share).item() == pytest.approx(0.5)


def test_a_field_inside_alone_has_contrast_one_and_outside_alone_none(supported):
    grid = supported.grid
    _, _, forms = forms_of_shapes(grid, np.stack([grid.target, 1.0 - grid.target], axis=1))
    for filters, expected in (([2.0j, 0.0], 1.0), ([0.0, 5.0], 0.0)):
        literal = contrast(forms, np.array([filters], dtype=complex))
        assert literal.item() == pytest.approx(expected)
        assert area_normalised(literal, grid.target_share).item() == pytest.approx(expected)


def test_the_target_shape_itself_is_full_level_and_a_delay_is_its_phase(supported):
    grid = supported.grid
    space, _, _ = forms_of_shapes(grid, grid.target[:, None])
    forms = space.forms([np.ones((1, 1, 1), dtype=complex)], 2e-6)
    filters = np.array([[2e-6 * np.exp(0.3j)]])
    assert mean_response(forms, filters, space.asked(2e-6)).item() == pytest.approx(np.exp(0.3j))


def test_contrast_equals_the_dense_field_integral(supported, rng):
    frequency = np.linspace(80.0, 900.0, 11)
    amplitudes = [supported.amplitudes(e, 0.33, 0.06, frequency) for e in (3.0e9, 1.0e9)]
    filters = rng.normal(size=(2, 11, 6)) + 1j * rng.normal(size=(2, 11, 6))
    found = contrast(supported.space.forms(amplitudes), filters)
    grid = supported.grid
    for t, amplitude in enumerate(amplitudes):
        field = supported.space.deflection @ np.einsum("nfr,fn->rf", amplitude, filters[t])
        density = np.abs(field) ** 2 * grid.area[:, None]
        np.testing.assert_allclose(found[t], (grid.target @ density) / density.sum(axis=0), rtol=1e-10)


def test_silence_has_no_contrast_and_no_warning(supported):
    frequency = np.array([100.0])
    forms = supported.space.forms([supported.amplitudes(2e9, 0.33, 0.06, frequency)])
    assert contrast(forms, np.zeros((1, 6), dtype=complex)).item() == 0.0


def test_stif_reaches_the_largest_contrast_of_any_drive_within_reason(supported, rng):
    """No random drive beats the inverse's contrast where six actuators face six modes."""
    frequency = np.array([150.0])
    forms = supported.space.forms([supported.amplitudes(2.2e9, 0.33, 0.06, frequency)])
    best = contrast(forms, invert(forms, 1e-3).filters).item()
    drives = rng.normal(size=(500, 1, 6)) + 1j * rng.normal(size=(500, 1, 6))
    assert all(contrast(forms, drive).item() < best for drive in drives)


def test_no_filters_pass_the_best_contrast_and_a_heavy_outside_comes_near(supported, rng):
    frequency = np.array([150.0, 420.0])
    forms = supported.space.forms([supported.amplitudes(2.2e9, 0.33, 0.06, frequency)])
    bound = best_contrast(forms)
    for line in range(2):
        exact = eigh(forms.target[0, line], forms.plate[0, line], eigvals_only=True)[-1]
        assert bound[0, line] == pytest.approx(exact, abs=1e-6)
    reached = contrast(forms, invert(forms.weighted(1e4), 1e-5).filters)
    assert (reached <= bound + 1e-9).all()
    np.testing.assert_allclose(reached, bound, atol=5e-3)
    assert (best_contrast(forms, 0.3) < bound).all()


@pytest.mark.parametrize(("mode", "peak"), [((1, 1), (0.5, 0.5)), ((2, 1), (0.25, 0.5))])
def test_the_spot_error_of_a_mode_is_the_distance_to_its_antinode(supported, mode, peak):
    grid = supported.grid
    place = (mode[0] - 1) * supported.orders + mode[1] - 1
    amplitude = np.zeros((1, 1, supported.orders**2), dtype=complex)
    amplitude[0, 0, place] = 1j
    found = spot_error(supported.space, amplitude, np.ones((1, 1), dtype=complex)).item()
    exact = np.hypot((peak[0] - 0.3) * 0.24, (peak[1] - 0.55) * 0.19) / 0.24
    cell = np.hypot(0.24 / 40, 0.19 / 30) / 0.24
    assert abs(found - exact) < cell
    assert grid.length[0] == 0.24


def test_the_spot_error_of_the_target_itself_stays_inside_it(supported):
    grid = supported.grid
    bump = np.exp(-np.sum((grid.points - np.array(grid.center)) ** 2, axis=1) / 0.01**2)
    space, amplitude, _ = forms_of_shapes(grid, bump[:, None])
    assert spot_error(space, amplitude, np.ones((1, 1), dtype=complex)).item() < 0.02


def test_forms_of_another_count_of_actuators_are_refused(supported):
    forms = supported.space.forms([supported.amplitudes(2e9, 0.33, 0.06, np.array([100.0]))])
    with pytest.raises(ValueError, match="broadcast"):
        contrast(forms, np.ones((1, 4), dtype=complex))
