"""No fit: a large misfit and modes that do not pair, both; never one of them alone."""

import numpy as np
import pytest

from analysis.pairing.assignment import ModeList, ModePairs, PairedSweeps, Pairing, pair_modes

F = np.array([100.0, 200.0, 330.0, 500.0, 720.0])


def pairs(matching: int, temperature: float = 20.0, strength: float = 80.0) -> ModePairs:
    """Five strong modes, some of which the twin has; the others have the wrong sign there."""
    ones = np.ones(5)
    sign = np.where(np.arange(5) < matching, 1.0, -1.0)
    lists = [
        ModeList(F, ones, 0.02 * ones, 1e-3 * ones, (strength * s)[None] + 0j, ones > 0) for s in (ones, sign)
    ]
    return pair_modes(temperature, (50.0, 1000.0), *lists)


def sweeps(matching: int, misfit: float, noise: float = 0.01, **changes: float) -> PairedSweeps:
    return PairedSweeps((pairs(matching, **changes),), np.array([misfit]), np.array([noise]), "identified")


@pytest.mark.parametrize(
    ("matching", "misfit", "noise", "fits"),
    [
        (5, 0.01, 0.01, True),
        (1, 0.3, 0.01, True),  # the misfit is that of an effect
        (5, 0.95, 0.01, True),  # sharp resonances, each a little elsewhere
        (3, 0.95, 0.01, True),
        (2, 0.95, 0.01, False),
        (0, 0.8, 0.5, True),  # noise
    ],
)
def test_both_must_fail(matching: int, misfit: float, noise: float, fits: bool) -> None:
    assert sweeps(matching, misfit, noise).fits == fits


def test_without_strong_modes_a_large_misfit_is_no_fit() -> None:
    assert not sweeps(5, 0.9, strength=0.01).fits


def test_one_sweep_that_fails_is_enough_and_is_shown() -> None:
    three = PairedSweeps(
        (pairs(5, 10.0), pairs(1, 30.0), pairs(5, 50.0)), np.array([0.01, 0.8, 0.9]), np.full(3, 0.01), "modes.h5"
    )
    assert three.failing.tolist() == [False, True, False]
    assert three.worst == 1
    said = Pairing(three).said
    assert said.startswith(
        "this is no fit: at 30.0 °C the twin misses 80 % of the response, and it has 1 of 5 strong"
    )


def test_effects_that_make_the_modes_pair_make_it_a_fit() -> None:
    bad, good = sweeps(0, 0.9), sweeps(5, 0.1)
    assert not Pairing(bad).fits
    assert not Pairing(bad, bad).fits
    assert Pairing(bad, good).fits
    assert Pairing(bad, good).said == ""


def test_misfit_and_noise_are_wanted_of_every_sweep() -> None:
    with pytest.raises(ValueError, match="of each of 1 sweeps"):
        PairedSweeps((pairs(5),), np.zeros(2), np.zeros(1), "identified")
