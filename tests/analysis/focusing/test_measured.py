"""Filters from measured transfers, against those of the model the transfers were taken from."""

import numpy as np
import pytest

from analysis.focusing.measured import MeasuredPanel, MeasuredTransfers, compare_measured, focus_measured
from analysis.focusing.methods import designer
from analysis.focusing.over_temperature import focus
from analysis.focusing.performance import contrast


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    """Lay out a panel whose 20 × 16 cells hold whole cells of the target, as points of a scan do."""
    settings = {"taps": 128, "sample_rate": 11_025.0, "transform_length": 1_024}
    panel = make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings)
    return make_plate(panel.model_copy(update={"grid": (20, 20)}))


@pytest.fixture(scope="module")
def transfers(plain, softening):
    frequency = plain.panel.filters.frequency
    material = softening.at(np.array([20.0, 40.0]))
    rows = zip(material.youngs_modulus, material.poisson_ratio, material.loss_factor, strict=True)
    fields = np.array([plain.amplitudes(*map(float, row), frequency) @ plain.space.deflection.T for row in rows])
    points = plain.grid.points
    return MeasuredTransfers(np.array([20.0, 40.0]), points, frequency, fields, np.zeros(fields.shape))


def noisy(transfers, decibels, rng):
    rms = np.sqrt((np.abs(transfers.transfer) ** 2).mean(axis=(2, 3), keepdims=True))
    sigma = np.broadcast_to(rms * 10.0 ** (-decibels / 20.0), transfers.transfer.shape)
    draws = rng.normal(size=(2, *sigma.shape)) / np.sqrt(2.0)
    h = transfers.transfer + sigma * (draws[0] + 1j * draws[1])
    return MeasuredTransfers(transfers.temperature, transfers.points, transfers.frequency, h, sigma**2)


def test_noise_free_transfers_give_the_model_s_own_filters(plain, softening, transfers):
    found = focus_measured(MeasuredPanel(plain.panel, transfers))
    exact = focus(plain, plain.panel, softening, np.array([20.0, 40.0]))
    np.testing.assert_allclose(found.bank.taps, exact.bank.taps, atol=1e-6 * np.abs(exact.bank.taps).max())
    np.testing.assert_allclose(found.direct.contrast, exact.direct.contrast, atol=1e-9)
    np.testing.assert_allclose(found.fixed.contrast, exact.fixed.contrast, atol=1e-9)


def test_at_40_db_the_true_contrast_is_within_a_hundredth_of_the_noise_free_one(plain, transfers, rng):
    true = MeasuredPanel(plain.panel, transfers)
    lines = plain.panel.filters.frequency
    band = plain.panel.filters.in_band(lines)
    seen = MeasuredPanel(plain.panel, noisy(transfers, 40.0, rng))
    best, found = focus_measured(true), focus_measured(seen)
    for t in range(2):
        judge = true.forms(t, 1e-6)[1].at(slice(None), band)
        real = contrast(judge, found.bank.response(lines[band])[t : t + 1])[0]
        assert real.mean() > best.direct.contrast[t].mean() - 0.01
        # What the noisy measurement says of itself is unbiased: near the truth, line by line on average.
        assert found.direct.contrast[t].mean() == pytest.approx(real.mean(), abs=0.01)


def test_a_noisy_measurement_is_regularised_by_its_own_variance(plain, transfers, rng):
    """At 10 dB, filters that know the variance beat those that take the noise for the plate."""
    true = MeasuredPanel(plain.panel, transfers)
    lines = plain.panel.filters.frequency
    band = plain.panel.filters.in_band(lines)
    with_noise = noisy(transfers, 10.0, rng)
    blind = MeasuredTransfers(
        with_noise.temperature,
        with_noise.points,
        with_noise.frequency,
        with_noise.transfer,
        0.0 * with_noise.variance,
    )
    reached = []
    for known in (with_noise, blind):
        bank = focus_measured(MeasuredPanel(plain.panel, known)).bank.response(lines[band])
        judge = true.forms(0, 1e-6)[1].at(slice(None), band)
        reached.append(contrast(judge, bank[:1]).mean())
    assert reached[0] > reached[1] + 0.005


@pytest.mark.parametrize(("decibels", "off"), [(10.0, 0.01), (0.0, 0.05)])
def test_noise_as_strong_as_the_field_does_not_pass_for_contrast(plain, transfers, rng, decibels, off):
    """Less the noise, energies of single lines are negative, and a ratio of them would be cut at 1."""
    lines = plain.panel.filters.frequency
    band = plain.panel.filters.in_band(lines)
    found = focus_measured(MeasuredPanel(plain.panel, noisy(transfers, decibels, rng)))
    judge = MeasuredPanel(plain.panel, transfers).forms(0, 1e-6)[1].at(slice(None), band)
    real = contrast(judge, found.bank.response(lines[band])[:1])[0]
    assert found.direct.contrast[0].mean() == pytest.approx(real.mean(), abs=off)
    assert found.direct.contrast[0].max() < 0.7


def test_methods_that_need_no_model_are_compared_and_modal_control_is_refused(plain, transfers):
    measured = MeasuredPanel(plain.panel, transfers)
    assert compare_measured(measured).methods == ("stif", "time-reversal", "none")
    assert focus_measured(measured, "time-reversal").bank.delay > 64
    with pytest.raises(ValueError, match="needs the modes"):
        focus_measured(measured, "modal-control")
    assert designer("none", plain, plain.panel, transfers.frequency) is not None


def test_missing_points_are_named(transfers):
    h = transfers.transfer.copy()
    h[:, 2, :, 7] = np.nan
    with pytest.raises(ValueError, match=r"1 of 2400 transfers are missing.*actuator 3 to point 8"):
        MeasuredTransfers(transfers.temperature, transfers.points, transfers.frequency, h, transfers.variance)
