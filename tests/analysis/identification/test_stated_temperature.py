from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.frf import Frf
from analysis.gap.data.preparation import sweep_points
from analysis.identification.peak_picking import identify_by_peaks
from analysis.identification.stated_temperature import at_stated_temperature
from analysis.identification.tracked_modes import TrackedModes
from analysis.identification.tracking import track
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


def test_the_mean_over_repeats_does_not_look_like_damping() -> None:
    frf, protocol = on_a_ramp(noise=1e-4), PROTOCOL.model_copy(update={"repeats": 4})
    points = sweep_points(frf, protocol)
    away = protocol.ramp_rate / 60.0 * protocol.record * np.array([-1.5, -0.5, 0.5, 1.5])
    every = [drifting(frf, [replace(p, temperature=p.temperature + a) for p in points]) for a in away]
    seen = track(replace(frf, h=frf.h + np.mean(every, axis=0) - drifting(frf, points)))
    plain, stated = (at_stated_temperature(seen, points, spread) for spread in (0.0, protocol.spread))
    before, after = (float(errors(one)[0][1].mean()) for one in (plain, stated))
    assert before > 3e-4
    assert abs(after) < 0.4 * before
    assert rms(errors(stated)[1])[1] < 1.4 < rms(errors(plain)[1])[1]


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
