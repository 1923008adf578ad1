from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.identification.automatic import identify_by_peaks
from analysis.identification.lines import Lines
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.over_temperature.tracking import track
from analysis.identification.over_temperature.tracks_without_twin import MOST_DAMPED, Followed, common_factor
from analysis.identification.pole_residue import NONE, REAL_E, REAL_E_F, synthesis
from analysis.identification.settings import Settings
from analysis.recordings.frf import Frf

FREQUENCY = np.arange(100.0, 900.0, 0.5)
TEMPERATURE = np.arange(0.0, 61.0, 6.0)
AT_ZERO = np.array([170.0, 240.0, 310.0, 455.0, 560.0, 700.0])


def softening(temperature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the common factor of all frequencies: 1 at 0 °C, about 0.6 at 60 °C, as polypropylene has it."""
    return 1.0 - 0.4 / (1.0 + np.exp(-(temperature - 25.0) / 12.0)) + 0.4 / (1.0 + np.exp(25.0 / 12.0))


def loss(temperature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Loss factor with its peak at the transition."""
    return 0.035 + 0.045 * np.exp(-(((temperature - 18.0) / 18.0) ** 2))


def poles_at(temperature: float, drift: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Hysteretic poles; `drift` is each mode's own change of log frequency over 60 K."""
    t = np.array([temperature])
    f = AT_ZERO * softening(t)[0] * np.exp(drift * temperature / 60.0)
    return 2j * np.pi * f * np.sqrt(1 + 1j * loss(t)[0])


def campaign(
    residues: NDArray[np.complex128],
    drift: NDArray[np.float64] | None = None,
    temperature: NDArray[np.float64] = TEMPERATURE,
    seed: int = 0,
    noise: float = 0.01,
) -> Frf:
    """FRFs (T, K, F) of six modes with noise, a share of their rms."""
    rng = np.random.default_rng(seed)
    drift = np.zeros(6) if drift is None else drift
    none = np.zeros((len(residues), 0), complex)
    clean = np.array([synthesis(FREQUENCY, poles_at(t, drift), residues, NONE, none) for t in temperature])
    deviation = noise * np.sqrt(np.mean(np.abs(clean) ** 2, axis=2, keepdims=True))
    draw = rng.normal(size=clean.shape) + 1j * rng.normal(size=clean.shape)
    return Frf(
        temperature=temperature,
        direction=("up",) * len(temperature),
        level=np.ones(len(temperature)),
        frequency=FREQUENCY,
        h=clean + deviation / np.sqrt(2) * draw,
        variance=np.broadcast_to(deviation**2, clean.shape).copy(),
        coherence=np.ones(clean.shape),
        excluded=np.zeros(len(FREQUENCY), bool),
        channels=tuple(f"S{k}" for k in range(len(residues))),
    )


ONE = 1j * np.array([[100.0, -120, 150, 130, -160, 200]])


def column_of(tracked: TrackedModes, t: int, f: float) -> int:
    return int(np.nanargmin(np.abs(tracked.reading().frequency_hz[t] - f)))


def test_every_mode_is_one_track_over_the_whole_transition() -> None:
    """A 40 % fall, damping that more than doubles, no start value: six tracks, each within its deviations."""
    tracked = track(campaign(ONE))
    read = tracked.reading()
    truth = AT_ZERO * softening(TEMPERATURE)[:, None]
    assert tracked.track.shape == (11, 6)
    in_band = truth > 103.0
    assert (tracked.track[in_band] >= 0).all()
    error = (read.frequency_hz - truth) / read.sigma_frequency_hz
    assert np.abs(error[in_band]).max() < 4.5
    eta = (read.loss_factor - loss(TEMPERATURE)[:, None]) / read.sigma_loss_factor
    assert np.abs(eta[in_band]).max() < 4.5
    assert tracked.notes == ()


def test_synthesis_rebuilds_the_measurement_down_to_its_noise() -> None:
    frf = campaign(ONE)
    left = frf.h - track(frf).synthesis(frf.frequency)
    chi_square = (np.abs(left) ** 2 / frf.variance).mean(axis=(1, 2))
    np.testing.assert_allclose(chi_square, 1.0, atol=0.12)


def test_a_mode_far_below_the_band_is_followed_where_noise_is_low() -> None:
    """It lies 15 to 21 % below the band, and its flank in the band is far above the noise."""
    frf = campaign(ONE, temperature=np.array([0.0, 5.0, 10.0, 15.0]), noise=1e-3)
    band = frf.frequency >= 200.0
    frf = replace(
        frf,
        frequency=frf.frequency[band],
        excluded=frf.excluded[band],
        **{name: getattr(frf, name)[..., band] for name in ("h", "variance", "coherence")},
    )
    tracked = track(frf)
    assert tracked.notes == ()
    left = frf.h - tracked.synthesis(frf.frequency)
    np.testing.assert_allclose((np.abs(left) ** 2 / frf.variance).mean(axis=(1, 2)), 1.0, atol=0.15)


def test_two_modes_that_cross_keep_their_names_by_their_shapes() -> None:
    """Modes 3 and 4 change places at about 40 °C; two sensors see them with different shapes."""
    residues = 1j * np.array([[100.0, -120, 150, 130, -160, 200], [80.0, 90, -150, 130, 100, -90]])
    drift = np.array([0, 0, 0.31, -0.27, 0, 0])
    tracked = track(campaign(residues, drift))
    third, fourth = column_of(tracked, 0, 310.0), column_of(tracked, 0, 455.0)
    f = np.abs([poles_at(60.0, drift)[j] for j in (2, 3)]) / (2 * np.pi)
    assert f[0] > f[1]
    assert tracked.reading().frequency_hz[-1, third] == pytest.approx(f[0], rel=5e-3)
    assert tracked.reading().frequency_hz[-1, fourth] == pytest.approx(f[1], rel=5e-3)


def test_a_mode_that_enters_the_band_is_born_and_one_that_fades_dies() -> None:
    """Mode 1 leaves through the lower edge as the plate softens; seen from 60 °C it is born."""
    tracked = track(campaign(ONE))
    lowest = column_of(tracked, 0, 170.0)
    f = AT_ZERO[0] * softening(TEMPERATURE)
    shown = tracked.track[:, lowest] >= 0
    assert shown[f > 103.0].all()
    assert not shown[f < 97.0].any()


def test_down_leg_and_second_level_join_the_same_tracks() -> None:
    frf = campaign(ONE, temperature=np.array([20.0, 30.0, 40.0, 30.2, 20.1]))
    frf = replace(frf, direction=("up", "up", "up", "down", "down"))
    tracked = track(frf)
    assert tracked.track.shape[1] == 6
    shown = tracked.reading().frequency_hz
    np.testing.assert_allclose(shown[4], shown[0], rtol=2e-3)


def test_a_jump_that_the_scan_cannot_follow_is_identified_afresh() -> None:
    frf = campaign(ONE, temperature=np.array([0.0, 3.0, 60.0]))
    tracked = track(frf)
    truth = AT_ZERO * softening(np.array([60.0]))
    read = tracked.modes[2].reading()
    for f in truth[truth > 105.0]:
        assert np.abs(read.frequency_hz[tracked.modes[2].real] / f - 1).min() < 2e-3


def test_a_spoilt_sweep_is_reported_not_hidden() -> None:
    frf = campaign(ONE)
    h = frf.h.copy()
    beat = np.exp(1j * np.linspace(0.0, 2500.0, len(FREQUENCY)))
    h[5] += 0.2 * np.sqrt(np.mean(np.abs(h[5]) ** 2)) * beat  # an echo: no pole explains it
    tracked = track(replace(frf, h=h))
    assert len(tracked.notes) == 1
    assert "30.0 °C" in tracked.notes[0]
    assert "its modes are not reliable" in tracked.notes[0]
    assert (tracked.track[[4, 6]] >= 0).sum() >= 10


def test_excluded_lines_have_no_influence() -> None:
    frf = campaign(ONE, temperature=np.array([20.0, 24.0]))
    excluded = np.abs(FREQUENCY - 50.0 * np.round(FREQUENCY / 50.0)) < 0.6
    h = np.where(excluded, 1e6, frf.h)
    plain = track(replace(frf, excluded=excluded))
    spoilt = track(replace(frf, excluded=excluded, h=h))
    np.testing.assert_array_equal(spoilt.poles, plain.poles)


def test_the_papers_recipe_can_be_followed_too() -> None:
    frf = campaign(ONE, temperature=np.array([50.0, 55.0, 60.0]))
    tracked = track(frf, Settings(), method=identify_by_peaks)
    column = column_of(tracked, 0, AT_ZERO[4] * softening(np.array([50.0]))[0])
    assert (tracked.track[:, column] >= 0).all()


@pytest.mark.parametrize("factor", [0.78, 0.97, 1.005, 1.3])
def test_common_factor_is_found_by_the_scan(factor: float) -> None:
    rng = np.random.default_rng(0)
    h = synthesis(FREQUENCY, poles_at(0.0, np.zeros(6)), ONE, REAL_E, np.array([[0.01 + 0j]]))
    h = h + 0.01 * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
    lines = Lines(FREQUENCY, h, np.full(h.shape, 0.01))
    found, at_edge = common_factor(lines, poles_at(0.0, np.zeros(6)) / factor, REAL_E_F)
    assert not at_edge
    assert found == pytest.approx(factor, rel=3e-3)


def test_sweeps_from_warm_to_cold_give_the_same_tracks() -> None:
    frf = campaign(ONE)
    back = replace(
        frf, temperature=frf.temperature[::-1], h=frf.h[::-1], variance=frf.variance[::-1], coherence=frf.coherence
    )
    plain, turned = track(frf).reading(), track(back).reading()
    np.testing.assert_allclose(turned.frequency_hz[::-1], plain.frequency_hz, rtol=1e-5)
    np.testing.assert_allclose(turned.sigma_frequency_hz[::-1], plain.sigma_frequency_hz, rtol=1e-2)


def test_tracks_do_not_depend_on_the_end_one_begins_at() -> None:
    """Mode 1 is in band at the cold end alone, modes of 3 % loss factor at the hot end."""
    frf = campaign(ONE)
    cold, hot = (track(frf, start=start) for start in (0, len(TEMPERATURE) - 1))
    assert cold.start == hot.start
    np.testing.assert_array_equal(hot.poles, cold.poles)
    np.testing.assert_array_equal(hot.covariance, cold.covariance)


@pytest.mark.parametrize("start", [-1, 2])
def test_a_start_that_is_no_sweep_is_refused(start: int) -> None:
    with pytest.raises(ValueError, match=f"start is sweep {start}; allowed 0 to 1"):
        track(campaign(ONE, temperature=np.array([0.0, 6.0])), start=start)


def noise_of(frf: Frf, seed: int) -> NDArray[np.complex128]:
    rng = np.random.default_rng(seed)
    return np.asarray(
        np.sqrt(frf.variance / 2) * (rng.normal(size=frf.h.shape) + 1j * rng.normal(size=frf.h.shape))
    )


def test_a_line_left_out_of_the_first_sweep_stays_out_of_the_fit_of_all() -> None:
    frf = campaign(ONE, temperature=np.array([0.0, 6.0]))
    h = frf.h.copy()
    h[:, :, 503] += 50.0 * np.abs(h).max()
    tracked = track(replace(frf, h=h))
    first = tracked.modes[tracked.start]
    np.testing.assert_array_equal(np.flatnonzero(first.left_out(FREQUENCY)), [503])
    assert first.lines == len(FREQUENCY) - 1


def test_sweeps_of_noise_alone_show_no_mode() -> None:
    frf = campaign(ONE, temperature=np.array([20.0, 30.0, 40.0]))
    tracked = track(replace(frf, h=noise_of(frf, 1)))
    assert tracked.track.shape == (3, 0)
    assert not any(modes.real.any() for modes in tracked.modes)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 6))])
