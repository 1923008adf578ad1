"""``[simulation.effects]`` as people get it wrong, and as it should be."""

from pathlib import Path

import pytest

from app.files.campaign_error import CampaignFileError
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.files.declarations.hidden_effects import with_shapes
from simulation.effects.library import LIBRARY

EXAMPLES = Path(__file__).resolve().parents[4] / "examples"
CABLE = "[[cable]]\npoint = [0.058, 0.03]\n"


def experiment(tmp_path: Path, effects: str, cable: str = CABLE) -> AcquiredExperiment:
    text = (EXAMPLES / "simulated-rig.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(f"{text}\n{effects}\n\n{cable}", encoding="utf-8")
    return read_acquired_experiment(file)


@pytest.mark.parametrize(
    ("effects", "told"),
    [
        (
            "[simulation.effects.point_mas]\nmass = 1e-3",
            r"simulation.effects.point_mas = unknown effect; allowed: .*did you mean point_mass\?",
        ),
        (
            "[simulation.effects.point_mass]\nmas = 1e-3",
            r"point_mass.mas = unknown parameter; .*mass from 0 to 0.01 kg.*did you mean mass\?",
        ),
        ("[simulation.effects.point_mass]", r"point_mass.mass = nothing; allowed: mass from 0 to 0.01 kg"),
        (
            "[simulation.effects.point_mass]\nmass = 0.8",
            r"point_mass.mass = 0.8; allowed: mass from 0 to 0.01 kg",
        ),
        ("[simulation.effects.point_mass]\nmass = nan", r"point_mass.mass = nan"),
        ('[simulation.effects.point_mass]\nmass = "light"', r"point_mass.mass = 'light'; allowed"),
        ("[simulation.effects.thermal_lag]\ntau = -10", r"thermal_lag.tau = -10; allowed: tau from 0 to 900 s"),
    ],
)
def test_what_is_wrong_is_named_with_file_key_value_and_range(tmp_path: Path, effects: str, told: str) -> None:
    with pytest.raises(CampaignFileError, match=told) as caught:
        experiment(tmp_path, effects)
    assert "mine.toml" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "remedy"),
    [("point_mass", r"declare the \[\[cable\]\]"), ("suspension", r"declare each \[\[string\]\]")],
)
def test_an_effect_needs_what_it_sits_on(tmp_path: Path, name: str, remedy: str) -> None:
    with pytest.raises(CampaignFileError, match=rf"effects.{name} = .*cannot have.*{remedy}"):
        experiment(tmp_path, f"[simulation.effects.{name}]\nmass = 1e-3", cable="")


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(CampaignFileError) as caught:
        experiment(
            tmp_path, "[simulation.effects.point_mass]\nmass = 1\n[simulation.effects.thermal_lag]\ntua = 1"
        )
    assert len(caught.value.problems) == 3


def test_shapes_may_be_left_out(tmp_path: Path) -> None:
    found = experiment(tmp_path, "[simulation.effects.local_damage]\nloss = 0.2")
    assert found.simulation is not None
    declared = found.recorded(found.sample_rate)
    card = LIBRARY["local_damage"].card(declared)
    completed = with_shapes({"local_damage": card}, found.simulation.effects)
    assert completed == {"local_damage": {**card.zero(), "loss": 0.2}}
    assert set(completed["local_damage"]) == {parameter.name for parameter in card.parameters}


def test_no_dump_tells_what_a_campaign_is_to_find_out(tmp_path: Path) -> None:
    """A campaign folder keeps the dump of its experiment."""
    found = experiment(tmp_path, "[simulation.effects.point_mass]\nmass = 1e-3")
    dumped = found.model_dump(mode="json")
    assert set(dumped["simulation"]) == {"seed", "noise", "modules", "served"}
    assert "point_mass" not in str(dumped)


def test_the_example_is_held_by_its_own_plate() -> None:
    found = read_acquired_experiment(EXAMPLES / "hidden-effect.toml")
    assert found.simulation is not None
    assert found.simulation.effects


@pytest.mark.parametrize(("y", "fits"), [(0.1, True), (0.185, False)])
def test_a_spot_lies_on_the_plate(tmp_path: Path, y: float, fits: bool) -> None:
    text = (EXAMPLES / "door-trim" / "experiment.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    spot = f"[simulation.effects.local_damage]\nloss = 0.2\nx = 0.2\ny = {y}\n"
    file.write_text(f"{text}\n{spot}", encoding="utf-8")
    if fits:
        read_acquired_experiment(file)
        return
    with pytest.raises(CampaignFileError, match=r"local_damage = x 0.2, y 0.185 m, off the plate or in a hole"):
        read_acquired_experiment(file)
