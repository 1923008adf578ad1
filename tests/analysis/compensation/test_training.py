from dataclasses import replace

import numpy as np
import pytest

from analysis.compensation.evidence_collapse import EvidenceCollapseError
from analysis.compensation.network import relative_error
from analysis.compensation.rivals import linear
from analysis.compensation.settings import Training
from analysis.compensation.training import left_out_networks, left_out_taps, split, train_networks
from analysis.focusing.fir import FirBank

WANTED = np.arange(0.0, 60.1, 0.25)


def test_networks_meet_filters_between_the_training_temperatures(thirteen, tones):
    trained = train_networks(thirteen, Training())
    error = relative_error(trained.networks.taps(WANTED), tones(WANTED))
    assert error.max() < 0.01
    assert error.max() < 0.1 * relative_error(linear(thirteen, WANTED), tones(WANTED)).max()
    assert trained.training_error.max() <= error.max()


@pytest.mark.parametrize("options", [{"scale": "tap"}, {"start": "random", "restarts": 3}, {"split": "matlab"}])
def test_every_option_trains(thirteen, tones, options):
    trained = train_networks(thirteen, Training(**options, seed=3))
    assert relative_error(trained.networks.taps(WANTED), tones(WANTED)).max() < 1.0


def test_the_scale_of_the_filters_does_not_matter(thirteen):
    louder = replace(thirteen, taps=1e6 * thirteen.taps)
    one, two = (train_networks(bank, Training(nodes=6)).networks.taps(WANTED) for bank in (thirteen, louder))
    np.testing.assert_allclose(1e6 * one, two, rtol=0, atol=1e-3 * np.abs(two).max())


def test_a_seed_gives_the_same_network_and_another_seed_another(thirteen):
    settings = Training(nodes=8, start="random", epochs=100)
    one, again, other = (train_networks(thirteen, replace(settings, seed=s)) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.networks.output, again.networks.output)
    assert not np.allclose(one.networks.output, other.networks.output)


def test_the_best_evidence_of_the_restarts_is_kept(thirteen):
    settings = Training(nodes=5, start="random", epochs=100)
    single = train_networks(thirteen, settings)
    several = train_networks(thirteen, replace(settings, restarts=5))
    assert np.all(several.log_evidence >= np.min(single.log_evidence))
    assert set(several.restart) <= set(range(5))


def test_a_tap_that_never_moves_is_learnt_as_a_constant(thirteen):
    taps = thirteen.taps.copy()
    taps[:, :, 7] = 4e-4
    trained = train_networks(replace(thirteen, taps=taps), Training(nodes=6, scale="tap"))
    np.testing.assert_allclose(trained.networks.taps(WANTED)[:, :, 7], 4e-4, rtol=1e-6)


@pytest.mark.parametrize("options", [{}, {"scale": "tap"}, {"start": "random", "restarts": 2}])
def test_filters_that_never_move_are_learnt_as_constants(thirteen, options):
    """Of a plate whose laws are the same at all temperatures: equal to the last digit."""
    still = replace(thirteen, taps=np.repeat(thirteen.taps[:1], 13, axis=0))
    settings = Training(nodes=6, **options)
    trained = train_networks(still, settings)
    wanted = np.broadcast_to(still.taps[0], trained.networks.taps(WANTED).shape)
    np.testing.assert_allclose(trained.networks.taps(WANTED), wanted, rtol=0, atol=1e-12)
    np.testing.assert_allclose(left_out_networks(still, trained, settings), still.taps[1:-1], rtol=0, atol=1e-12)


def test_matlab_s_split_leaves_two_of_thirteen_out_and_differs_between_networks(rng):
    used = split(40, 13, "matlab", rng)
    np.testing.assert_array_equal(used.sum(axis=1), 11.0)
    assert len(np.unique(used, axis=0)) > 20
    np.testing.assert_array_equal(split(3, 13, "none", rng), 1.0)


def test_too_few_temperatures_are_refused(thirteen):
    three = replace(thirteen, taps=thirteen.taps[::6], temperature=thirteen.temperature[::6])
    with pytest.raises(ValueError, match="3 training temperatures; at least 4 are needed"):
        train_networks(three, Training(nodes=2))