def test_a_sweep_that_shares_no_mode_with_the_others_leaves_them_theirs(seed: int) -> None:
    """Its frequencies lie 150 Hz off, so it is identified by itself."""
    frf = campaign(ONE, temperature=np.array([20.0, 30.0, 40.0, 50.0]), seed=seed)
    h = frf.h.copy()
    h[2] = np.roll(h[2], -300, axis=1)
    tracked = track(replace(frf, h=h))
    assert tracked.notes[0].startswith("40.0 °C (sweep 2): fitted with the other sweeps")
    assert (tracked.track[2] < 0).all()
    assert (tracked.track[[0, 1, 3]] >= 0).all(axis=0).sum() >= 6
    own = tracked.modes[2].poles[tracked.modes[2].real].imag / (2 * np.pi)
    moved = AT_ZERO * softening(TEMPERATURE[:1] + 40.0) - 150.0
    assert np.abs(own - moved[moved > 105.0][:, None]).min(axis=1) == pytest.approx(0.0, abs=0.5)
    read = tracked.reading()
    for t in (0, 1, 3):
        truth = AT_ZERO * softening(TEMPERATURE[:1] + tracked.temperature[t])
        half_width = 0.5 * loss(TEMPERATURE[:1] + tracked.temperature[t])[0]
        for f in truth[truth > 105.0]:
            n = np.nanargmin(np.abs(read.frequency_hz[t] - f))
            deviation = read.sigma_frequency_hz[t, n]
            assert abs(read.frequency_hz[t, n] - f) < 4.0 * deviation
            assert deviation < 0.05 * half_width * f


