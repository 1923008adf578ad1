"""Who hides what: fixed by the seed, kinds in their shares all along, calibration and trial strangers."""

import numpy as np

from app.blind_trial.assignments import KINDS, SHARES, Assignment, assignments, shuffled
from app.blind_trial.draw_effects import SIZES, wanted_size
from app.blind_trial.making import ways
from simulation.effects.library import LIBRARY


def test_every_stretch_holds_the_kinds_in_their_shares():
    dealt = assignments(200, KINDS)
    assert [a.number for a in dealt] == list(range(200))
    for kind, share in SHARES.items():
        for count in (20, 60, 200):
            here = sum(a.kind == kind for a in dealt[:count])
            assert abs(here - count * share / 20) <= 1.0
        assert [a.ordinal for a in dealt if a.kind == kind] == list(range(sum(a.kind == kind for a in dealt)))


def test_only_the_kinds_asked_for():
    assert {a.kind for a in assignments(9, ("pair", "null"))} == {"pair", "null"}


def test_random_numbers_follow_from_seed_stream_and_number():
    draws = {
        (stream, seed, number): float(Assignment(number, "null", 0).rng(stream, seed).random())
        for stream in ("trial", "calibration")
        for seed in (0, 1)
        for number in (0, 1)
    }
    assert len(set(draws.values())) == len(draws)
    assert draws["trial", 1, 0] == Assignment(0, "single", 5).rng("trial", 1).random()


def test_as_many_campaigns_as_effects_hide_every_effect_once():
    names = tuple(LIBRARY)
    count = len(names)
    for turn in (0, 1):
        dealt = [shuffled(names, "trial", 3, count * turn + k, 1) for k in range(count)]
        assert sorted(dealt) == sorted(names)
    assert [shuffled(names, "trial", 3, k, 1) for k in range(count)] != [
        shuffled(names, "trial", 4, k, 1) for k in range(count)
    ]


def test_three_rounds_give_every_effect_every_size():
    rng = np.random.default_rng(0)
    names = tuple(LIBRARY)
    met: dict[str, list[float]] = {name: [] for name in names}
    for ordinal in range(3 * len(names)):
        name = shuffled(names, "trial", 5, ordinal, 1)
        met[name].append(wanted_size(Assignment(0, "single", ordinal), name, rng))
    for sizes in met.values():
        assert sorted(sizes)[:2] == list(SIZES[:2])
        assert SIZES[2] <= max(sizes) <= 8.0 * SIZES[2]


def test_effects_get_a_protocol_that_shows_them():
    rng = np.random.default_rng(1)
    for _ in range(20):
        for name in ("thermal_lag", "annealing", "depolarization"):
            assert ways((name,), rng)[0] == ("up", "down")
        for name in ("amplitude_softening", "piezo_nonlinearity"):
            assert len(ways((name,), rng)[1]) == 2
    assert {ways((), rng)[0] for _ in range(40)} == {("up",), ("up", "down")}
