"""What measured FRFs have and white noise on a sum of poles has not."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.identification.automatic import identify
from analysis.identification.judgement.status import tones
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured, correlation, deviation_from_residual
from analysis.identification.order import covariance
from analysis.identification.pole_residue import EVERY_CHOICE, NONE, synthesis
from analysis.identification.pole_search import fit
from analysis.identification.settings import Settings
from tests.analysis.identification.test_automatic import Score, score
from tests.synthetic_frf import SyntheticFrf, crowded, pairs, r10, rippled, shared_noise

CASE_2 = Path(__file__).parent / "data" / "vibration_toolbox_case2.npz"


def drawn(make: Callable[[np.random.Generator], SyntheticFrf], seeds: range) -> Score:
    cases = [make(np.random.default_rng(seed)) for seed in seeds]
    return score([(case, identify(Measured(case.frequency, case.h[None]))) for case in cases])


def test_lines_that_share_their_noise_are_counted_once() -> None:
    found = drawn(shared_noise, range(1000, 1006))
    assert (found.missed, found.spurious) == (0, 0)
    assert found.covered() > 0.85


def test_a_smooth_ripple_is_no_modes() -> None:
    found = drawn(rippled, range(1000, 1004))
    assert (found.missed, found.spurious) == (0, 0)
    assert found.covered() > 0.75


def test_pairs_nearer_than_two_lines_are_told_apart_where_they_are_wide() -> None:
    found = drawn(pairs, range(1000, 1005))
    assert (found.missed, found.spurious) == (0, 0)


@pytest.mark.slow
@pytest.mark.parametrize(("make", "spurious", "covered"), [(shared_noise, 0.05, 0.92), (rippled, 0.1, 0.85)])
def test_errors_that_lines_share_over_40_draws(
    make: Callable[[np.random.Generator], SyntheticFrf], spurious: float, covered: float
) -> None:
    found = drawn(make, range(1000, 1040))
    assert found.missed == 0
    assert found.spurious <= spurious * 40
    assert found.covered() >= covered


@pytest.mark.slow
def test_forty_modes_that_overlap() -> None:
    found = drawn(crowded, range(1000, 1008))
    assert found.missed <= 0.12 * 320
    assert found.spurious <= 0.5 * 8


@pytest.mark.parametrize("lines", [1, 5])
def test_correlation_of_averaged_noise(lines: int) -> None:
    """A running mean over n lines has a triangular autocorrelation: 1 + 2 sum (1 - k/n) = n."""
    rng = np.random.default_rng(2)
    drawn = rng.normal(size=(1, 20000)) + 1j * rng.normal(size=(1, 20000))
    mean = np.array([np.convolve(row, np.full(lines, 1.0 / lines), "valid") for row in drawn])
    assert correlation(mean, 20.0) == pytest.approx(lines, rel=0.08)


def test_what_a_resonance_leaves_over_does_not_spread_over_the_lines_beside_it() -> None:
    """One line is wrong by half the peak: twenty half widths away the weights are as before."""
    rng = np.random.default_rng(0)
    f = np.arange(100.0, 300.0, 0.25)
    model = (1.0 / (2j * np.pi * (f - 200.0) + 2 * np.pi * 0.5))[None]
    left = 1e-4 * (rng.normal(size=model.shape) + 1j * rng.normal(size=model.shape))
    before = deviation_from_residual(left, model + left)
    peak = int(np.argmin(np.abs(f - 200.0)))
    left[0, peak] = 0.5 * model[0, peak]
    after = deviation_from_residual(left, model + left)
    assert (after / before)[0, peak - 40] < 0.2 * after[0, peak] / before[0, peak]
    assert (after[0] <= np.sqrt(1.5) * before[0] * 1.6 + np.abs(model[0])).all()


def test_the_one_peak_of_a_badly_measured_frf_stays() -> None:
    """Coherence 0.1 to 0.5 on its peak: the place is known, the damping is not, and the mode must not be lost."""
    with np.load(CASE_2) as stored:
        frequency, h = stored["frequency"], stored["h"]
    modes = identify(Measured(frequency, h[None]), Settings(terms=EVERY_CHOICE))
    assert modes.reading("viscous").frequency_hz[modes.real] == pytest.approx([192.6], abs=0.3)


@pytest.mark.parametrize("mains", [50.0, 60.0])
@pytest.mark.parametrize("hum", [59.75, 180.2, 150.3])
def test_a_needle_of_the_mains_is_no_mode_whichever_mains_are_given(mains: float, hum: float) -> None:
    rng = np.random.default_rng(5)
    f = np.arange(40.0, 400.0, 0.25)
    poles = 2 * np.pi * np.array([110.0, 290.0]) * (-0.02 + 1j)
    h = (1.0 / (2j * np.pi * f - poles[:, None])).sum(0)
    h = h + 0.01 * np.abs(h).mean() * (rng.normal(size=len(f)) + 1j * rng.normal(size=len(f)))
    h = h + 0.05 * np.abs(h).max() / (1.0 + 1j * (f - hum) / 0.1)
    modes = identify(Measured(f, h[None]), Settings(mains=mains))
    assert modes.reading().frequency_hz[modes.real] == pytest.approx([110.0, 290.0], rel=1e-2)


def test_a_tone_on_one_line_is_left_out_and_a_narrow_resonance_is_not() -> None:
    f = np.arange(100.0, 200.0, 0.5)
    for place in (150.0, 150.2):
        h = 1.0 / (2j * np.pi * (f - place) + 2 * np.pi * 0.1)
        assert not tones(h[None]).any()
    h = 1.0 / (2j * np.pi * (f - 150.0) + 2 * np.pi * 5.0)
    h[37] += 20 * np.abs(h).max()
    np.testing.assert_array_equal(np.flatnonzero(tones(h[None])), [37])


def test_a_weak_mode_above_the_noise_is_a_mode() -> None:
    """Its peak is 0.7 % of the response it stands in, twenty times the noise of its lines."""
    rng = np.random.default_rng(0)
    f = np.arange(100.0, 400.0, 0.25)
    poles = 2 * np.pi * np.array([180.0, 260.0]) * (-0.02 + 1j)
    none = np.zeros((1, 0), complex)
    tall = synthesis(f, poles[:1], np.array([[-1j]]), NONE, none)[0]
    at = np.abs(tall[np.argmin(np.abs(f - 260.0))])
    h = tall + synthesis(f, poles[1:], np.array([[0.007j * at * poles[1].real]]), NONE, none)[0]
    h = h + 3e-4 * at * (rng.normal(size=len(f)) + 1j * rng.normal(size=len(f)))
    modes = identify(Measured(f, h[None]))
    assert modes.reading().frequency_hz[modes.real] == pytest.approx([180.0, 260.0], rel=3e-3)


def test_what_the_data_do_not_determine_has_no_small_variance() -> None:
    """Two parameters of which only the sum shows: a variance of either without end, not of half a unit."""
    f = np.arange(90.0, 110.0, 0.1)
    pole = 2 * np.pi * 100.0 * (-0.01 + 1j)
    h = (1.0 / (2j * np.pi * f - pole))[None]
    lines = Lines(f, h, np.full(h.shape, 1e-3 * np.abs(h).max()))
    found = fit(lines, np.array([pole]), NONE, max_iterations=0)
    found = replace(found, projection=replace(found.projection, hessian=np.ones((2, 2)), misfit=1.0))
    assert np.diag(covariance(found, lines)).min() > 1e6


def test_the_sharper_the_count_of_lines_the_wider_the_intervals() -> None:
    """R10 with lines counted as correlated: standard deviations as the root of it."""
    case = r10(np.random.default_rng(1))
    plain = Lines(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation))
    counted = Lines(plain.frequency, plain.h, plain.deviation, correlation=4.0)
    found = fit(plain, case.poles, NONE, max_iterations=0)
    ratio = np.sqrt(np.diag(covariance(found, counted)) / np.diag(covariance(found, plain)))
    np.testing.assert_allclose(ratio, 2.0, rtol=0.03)
