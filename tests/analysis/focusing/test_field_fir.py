"""Taps fitted to the field, against the same least squares written tap by tap, and against what it promises."""

import numpy as np
import pytest
from scipy.linalg import toeplitz

from analysis.focusing.design import OUT_OF_BAND_WEIGHT, FieldFit, ProlateTaps, TapDesign, fitted, peak_drive
from analysis.focusing.fir import FirBank, inverse_fft, taper
from analysis.focusing.methods import invert
from analysis.focusing.panel import Filters
from analysis.focusing.performance import contrast, mean_response

SETTINGS = Filters(taps=48, sample_rate=4_000.0, transform_length=512, band=(100.0, 500.0), edges=(50.0, 600.0))


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    settings = {"taps": 96, "sample_rate": 8_000.0, "transform_length": 2_048}
    return make_plate(make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings))


def forms_at(plate, constants=(1.6e9, 0.36, 0.07)):
    lines = plate.panel.filters.frequency
    return plate.space.forms([plate.amplitudes(*constants, lines)], plate.panel.target.displacement)


def test_sequences_are_orthonormal_and_what_is_left_out_is_not_heard():
    basis = ProlateTaps.of(SETTINGS)
    np.testing.assert_allclose(basis.sequences @ basis.sequences.T, np.eye(len(basis.sequences)), atol=1e-12)
    rest = np.eye(48) - basis.sequences.T @ basis.sequences
    spectrum = np.exp(-2j * np.pi * np.outer(SETTINGS.frequency, np.arange(48)) / 4_000.0)
    assert np.abs(spectrum @ rest).max() < 1e-5


def test_the_outside_is_the_integral_over_all_other_frequencies():
    basis = ProlateTaps.of(SETTINGS)
    fine = (np.arange(400_000) + 0.5) / 400_000 * 2_000.0
    fine = fine[(fine < 50.0) | (fine > 600.0)]
    time = np.arange(48) - basis.middle
    exact = np.zeros((len(basis.sequences),) * 2)
    for part in np.array_split(fine, 100):
        spectrum = np.exp(-2j * np.pi * np.outer(part, time) / 4_000.0) @ basis.sequences.T
        exact += (spectrum.conj().T @ spectrum).real
    spacing = 4_000.0 / 512
    np.testing.assert_allclose(basis.outside, exact * 2_000.0 / 400_000 / spacing, atol=1e-3)


def test_taps_are_those_of_the_dense_least_squares(rng):
    """Normal equations of 3 × 48 taps: block-Toeplitz, summed line by line, sinc in closed form outside."""
    lines, count, delay = SETTINGS.frequency, 3, 19
    root = rng.normal(size=(len(lines), 4, count)) + 1j * rng.normal(size=(len(lines), 4, count))
    weight = root.conj().transpose(0, 2, 1) @ root
    wanted = rng.normal(size=(len(lines), count)) + 1j * rng.normal(size=(len(lines), count))
    gain, spacing = taper(lines, SETTINGS), lines[1] - lines[0]
    lag = np.arange(48) / 4_000.0

    def sinc(head):
        return toeplitz(2.0 * head / 4_000.0 * np.sinc(2.0 * head * lag))

    small = OUT_OF_BAND_WEIGHT * np.median(np.linalg.eigvalsh(weight[gain == 1.0])[:, -1])
    beyond = 2_000.0 / spacing * (np.eye(48) - sinc(600.0) + sinc(50.0))
    normal, right = np.zeros((count, 48, count, 48)), np.zeros((count, 48))
    for f, p, r, g in zip(lines, weight, wanted, gain, strict=True):
        e = np.exp(-2j * np.pi * f * np.arange(48) / 4_000.0)
        normal += g * (p[:, None, :, None] * np.outer(e.conj(), e)[None, :, None, :]).real
        right += g * np.outer(p @ r * np.exp(-2j * np.pi * f * delay / 4_000.0), e.conj()).real
        beyond = beyond + (1.0 - g) * np.outer(e.conj(), e).real
    for n in range(count):
        normal[n, :, n] += small * beyond
    exact = np.linalg.solve(normal.reshape(144, 144), right.ravel()).reshape(count, 48)
    found = (
        FieldFit.of(SETTINGS)
        .problem(weight, np.linalg.eigvalsh(weight)[:, -1], wanted, delay)
        .solve(np.zeros(count))
    )
    np.testing.assert_allclose(found, exact, atol=1e-5 * np.abs(exact).max())


