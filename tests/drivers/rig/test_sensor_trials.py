"""Simulated faults of the sensors on a plate: no wrong label without a word, and no sound campaign doubted."""

import pytest

from tests.drivers.rig.sensor_trials import KINDS, Trial


@pytest.mark.parametrize("kind", KINDS)
def test_no_label_is_wrong_without_a_word(kind: str) -> None:
    trial = Trial(4, kind).run()
    assert trial.untold == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_no_label_of_many_campaigns_is_wrong_without_a_word(kind: str) -> None:
    """`benchmarks/sensor_faults.py` does it with any number."""
    trials = [Trial(10_000 + seed, kind).run() for seed in range(12)]
    assert [(trial.seed, trial.untold) for trial in trials if trial.untold] == []
    assert any(trial.labels for trial in trials)
    assert any(trial.told or trial.ending != "complete" for trial in trials)


def test_two_minutes_of_readings_do_not_make_a_sound_sensor_a_loose_one() -> None:
    """On a ramp that has just begun, a slow plate with a share of the air looks like a faster one (seed 238)."""
    trial = Trial(238).run()
    assert (trial.told, trial.ending) == ([], "complete")


def test_a_long_run_of_noise_does_not_make_a_sound_sensor_a_loose_one() -> None:
    """Small differences summed to more than is told; the evidence spoke for a sound sensor (seed 414)."""
    trial = Trial(414).run()
    assert (trial.told, trial.ending) == ([], "complete")


def test_a_sensor_that_comes_loose_is_told_where_its_estimated_causes_cancel() -> None:
    """Found: seed 2636, labels 0.6 K wrong of which 0.2 K were estimated; the evidence was exp(127)."""
    trial = Trial(2636, "loosening").run()
    assert max(abs(label - true) for label, true, _ in trial.labels.values()) > 0.5
    assert trial.untold == []
    assert "does not follow the air as a sensor on a plate does" in trial.told[-1]


@pytest.mark.slow
def test_sound_campaigns_are_not_doubted() -> None:
    trials = [Trial(20_000 + seed).run() for seed in range(40)]
    assert [(trial.seed, trial.ending, trial.told[:2]) for trial in trials if trial.told] == []
    assert {trial.ending for trial in trials} == {"complete"}
