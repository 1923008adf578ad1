import numpy as np
import pytest

from analysis.focusing.methods import METHODS, compare, designer, invert, modal_control

CONSTANTS = (1.1e9, 0.33, 0.06)


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    """Lay out a panel of few lines: 100 to 500 Hz every 16 Hz."""
    return make_plate(make_panel(six, transform_length=2_756, band=(100.0, 500.0), edges=(60.0, 560.0)))


def at(plate):
    lines = plate.panel.filters.frequency
    amplitude = plate.amplitudes(*CONSTANTS, lines)
    return lines, amplitude, plate.space.forms([amplitude], plate.panel.target.displacement)


def test_stif_is_the_inverse_with_the_panel_s_settings(plain):
    lines, amplitude, forms = at(plain)
    found = designer("stif", plain, plain.panel, lines)(CONSTANTS, lambda: amplitude, forms)
    expected = invert(forms.weighted(3.0), 0.01).filters[0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("method", ["time-reversal", "none"])
def test_rivals_without_a_gain_of_their_own_move_the_centre_as_asked(plain, method):
    lines, amplitude, forms = at(plain)
    filters = designer(method, plain, plain.panel, lines)(CONSTANTS, lambda: amplitude, forms)
    centre = plain.space.at_point(amplitude, plain.panel.target_center).T
    band = plain.panel.filters.in_band(lines)
    moved = np.abs(np.sum(centre * filters, axis=1))[band].mean()
    assert moved == pytest.approx(1e-6)


def test_modal_control_takes_the_lowest_modes_of_the_model(plain):
    lines, amplitude, forms = at(plain)
    found = designer("modal-control", plain, plain.panel, lines)(CONSTANTS, lambda: amplitude, forms)
    lowest = np.argsort(plain.eigenvalues(*CONSTANTS).real)[:6]
    overlap = (plain.space.plate.T @ plain.space.plate)[np.ix_(lowest, lowest)]
    exact = modal_control(
        overlap, plain.eigenvalues(*CONSTANTS)[lowest], plain.forces[lowest], 1e-6 * plain.space.aim[lowest], lines
    )
    np.testing.assert_allclose(found, exact)


def test_the_comparison_holds_every_method_in_the_band_and_stif_wins(plain):
    found = compare(plain, plain.panel, CONSTANTS)
    assert found.methods == METHODS
    assert found.contrast.shape == found.spot_error.shape == (4, len(found.frequency))
    assert found.frequency[0] >= 100.0
    assert found.frequency[-1] <= 500.0
    means = found.contrast.mean(axis=1)
    assert np.argmax(means) == 0
    assert np.all((found.contrast >= 0.0) & (found.contrast <= 1.0))


def test_a_level_asked_for_is_reached_at_every_line_and_in_phase(plain):
    lines, amplitude, forms = at(plain)
    panel = plain.panel.model_copy(update={"filters": plain.panel.filters.model_copy(update={"level": -6.0})})
    filters = designer("stif", plain, panel, lines)(CONSTANTS, lambda: amplitude, forms)
    grid = plain.grid
    field = plain.space.deflection @ np.einsum("nfr,fn->rf", amplitude, filters)
    mean = (grid.area * grid.target**1) @ field / (grid.area @ grid.target**2)
    np.testing.assert_allclose(mean, 1e-6 * 10 ** (-6 / 20), rtol=1e-9)
