"""The hammer test that ships with the project: small, faultless, and the material that was put in comes back."""

import json
import runpy
from pathlib import Path

import pytest
from click.testing import CliRunner

from analysis.identification.pole_residue import choices_for
from analysis.identification.settings import Settings
from app.files.campaigns.loading import load_campaign
from app.main import flexura
from app.stages.identify import compute
from app.stages.identify_options import Wanted

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "hammer-plate"


def test_is_a_faultless_campaign_and_small() -> None:
    campaign = load_campaign(EXAMPLE)
    assert [round(sweep.oven_temperature) for sweep in campaign.sweeps] == [20, 30, 40, 50]
    assert campaign.sweeps[0].responses.shape == (2, 3, 16000)
    assert campaign.experiment.labels() == ("acc1/hammer [m/s2/N]", "acc2/hammer [m/s2/N]")
    files = [path for path in EXAMPLE.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) <= 3_000_000
    assert {path.suffix for path in files} == {".toml", ".md", ".tdms"}


def test_the_material_put_in_comes_back(tmp_path: Path) -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_hammer_example.py"))
    result = CliRunner().invoke(flexura, ["update", str(EXAMPLE), "--out", str(tmp_path / "run"), "--json"])
    assert result.exit_code == 0, result.stderr
    found = json.loads(result.stdout)
    assert found["gain"] == pytest.approx(made["CALIBRATION"], rel=0.02)  # sensitivities are declared to 2 %
    assert len(found["temperatures"]) == 4
    for row in found["temperatures"]:
        e, nu, eta = made["material"](row["temperature_c"])
        assert row["youngs_modulus_pa"] == pytest.approx(e, rel=0.01)
        assert row["poisson_ratio"] == pytest.approx(nu, abs=0.003)
        assert row["loss_factor"] == pytest.approx(eta, rel=0.03)
        assert row["misfit"] < 1.1 * row["noise_floor"]


def test_accelerations_have_residual_terms_of_their_own() -> None:
    wanted = Wanted(Settings(), "hysteretic", "auto", None)
    found = compute(load_campaign(EXAMPLE), wanted, lambda stage, share: None)
    assert {modes.terms for modes in found.tracked.modes} <= set(choices_for({"acceleration"}))
    assert found.frf.h.shape[0] == len(found.tracked.modes) == 4
