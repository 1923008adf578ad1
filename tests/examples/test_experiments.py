"""The experiments that come with the project can be run as they are."""

from pathlib import Path

import pytest

from app.files.experiment_toml import read_acquired_experiment

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize("name", ["simulated-rig", "paper-protocol"])
def test_stands_up_to_its_own_checks(name: str) -> None:
    experiment = read_acquired_experiment(EXAMPLES / f"{name}.toml")
    assert experiment.simulation is not None
    assert experiment.sample_rate == pytest.approx(51_200.0 / 6.0)


def test_the_papers_cycle() -> None:
    experiment = read_acquired_experiment(EXAMPLES / "paper-protocol.toml")
    programme = experiment.programme
    assert (programme.lowest, programme.highest, programme.every, programme.ramp_rate) == (0.0, 60.0, 2.0, 0.4)
    assert experiment.sweep.band == (100.0, 1500.0)
    assert experiment.cards.sample_rate == 8500.0
    assert experiment.protocol.seconds(programme.lowest - programme.lead) == pytest.approx(3 * 3600.0)


def test_a_rehearsal_calls_itself_simulated() -> None:
    experiment = read_acquired_experiment(EXAMPLES / "paper-protocol.toml")
    assert experiment.on("ni").title == "polypropylene plate, 0 to 60 °C"
    rehearsal = experiment.on("simulated")
    assert rehearsal.recorded(rehearsal.sample_rate).title == "polypropylene plate, 0 to 60 °C (simulated)"
    assert rehearsal.on("simulated") == rehearsal
