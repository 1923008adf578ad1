"""The experiments that come with the project can be run as they are."""

from pathlib import Path

import pytest

from app.files.declarations.experiment import read_acquired_experiment
from app.files.declarations.panel import read_panel

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


SIMULATED = ["simulated-rig", "quick-rig", "paper-protocol", "clamped-disc"]
SIMULATED += ["door-trim/experiment", "door-trim/hidden-effect"]


@pytest.mark.parametrize("name", SIMULATED)
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


def test_the_door_trim_is_one_plate_in_all_its_files() -> None:
    plain, hidden = (
        read_acquired_experiment(EXAMPLES / "door-trim" / f"{name}.toml")
        for name in ("experiment", "hidden-effect")
    )
    panel = read_panel(EXAMPLES / "door-trim" / "panel.toml")
    assert plain.plate == hidden.plate == panel.plate
    assert plain.patch == hidden.patch
    assert plain.plate.density == pytest.approx(950.0, rel=1e-3)  # polypropylene
    assert len(panel.patch) == 6