def test_the_worst_line_with_taps_stands_beside_the_uncut_one_where_the_inverse_fft_falls(plain):
    forms, settings = forms_at(plain), plain.panel.filters
    band = settings.in_band(settings.frequency)
    wanted = invert(forms.weighted(settings.kappa), settings.tolerance).filters
    design = TapDesign.of(plain.panel, settings.middle)
    lines = settings.frequency[band]
    within = forms.at(slice(None), band)
    taps = design.bank(design.taps(forms, wanted[0])[None], np.zeros(1)).response(lines)
    cut = inverse_fft(wanted, np.zeros(1), settings, settings.middle).response(lines)
    uncut = contrast(within, wanted[:, band]).min()
    assert contrast(within, taps).min() > uncut - 0.03
    assert contrast(within, taps).mean() > contrast(within, cut).mean()
    phase = np.angle(mean_response(within, taps, plain.space.asked(1e-6)), deg=True)
    assert np.abs(phase).max() < 15.0


def test_more_weight_outside_buys_contrast_and_costs_level(plain):
    reached = []
    for kappa in (1.0, 3.0, 10.0):
        panel = plain.panel.model_copy(
            update={"filters": plain.panel.filters.model_copy(update={"outside_weight": kappa})}
        )
        forms, settings = forms_at(plain), panel.filters
        band = settings.in_band(settings.frequency)
        wanted = invert(forms.weighted(kappa), settings.tolerance).filters[0]
        taps = TapDesign.of(panel, settings.middle)
        response = taps.bank(taps.taps(forms, wanted)[None], np.zeros(1)).response(settings.frequency[band])
        within = forms.at(slice(None), band)
        level = np.abs(mean_response(within, response, plain.space.asked(1e-6))).mean()
        reached.append((contrast(within, response).mean(), level))
    contrasts, levels = zip(*reached, strict=True)
    assert contrasts[0] < contrasts[1] < contrasts[2]
    assert levels[0] > levels[1] > levels[2]


@pytest.mark.parametrize("share", [0.9, 0.5, 0.2])
def test_no_actuator_is_driven_beyond_its_rating_and_the_field_is_kept_where_one_is_weak(plain, share):
    """One patch rated at a share of what it would take: pricing its volts keeps more level than turning all down.

    The price is raised in steps that do not overshoot: most of the rating is used.
    """
    forms, settings = forms_at(plain), plain.panel.filters
    wanted = invert(forms.weighted(settings.kappa), settings.tolerance).filters[0]
    free = TapDesign.of(plain.panel, settings.middle)
    peak = peak_drive(free.taps(forms, wanted))
    limits = np.full(6, np.inf)
    limits[2] = share * peak[2]
    held = TapDesign(plain.panel, free.delay, limits, free.fit)
    taps = held.taps(forms, wanted)
    assert np.all(peak_drive(taps) <= limits * (1.0 + 1e-9))
    assert peak_drive(taps)[2] > 0.85 * limits[2]
    others = np.arange(6) != 2
    assert peak_drive(taps)[others].max() > 0.6 * peak[others].max()


def test_the_inverse_fft_is_only_turned_down_to_the_ratings(plain):
    settings = plain.panel.filters.model_copy(update={"design": "inverse-fft"})
    panel, forms = plain.panel.model_copy(update={"filters": settings}), forms_at(plain)
    wanted = invert(forms, settings.tolerance).filters[0]
    exact = inverse_fft(wanted[None], np.zeros(1), settings, settings.middle).taps[0]
    free = TapDesign.of(panel, settings.middle)
    assert free.fit is None
    for share in (0.4, 2.0):
        held = TapDesign(panel, free.delay, share * peak_drive(exact), None)
        np.testing.assert_allclose(held.taps(forms, wanted), min(share, 1.0) * exact, rtol=1e-12)


def test_a_bank_s_own_response_is_fitted_back(rng):
    taps = np.zeros((2, 3, 48))
    taps[:, :, 14:34] = (
        np.hanning(20) * rng.normal(size=(2, 3, 1)) * np.cos(2 * np.pi * 300 / 4_000 * np.arange(20))
    )
    bank = FirBank(taps, np.array([0.0, 5.0]), 4_000.0, 24)
    found = fitted(bank.response(SETTINGS.frequency), bank.temperature, FieldFit.of(SETTINGS), 24)
    inside = SETTINGS.frequency[SETTINGS.in_band(SETTINGS.frequency)]
    np.testing.assert_allclose(found.response(inside), bank.response(inside), atol=2e-2 * np.abs(taps).max() * 20)
