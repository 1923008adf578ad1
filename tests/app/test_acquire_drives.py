"""Campaigns driven by burst random and by a multi-sine: acquired on simulated cards, and the laws come back."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from app.files.declarations.experiment import read_acquired_experiment
from app.main import flexura

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "quick-rig.toml"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["burst-random", "multi-sine"])
def test_the_laws_put_in_come_back(kind: str, tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    assert text.count('kind = "logarithmic"') == 1
    file, folder = tmp_path / "mine.toml", tmp_path / "campaign"
    file.write_text(text.replace('kind = "logarithmic"', f'kind = "{kind}"'), encoding="utf-8")
    done = CliRunner().invoke(flexura, ["acquire", str(file), "--out", str(folder), "--json", "-q"])
    assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout)["finished"] == 4
    done = CliRunner().invoke(flexura, ["update", str(folder), "--out", str(tmp_path / "run"), "--json"])
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    simulation = read_acquired_experiment(file).simulation
    assert simulation is not None
    assert simulation.gain is not None
    assert found["gain"] == pytest.approx(simulation.gain, rel=0.03)
    for row in found["temperatures"]:
        true = simulation.laws.laws().at([row["temperature_c"]])
        assert row["youngs_modulus_pa"] == pytest.approx(float(true.youngs_modulus[0]), rel=0.03)
        assert row["poisson_ratio"] == pytest.approx(float(true.poisson_ratio[0]), abs=0.003)
        assert row["loss_factor"] == pytest.approx(float(true.loss_factor[0]), rel=0.02)


def test_an_unknown_drive_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    text = EXAMPLE.read_text(encoding="utf-8").replace('kind = "logarithmic"', 'kind = "burst random"')
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(flexura, ["acquire", str(file), "--out", str(tmp_path / "campaign")])
    assert done.exit_code != 0
    assert "did you mean burst-random?" in done.output
