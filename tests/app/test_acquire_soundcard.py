"""A whole campaign with no measuring card: the example on a simulated sound card."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from threadpoolctl import threadpool_limits

from app.files.declarations.experiment import read_acquired_experiment
from app.main import flexura
from app.rig.doctor import look_before
from drivers.ni.cards import Action, DaqError
from drivers.rig import survey

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "sound-card.toml"
BEHIND = 0.25
"""The plate lags so far behind the air that is watched, K: 150 s at 0.1 K/min."""


def run(*words: object) -> str:
    with threadpool_limits(1):
        result = CliRunner().invoke(flexura, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.mark.slow
def test_a_campaign_on_a_sound_card_gives_the_laws_put_in(tmp_path: Path) -> None:
    told = json.loads(run("acquire", EXAMPLE, "--out", tmp_path / "campaign", "--json"))
    assert (told["finished"], told["missing"], told["unsafe"]) == (4, 0, [])
    updated = json.loads(run("update", tmp_path / "campaign", "--out", tmp_path / "run", "--json"))
    simulation = read_acquired_experiment(EXAMPLE).simulation
    assert simulation is not None
    for found in updated["temperatures"]:
        true = simulation.laws.laws().at([found["temperature_c"] - BEHIND])
        assert found["youngs_modulus_pa"] == pytest.approx(float(true.youngs_modulus[0]), rel=1e-3)
        assert found["poisson_ratio"] == pytest.approx(float(true.poisson_ratio[0]), rel=1e-3)
        assert found["loss_factor"] == pytest.approx(float(true.loss_factor[0]), rel=5e-3)
        assert found["misfit"] < 1.5 * found["noise_floor"]


def test_a_sound_card_that_is_not_there_is_told_before_a_shot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise DaqError("loading sounddevice", "No module named 'sounddevice'", None, Action.STOP, "install it")

    monkeypatch.setattr(survey, "backend", missing)
    experiment = read_acquired_experiment(EXAMPLE)
    told = {one.what: one for one in look_before(experiment, "real", tmp_path)}
    found = told[f"sound card {experiment.cards.device}".rstrip()]
    assert (found.state, found.next_step) == (survey.FindingState.BAD, "install it")
    assert not [what for what in told if what.startswith("NI ")]
