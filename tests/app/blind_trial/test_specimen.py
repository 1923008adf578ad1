"""What is hidden in a specimen, against plates that can be computed otherwise."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.sweep_point import SweepPoint
from app.blind_trial.plates import PlateKind
from app.blind_trial.specimen import Specimen
from app.files.experiment_toml import AcquiredExperiment
from app.rig.plate_transfer import TwinTransfer
from simulation.effects.effect import Effect
from simulation.reduction.effect_operators import EffectOperators
from simulation.state.plate_state import Circumstances, PlateState, PointLoad

LINES = np.linspace(100.0, 250.0, 301)
POINT = SweepPoint(20.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def specimen(experiment: AcquiredExperiment, kind: PlateKind, operators: EffectOperators) -> Specimen:
    return Specimen.of([experiment], kind, operators)


def with_load(specimen: Specimen, **load: float) -> np.ndarray:
    """Transfer with a load at the hidden point, put there directly."""

    def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
        return state.with_(point_loads=(PointLoad(circumstances.cables[-1], **load),))

    effect = Effect(specimen.twin.library["hidden_spring"].card, apply)
    twin = replace(specimen.twin, library={"load": effect})
    return TwinTransfer(twin, specimen.laws, {"load": {}})(POINT, LINES)


def off(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


def test_a_resonator_far_above_the_band_is_a_mass(specimen: Specimen):
    """At 30 times the frequency the spring gives way by a thousandth."""
    mass = with_load(specimen, mass=0.004)
    resonator = specimen.transfer({"resonator": {"mass": 0.004, "resonance": 7500.0}})(POINT, LINES)
    assert off(specimen.transfer({})(POINT, LINES), mass) > 0.1
    assert off(resonator, mass) < 3e-3


def test_a_resonator_far_below_the_band_is_a_spring(specimen: Specimen):
    """Its mass stays at rest, and the plate feels the spring, lossy as it is."""
    stiffness = 4.0 * (2.0 * np.pi * 5.0) ** 2
    spring = with_load(specimen, stiffness=stiffness)
    resonator = specimen.transfer({"resonator": {"mass": 4.0, "resonance": 5.0}})(POINT, LINES)
    assert off(specimen.transfer({})(POINT, LINES), spring) > 0.1
    assert off(resonator, spring) < 0.02


def test_a_filter_that_rings_leaves_low_lines_alone(specimen: Specimen):
    bare = specimen.transfer({})(POINT, LINES)
    rung = specimen.transfer({"filter_ripple": {"height": 0.2, "corner": 240.0}})(POINT, LINES)
    ratio = np.abs(rung / bare)[0]
    assert ratio[np.searchsorted(LINES, 240.0)] == pytest.approx(1.2, rel=1e-6)
    assert abs(ratio[0] - 1.0) < 0.01


@pytest.mark.parametrize(("name", "wanted"), [("thermal_lag", {"rate"}), ("amplitude_softening", {"level"})])
def test_only_two_effects_follow_more_than_the_temperature(specimen: Specimen, name: str, wanted: set[str]):
    """The transfer says so, and the others keep to it."""
    assert specimen.transfer({name: {}}).follows == wanted
    others = set(specimen.cards) - {"thermal_lag", "amplitude_softening"}
    here, there = POINT, SweepPoint(20.0, 0.02, 2.0)
    for other in sorted(others):
        values = {p.name: 0.3 * p.high if not p.shape else p.typical for p in specimen.cards[other].parameters}
        transfer = specimen.transfer({other: values})
        assert not transfer.follows
        np.testing.assert_array_equal(transfer(here, LINES[:3]), transfer(there, LINES[:3]))
