"""A fleet's scatter, outliers and predictions: against the analysis of variance, exact intervals and draws."""

import numpy as np
import pytest
from scipy.stats import t as student

from analysis.arrays import Real
from analysis.fleet import OUTLIER_PROBABILITY, Scatter, estimate_scatter, outliers, predict_piece

TEMPERATURES = np.linspace(0.0, 60.0, 7)
LAW = np.log(2.6e9) - 0.018 * TEMPERATURES


def drawn(
    rng: np.random.Generator, pieces: int, between: float, within: float, error: float = 0.0
) -> tuple[Real, Real, Real]:
    """Draw values, their covariances, and the true laws of pieces."""
    count = TEMPERATURES.size
    true = LAW + rng.normal(0.0, between, (pieces, 1)) + rng.normal(0.0, within, (pieces, count))
    covariance = np.broadcast_to(error**2 * np.eye(count), (pieces, count, count))
    return true + rng.normal(0.0, error or 0.0, true.shape), covariance, true


def test_balanced_pieces_have_the_analysis_of_variance():
    """With mean squares MB, MW of P pieces at K temperatures: omega^2 = MW, tau^2 = (MB - MW) / K."""
    values, covariance, _ = drawn(np.random.default_rng(1), 9, 0.03, 0.01)
    found = estimate_scatter(values, covariance)
    pieces, count = values.shape
    left = values - values.mean(0)
    between = count * np.sum(left.mean(1) ** 2) / (pieces - 1)
    within = np.sum((left - left.mean(1)[:, None]) ** 2) / ((pieces - 1) * (count - 1))
    assert found.within == pytest.approx(np.sqrt(within), rel=1e-3)
    assert found.between == pytest.approx(np.sqrt((between - within) / count), rel=1e-3)
    np.testing.assert_allclose(found.mean, values.mean(0), rtol=1e-12)
    whole = found.between**2 + found.within**2 * np.eye(count)
    np.testing.assert_allclose(found.covariance, whole / pieces, rtol=1e-9)


def test_known_errors_are_not_taken_for_scatter():
    """An error of the size of the scatter within, of known size: what is left is the scatter, on average."""
    rng = np.random.default_rng(2)
    found = [estimate_scatter(*drawn(rng, 12, 0.03, 0.01, 0.01)[:2]) for _ in range(60)]
    assert np.sqrt(np.mean([one.between**2 for one in found])) == pytest.approx(0.03, rel=0.1)
    assert np.sqrt(np.mean([one.within**2 for one in found])) == pytest.approx(0.01, rel=0.1)


def test_equal_pieces_have_no_scatter_between_them():
    values, covariance, _ = drawn(np.random.default_rng(7), 8, 0.0, 0.0, 0.01)
    found = estimate_scatter(values - values.mean(1)[:, None], covariance)
    assert found.between == 0.0
    assert found.within < 0.005


def test_one_temperature_has_the_standard_deviation_of_its_values():
    values = np.random.default_rng(3).normal(1.0, 0.2, (6, 1))
    found = estimate_scatter(values, np.zeros((6, 1, 1)))
    assert found.between == pytest.approx(values.std(ddof=1), rel=1e-3)
    assert found.within == 0.0


def test_a_piece_that_was_not_measured_has_the_interval_of_one_more_value():
    values = np.random.default_rng(4).normal(5.0, 0.3, (7, 1))
    found = predict_piece(estimate_scatter(values, np.zeros((7, 1, 1))), share=0.9)
    half = student.ppf(0.95, 6) * values.std(ddof=1) * np.sqrt(1.0 + 1.0 / 7.0)
    assert found.value[0] == pytest.approx(values.mean())
    assert found.high[0] - found.value[0] == pytest.approx(half, rel=1e-3)


def test_a_measured_temperature_conditions_the_others():
    """Textbook case: two temperatures, correlation rho; mean rho d, variance (1 - rho^2) s^2."""
    fleet = Scatter(np.zeros(2), np.zeros((2, 2)), 0.6, 0.8, 1000)
    found = predict_piece(fleet, 0, 0.5)
    rho = 0.36
    np.testing.assert_allclose(found.value, [0.5, rho * 0.5])
    width = student.ppf(0.95, 999) * np.sqrt(1.0 - rho**2)
    np.testing.assert_allclose(found.high - found.value, [0.0, width], atol=1e-7)


def test_a_thirteenth_piece_is_inside_its_band_as_often_as_said():
    """Measured at one temperature: nine of ten laws, counted over temperatures, lie within the band of 90 %."""
    rng = np.random.default_rng(5)
    inside = []
    for _ in range(200):
        values, covariance, _ = drawn(rng, 12, 0.03, 0.004, 0.003)
        measured, _, true = drawn(rng, 1, 0.03, 0.004, 0.003)
        band = predict_piece(estimate_scatter(values, covariance), 2, measured[0, 2], 0.003)
        inside.append((band.low <= true[0]) & (true[0] <= band.high))
        assert (band.high - band.low).max() < 0.05  # the fleet as a whole: 0.11
    share = np.mean(inside)
    assert 0.88 < share < 0.96


def test_false_outliers_are_as_rare_as_said_and_true_ones_are_found():
    rng = np.random.default_rng(6)
    called = [bool(outliers({"E": drawn(rng, 10, 0.03, 0.004)[:2]})) for _ in range(40)]
    assert np.mean(called) <= 5 * OUTLIER_PROBABILITY
    values, covariance, _ = drawn(rng, 12, 0.03, 0.004)
    values[4] += 0.25
    values[9] += 0.22  # hides behind the other until that is out
    found = outliers({"E": (values, covariance), "nu": drawn(rng, 12, 0.01, 0.002)[:2]})
    assert {one.piece for one in found} == {4, 9}
    assert {one.quantity for one in found} == {"E"}
    assert all(one.deviation == pytest.approx(0.23, abs=0.08) for one in found)


def test_a_small_misfit_is_no_outlier():
    rng = np.random.default_rng(8)
    values = rng.normal(0.0, 0.05, (10, 1))
    values[3] = -2.0
    quantities = {"misfit": (values, np.zeros((10, 1, 1)))}
    assert [one.piece for one in outliers(quantities)] == [3]
    assert outliers(quantities, one_sided=("misfit",)) == ()


@pytest.mark.parametrize(
    ("values", "covariance"), [(np.zeros((1, 3)), np.zeros((1, 3, 3))), (np.zeros((4, 3)), np.zeros((4, 3)))]
)
def test_nonsense_is_refused(values: Real, covariance: Real):
    with pytest.raises(ValueError, match="allowed: "):
        estimate_scatter(values, covariance)
    with pytest.raises(ValueError, match="share 1; allowed"):
        predict_piece(Scatter(np.zeros(1), np.zeros((1, 1)), 0.1, 0.0, 5), share=1.0)