def test_deviations_hold_what_the_stated_noise_does_not() -> None:
    """FRFs whose variance is stated a ninth of what it is: errors stay within what the misfit tells."""
    away = []
    for seed in range(2):
        frf = campaign(ONE, temperature=np.array([0.0, 12.0, 24.0, 36.0, 48.0, 60.0]), seed=seed)
        read = track(replace(frf, variance=frf.variance / 9.0)).reading()
        truth = AT_ZERO * softening(frf.temperature)[:, None]
        for t, f in zip(*np.nonzero(truth > 110.0), strict=True):
            j = int(np.nanargmin(np.abs(read.frequency_hz[t] - truth[t, f])))
            away.append((read.frequency_hz[t, j] - truth[t, f]) / read.sigma_frequency_hz[t, j])
    assert np.mean(np.abs(away) < 1.96) > 0.85
    assert 0.7 < np.std(away) < 1.4


def test_background_that_a_sweep_lacks_stays_a_pole_where_damping_rises() -> None:
    """One sweep found it with a damping ratio of 0.45; at the next all modes are damped three times as much."""
    place = np.log(
        np.array([[[600.0, 0.02], [900.0, 0.02], [1200.0, 0.45]], [[580.0, 0.06], [870.0, 0.06], [1, 1]]])
    )
    place[1, 2] = np.nan
    known = Followed(np.array([20.0, 30.0]), NONE, place, np.array([True, True, False]), [0, 1])
    assert np.exp(known.filled(1)[2, 1]) <= MOST_DAMPED
    np.testing.assert_allclose(known.filled(1)[:2], place[1, :2])
