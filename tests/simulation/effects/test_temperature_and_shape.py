"""Effects on the fields over the plate, against the definitions of ``recorded-campaign/1`` by hand."""

import numpy as np
import pytest

from simulation.effects.library import LIBRARY

CORNERS = [(-1.0, -1.0), (1.0, 1.0), (1.0, -1.0)]


def at_corners(state, field):
    places = [np.flatnonzero((state.xi == xi) & (state.zeta == zeta))[0] for xi, zeta in CORNERS]
    return field[places]


def test_lag_leaves_the_plate_colder_on_the_way_up_and_warmer_on_the_way_down(trial):
    for rate, expected in ((0.4 / 60.0, 28.4), (-0.4 / 60.0, 31.6), (0.0, 30.0)):  # 240 s at 0.4 K/min: 1.6 K
        circumstances, state = trial(temperature=30.0, rate=rate)
        after = LIBRARY["thermal_lag"].apply(state, circumstances, {"tau": 240.0})
        np.testing.assert_allclose(after.temperature, expected, rtol=1e-14)


def test_lag_is_the_ovens_ramp_read_tau_earlier(trial):
    rate, tau, now = 0.02 / 3.0, 150.0, 4321.0

    def oven(time):
        return -5.0 + rate * time

    circumstances, state = trial(temperature=oven(now), rate=rate)
    after = LIBRARY["thermal_lag"].apply(state, circumstances, {"tau": tau})
    np.testing.assert_allclose(after.temperature, oven(now - tau), rtol=1e-13)


@pytest.mark.parametrize(("temperature", "share"), [(22.0, 0.0), (60.0, 1.0), (41.0, 0.5), (3.0, -0.5)])
def test_thermal_gradient_grows_with_the_distance_from_room_temperature(trial, temperature, share):
    circumstances, state = trial(temperature=temperature)
    after = LIBRARY["thermal_gradient"].apply(state, circumstances, {"gx": 2.0, "gy": 1.0})
    expected = temperature + share * np.array([-1.5, 1.5, 0.5])
    np.testing.assert_allclose(at_corners(state, after.temperature), expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("temperature", [0.0, 22.0, 60.0])
def test_a_draught_gradient_is_alike_at_every_temperature(trial, temperature):
    circumstances, state = trial(temperature=temperature)
    after = LIBRARY["draught_gradient"].apply(state, circumstances, {"gx": 2.0, "gy": 1.0})
    expected = temperature + np.array([-1.5, 1.5, 0.5])
    np.testing.assert_allclose(at_corners(state, after.temperature), expected, rtol=0.0, atol=1e-12)


def test_laws_follow_the_local_temperature(trial):
    circumstances, state = trial(temperature=30.0)
    after = LIBRARY["draught_gradient"].apply(state, circumstances, {"gx": 4.0, "gy": 0.0})
    cold, warm, _ = at_corners(state, state.laws.youngs_modulus(after.temperature))
    # log E = log 2e9 - 0.02 dT + 0.5e-4 dT**2 at dT = -2 and 2
    assert cold == pytest.approx(2e9 * np.exp(0.0402))
    assert warm == pytest.approx(2e9 * np.exp(-0.0398))


def test_taper_is_linear_about_the_centre(trial):
    circumstances, state = trial()
    after = LIBRARY["thickness_taper"].apply(state, circumstances, {"tx": 0.02, "ty": -0.05})
    np.testing.assert_allclose(at_corners(state, after.thickness), [1.03, 0.97, 1.07], rtol=1e-14)
    assert after.thickness[(state.xi == 0.0) & (state.zeta == 0.0)] == 1.0


def test_damage_is_one_disc_of_twelve_millimetres(trial):
    circumstances, state = trial()
    (disc,) = LIBRARY["local_damage"].apply(state, circumstances, {"loss": 0.3, "x": 0.1, "y": 0.07}).discs
    assert (disc.x, disc.y, disc.radius, disc.loss) == (0.1, 0.07, 0.012, 0.3)


def test_discs_of_the_search_touch_both_edges_and_leave_no_row_out(experiment):
    sites = LIBRARY["local_damage"].card(experiment).sites
    for shape, length in (("x", 0.24), ("y", 0.19)):
        places = np.unique([site[shape] for site in sites])
        np.testing.assert_allclose(places[[0, -1]], [0.012, length - 0.012])
        assert 0.020 < np.diff(places).min() <= np.diff(places).max() + 1e-12 < 0.028
    assert len(sites) == len({tuple(site.values()) for site in sites}) == 10 * 8


def mean(field, state):
    """Mean over the plate of a field with even powers up to the second, from three of its points."""
    centre = field[(state.xi == 0.0) & (state.zeta == 0.0)][0]
    return centre + (at_corners(state, field)[0] - centre) / 3.0


def test_crowns_keep_the_mean_and_fall_from_the_middle_to_the_edges(trial):
    circumstances, state = trial(temperature=60.0)
    thick = LIBRARY["thickness_crown"].apply(state, circumstances, {"cx": 0.03, "cy": -0.01}).thickness
    assert thick[1] - at_corners(state, thick)[0] == pytest.approx(0.03 - 0.01)
    assert mean(thick, state) == pytest.approx(1.0)
    warm = LIBRARY["thermal_crown"].apply(state, circumstances, {"gx": 2.0, "gy": 1.0}).temperature
    assert warm[1] - at_corners(state, warm)[0] == pytest.approx(3.0)
    assert mean(warm, state) == pytest.approx(60.0)


def test_a_thermal_crown_goes_with_the_heating(trial):
    circumstances, state = trial(temperature=41.0)  # half-way from 22 to 60
    warm = LIBRARY["thermal_crown"].apply(state, circumstances, {"gx": 2.0, "gy": 0.0}).temperature
    assert warm[1] - 41.0 == pytest.approx(0.5 * 2.0 / 3.0)


def test_gradients_of_density_and_modulus_are_linear_about_the_centre(trial):
    circumstances, state = trial()
    heavy = LIBRARY["density_gradient"].apply(state, circumstances, {"mx": 0.02, "my": -0.05})
    np.testing.assert_allclose(at_corners(state, heavy.density), [1.03, 0.97, 1.07], rtol=1e-14)
    stiff = LIBRARY["modulus_gradient"].apply(state, circumstances, {"ex": 0.02, "ey": -0.05})
    np.testing.assert_allclose(at_corners(state, stiff.modulus), [1.03, 0.97, 1.07], rtol=1e-14)
    np.testing.assert_array_equal(heavy.thickness, 1.0)
    np.testing.assert_array_equal(stiff.thickness, 1.0)
