"""What is hidden in a specimen, against plates that can be computed otherwise."""

import numpy as np
import pytest

from analysis.recordings.sweep_point import SweepPoint
from app.blind_trial.specimen import Specimen
from app.files.declarations.experiment import AcquiredExperiment
from simulation.reduction.effect_operators import EffectOperators

LINES = np.linspace(100.0, 250.0, 301)
POINT = SweepPoint(20.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def specimen(experiment: AcquiredExperiment, operators: EffectOperators) -> Specimen:
    return Specimen.of([experiment], operators)


def off(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


def test_a_resonator_far_above_the_band_is_a_mass(specimen: Specimen):
    """At 30 times the frequency the spring gives way by a thousandth."""
    place = {"x": 0.1, "y": 0.08}
    mass = specimen.transfer({"mass_at_place": {"mass": 0.004, **place}})(POINT, LINES)
    high = {"mass": 0.004, "resonance": 7500.0, "loss": 0.03, **place}
    assert off(specimen.transfer({})(POINT, LINES), mass) > 0.1
    assert off(specimen.transfer({"resonator_at_place": high})(POINT, LINES), mass) < 3e-3


def test_a_resonator_far_below_the_band_is_a_spring(specimen: Specimen):
    """Its mass stays at rest, and the plate feels the spring, lossy as it is."""
    place = {"x": 0.1, "y": 0.08}
    stiffness = 4.0 * (2.0 * np.pi * 5.0) ** 2
    spring = specimen.transfer({"spring_at_place": {"stiffness": stiffness, "loss": 0.03, **place}})(POINT, LINES)
    low = {"mass": 4.0, "resonance": 5.0, "loss": 0.03, **place}
    assert off(specimen.transfer({})(POINT, LINES), spring) > 0.1
    assert off(specimen.transfer({"resonator_at_place": low})(POINT, LINES), spring) < 0.02


def test_a_filter_that_rings_leaves_low_lines_alone(specimen: Specimen):
    bare = specimen.transfer({})(POINT, LINES)
    rung = specimen.transfer({"filter_ripple": {"height": 0.2, "corner": 240.0}})(POINT, LINES)
    ratio = np.abs(rung / bare)[0]
    assert ratio[np.searchsorted(LINES, 240.0)] == pytest.approx(1.2, rel=1e-6)
    assert abs(ratio[0] - 1.0) < 0.01


FOLLOW = {
    "thermal_lag": {"rate"},
    "annealing": {"rate"},
    "depolarization": {"rate"},
    "amplitude_softening": {"level"},
    "piezo_nonlinearity": {"level"},
}


@pytest.mark.parametrize(("name", "wanted"), FOLLOW.items())
def test_few_effects_follow_more_than_the_temperature(specimen: Specimen, name: str, wanted: set[str]):
    """The transfer says so, and the others keep to it."""
    assert specimen.transfer({name: {}}).follows == wanted
    others = set(specimen.cards) - set(FOLLOW)
    here, there = POINT, SweepPoint(20.0, 0.02, 2.0)
    for other in sorted(others):
        values = {p.name: 0.3 * p.high if not p.shape else p.typical for p in specimen.cards[other].parameters}
        transfer = specimen.transfer({other: values})
        assert not transfer.follows
        np.testing.assert_array_equal(transfer(here, LINES[:3]), transfer(there, LINES[:3]))
