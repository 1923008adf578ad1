from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.experiment import Protocol
from analysis.gap.data.preparation import sweep_points
from analysis.identification.automatic import identify_by_peaks
from analysis.identification.over_temperature.stated_temperature import at_stated_temperature
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.over_temperature.tracking import track
from analysis.identification.pole_residue import to_parameters
from analysis.recordings.frf import Frf
from analysis.recordings.h1 import repeat_shift
from tests.sweeps_on_a_ramp import PROTOCOL, drifting, modes_at, on_a_ramp


def errors(tracked: TrackedModes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors (2, N) of frequencies, as shares, and of loss factors, in band; the same over their deviations."""
    f, eta = modes_at(tracked.temperature)
    read, error, sigma = tracked.reading(), [], []
    for t, j in np.argwhere(f > 115.0):
        n = int(np.nanargmin(np.abs(read.frequency_hz[t] - f[t, j])))
        error.append((read.frequency_hz[t, n] / f[t, j] - 1.0, read.loss_factor[t, n] - eta[t, 0]))
        sigma.append((read.sigma_frequency_hz[t, n] / f[t, j], read.sigma_loss_factor[t, n]))
    return np.array(error).T, np.array(error).T / np.array(sigma).T


def rms(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.sqrt(np.mean(values**2, axis=-1)))


def corrected(frf: Frf, **changes: Any) -> tuple[TrackedModes, TrackedModes]:
    """Modes as fitted, and at the stated temperatures."""
    seen = track(frf)
    return seen, at_stated_temperature(seen, sweep_points(frf, PROTOCOL.model_copy(update=changes)))


@pytest.mark.parametrize("noise", [1e-3, 0.03])
@pytest.mark.parametrize(
    "changes",
    [{}, {"sweep": "linear"}, {"directions": ("up", "down")}, {"temperatures": (0.0, 15.0, 30.0, 45.0, 60.0)}],
)
def test_modes_are_those_at_the_stated_temperature(changes: dict[str, Any], noise: float) -> None:
    frf = on_a_ramp(PROTOCOL.model_copy(update=changes), noise)
    seen, stated = corrected(frf, **changes)
    (error, standard), (before, many) = errors(stated), errors(seen)
    assert many[0].std() > 5.0
    assert (rms(standard) < 1.4).all()
    assert rms(error)[0] < 0.25 * rms(before)[0]


def test_the_stretch_of_resonances_is_taken_out_of_the_damping() -> None:
    seen, stated = corrected(on_a_ramp(noise=1e-4))
    assert rms(errors(stated)[0])[1] < 0.1 * rms(errors(seen)[0])[1]


def over_repeats(frf: Frf, protocol: Protocol) -> tuple[Frf, NDArray[np.float64]]:
    """FRFs of the mean over four repeats on the ramp, and by how much frequencies move over them, (T,)."""
    points = sweep_points(frf, protocol)
    away = protocol.ramp_rate / 60.0 * protocol.record * np.array([-1.5, -0.5, 0.5, 1.5])
    every = np.array([drifting(frf, [replace(p, temperature=p.temperature + a) for p in points]) for a in away])
    # every sweep's repeats as ratios (K, R, F) on lines from 100 Hz
    shift = np.array([repeat_shift(every[:, t].swapaxes(0, 1), 100) for t in range(len(points))])
    return replace(frf, h=frf.h + every.mean(axis=0) - drifting(frf, points)), shift


def test_the_mean_over_repeats_does_not_look_like_damping() -> None:
    frf, shift = over_repeats(on_a_ramp(noise=1e-4), PROTOCOL)
    points, seen = sweep_points(frf, PROTOCOL), track(frf)
    plain, stated = (at_stated_temperature(seen, points, known) for known in (None, shift))
    before, after = (float(errors(one)[0][1].mean()) for one in (plain, stated))
    assert before > 3e-4
    assert abs(after) < 0.4 * before
    assert rms(errors(stated)[1])[1] < 1.4 < rms(errors(plain)[1])[1]


def test_the_movement_over_repeats_is_that_of_the_modes() -> None:
    """Their slopes at 30 degrees times the temperatures' standard deviation, 0.41 K."""
    frf = on_a_ramp()
    _, shift = over_repeats(frf, PROTOCOL)
    near, sigma = frf.temperature[6] + np.array([-0.01, 0.01]), PROTOCOL.model_copy(update={"repeats": 4}).spread
    slopes = np.log(modes_at(near[1:])[0] / modes_at(near[:1])[0])[0] / 0.02
    assert sigma == pytest.approx(0.41, abs=0.001)
    assert np.abs(slopes * sigma).min() < shift[6] < np.abs(slopes * sigma).max()


def test_damping_of_a_single_temperature_is_corrected_for_the_mean_over_repeats() -> None:
    """It takes no slope."""
    frf, shift = over_repeats(on_a_ramp(noise=1e-4), PROTOCOL)
    alone = replace(
        frf,
        temperature=frf.temperature[:1],
        direction=("up",),
        level=frf.level[:1],
        h=frf.h[:1],
        variance=frf.variance[:1],
        coherence=frf.coherence[:1],
    )
    seen = track(alone)
    (modes,) = at_stated_temperature(seen, sweep_points(alone, PROTOCOL), shift[:1]).modes
    place, stated = (to_parameters(poles)[:, 1] for poles in (modes.poles, modes.stated_poles))
    np.testing.assert_allclose(place - stated, np.log1p((shift[0] / np.exp(place)) ** 2), rtol=1e-9)


def test_sweeps_identified_one_by_one_are_corrected_along_their_tracks() -> None:
    frf = on_a_ramp()
    stated = at_stated_temperature(track(frf, method=identify_by_peaks), sweep_points(frf, PROTOCOL))
    assert (rms(errors(stated)[1]) < 1.4).all()


def test_the_frfs_are_rebuilt_from_the_poles_as_fitted() -> None:
    frf = on_a_ramp()
    seen, stated = corrected(frf)
    np.testing.assert_array_equal(stated.synthesis(frf.frequency), seen.synthesis(frf.frequency))
    np.testing.assert_array_equal(stated.track, seen.track)


def test_a_mode_without_a_track_moves_as_the_others() -> None:
    frf = on_a_ramp()
    seen = track(frf)
    fewer = at_stated_temperature(replace(seen, track=seen.track[:, :-1]), sweep_points(frf, PROTOCOL))
    true, _ = modes_at(frf.temperature)
    for t, modes in enumerate(fewer.modes):
        read, n = modes.reading(), int(seen.track[t, -1])
        error = read.frequency_hz[n] / true[t, -1] - 1.0
        assert abs(error) < 1e-4 < abs(seen.modes[t].reading().frequency_hz[n] / true[t, -1] - 1.0)
        assert abs(error) < 3.0 * read.sigma_frequency_hz[n] / true[t, -1]


@pytest.mark.parametrize("changes", [{"taper": None}, {"ramp_rate": 0.0}])
def test_without_a_known_drift_modes_stay_as_they_are(changes: dict[str, Any]) -> None:
    seen, stated = corrected(on_a_ramp(), **changes)
    assert all(modes.corrected is None for modes in stated.modes)
    assert stated.notes == seen.notes


def test_one_temperature_is_left_with_a_note_if_noise_does_not_hide_it() -> None:
    one = {"temperatures": (30.0,)}
    frf = on_a_ramp(PROTOCOL.model_copy(update=one))
    seen, stated = corrected(frf, **one)
    (note,) = stated.notes
    assert stated.modes == seen.modes
    (point,) = sweep_points(frf, PROTOCOL)
    away = np.abs(point.drift(modes_at(frf.temperature)[0][0])).max()
    assert note.startswith("one temperature on the way up: ")
    assert f"up to {away:.2g} K off ({away:.2g} % of those of a soft polymer)" in note
    assert corrected(on_a_ramp(PROTOCOL.model_copy(update=one), noise=0.5), **one)[1].notes == ()