def test_more_nodes_than_temperatures_are_trained(thirteen):
    """The paper's 16 nodes on 13 temperatures: the evidence, not a count, keeps them from wriggling."""
    trained = train_networks(thirteen, Training(nodes=16))
    assert trained.training_error.max() < 1.0
    assert np.all(trained.gamma < 13 * thirteen.taps.shape[2])


def test_a_network_that_explains_filters_as_noise_is_refused(rng):
    """Filters without any order over temperature cannot be learnt by two nodes."""
    temperature = np.arange(0.0, 61.0, 5.0)
    noise = FirBank(rng.normal(size=(13, 2, 64)), temperature, 8_000.0, 16)
    with pytest.raises(EvidenceCollapseError, match="actuator 1: the best of 2 trainings"):
        train_networks(noise, Training(nodes=2, restarts=2))


@pytest.mark.parametrize("seed", range(4))
def test_networks_of_which_nothing_is_determined_are_refused_too(seed):
    """Four temperatures of noise: gamma rounds to zero, and with it alpha."""
    rng = np.random.default_rng(seed)
    noise = FirBank(rng.normal(size=(4, 2, 64)), np.linspace(0.0, 60.0, 4), 8_000.0, 16)
    with pytest.raises(EvidenceCollapseError, match="the evidence collapsed"):
        train_networks(noise, Training(nodes=2))


@pytest.mark.parametrize(
    "wrong",
    [
        {"nodes": 0},
        {"restarts": 0},
        {"epochs": 0},
        {"scale": "none"},
        {"feed": "pressure"},
        {"start": "cold"},
        {"split": 3},
        {"largest_error": 0.0},
    ],
)
def test_settings_that_cannot_be_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Training(**wrong)


def test_leave_one_out_of_straight_lines_is_exact_for_straight_filters():
    temperature = np.arange(0.0, 61.0, 10.0)
    taps = np.linspace(1.0, 2.0, 7)[:, None, None] * np.ones((1, 3, 8))
    bank = FirBank(taps, temperature, 8_000.0, 0)
    error = relative_error(left_out_taps(bank, linear), bank.taps[1:-1])
    assert error.shape == (5, 3)
    assert error.max() < 1e-25
    kinked = taps.copy()
    kinked[2] *= 1.1
    error = relative_error(left_out_taps(replace(bank, taps=kinked), linear), kinked[1:-1])
    true, found = 1.1 * taps[2, 0, 0], taps[2, 0, 0]
    assert error[1, 0] == pytest.approx(100 * (1 - found / true) ** 2)


def test_leave_one_out_of_networks_bounds_what_they_miss_in_between(thirteen, tones):
    trained = train_networks(thirteen, Training())
    left_out = relative_error(left_out_networks(thirteen, trained, Training()), thirteen.taps[1:-1])
    between = relative_error(trained.networks.taps(WANTED), tones(WANTED))
    assert left_out.shape == (11, 2)
    assert between.max() < left_out.max() < 1.0


@pytest.mark.parametrize("seed", [0, 1])
def test_more_parameters_than_errors_do_not_settle_on_constant_outputs(seed):
    """Ten nodes, eight temperatures, tones whose phase turns twice on the way: 1428 parameters, 1024 errors."""

    def turning(temperature):
        n, t = np.arange(2)[:, None], np.arange(128)
        pitch = (0.6 + 0.03 * n) * np.exp(-0.35 * temperature[:, None, None] / 60.0)
        return np.exp(-0.03 * t) * np.cos(pitch * t + 0.5 * n)

    eight = np.linspace(0.0, 60.0, 8)
    bank = FirBank(turning(eight), eight, 8_000.0, 64)
    trained = train_networks(bank, Training(seed=seed, epochs=200, largest_error=100.0))
    assert trained.training_error.max() < 0.05
    missed, straight = (
        relative_error(taps, turning(WANTED)).max()
        for taps in (trained.networks.taps(WANTED), linear(bank, WANTED))
    )
    assert missed < straight


def test_another_device_of_torch_gives_the_same_filters(thirteen):
    """`cpu:0` is the processor, by torch: the road that a GPU takes."""
    here = np.array([12.5, 33.0])
    settings = Training(nodes=6, epochs=60)
    one, other = (train_networks(thirteen, settings, device).networks.taps(here) for device in ("cpu", "cpu:0"))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-6 * np.abs(one).max())
