"""FRFs that went through another program's file lead to the laws and the verdict of the time signals."""

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from analysis.recordings.frf import campaign_frf
from analysis.updated import Updated
from app.files.campaigns.export import export_frfs
from app.files.campaigns.loading import load_campaign
from app.stages import update
from app.stages.update import UpdateRequest

Run = Callable[..., tuple[int, str, str]]
SHARED = Path(__file__).resolve().parents[4] / "shared" / "data" / "campaigns" / "pp-plate-nominal"

FRFS = {
    "uff": 'file = "frfs.uff"\naverages = 2\n',
    "mat": (
        'file = "frfs.mat"\ntemperature = "temperature"\nlevel = "level"\ndirection = "descending"\naverages = 2\n'
        'sensors = { "H_S1[*]" = "S1" }\nunits = ["V", "V"]\n'
    ),
    "csv": 'file = "frfs_*.csv"\nsensors = { FRF = "S1" }\naverages = 2\n',
    "nc": (
        'file = "frfs.nc"\ntemperature = "temperature"\nlevel = "level"\ndirection = "descending"\naverages = 2\n'
        'sensors = { "h[*]" = "S1" }\ncoherence = { S1 = "coherence[*]" }\nunits = ["V", "V"]\n'
    ),
}


def exported(recorded: Path, folder: Path, form: str) -> Path:
    """Export a recorded campaign's FRFs, and declare the plate beside them with the same words."""
    folder.mkdir()
    campaign = load_campaign(recorded)
    export_frfs(folder / f"frfs.{form}", campaign.experiment, campaign_frf(campaign))
    toml = (recorded / "campaign.toml").read_text(encoding="utf-8")
    toml = toml.replace("recorded-campaign/1", "flexura-plate/1")
    (folder / "plate.toml").write_text(f"{toml}\n[[frf]]\n{FRFS[form]}", encoding="utf-8")
    return folder


@cache
def updated(folder: Path) -> Updated:
    with threadpool_limits(1):
        return update.compute(UpdateRequest(load_campaign(folder)), lambda _stage, _share: None).updated


def away(one: Updated, other: Updated) -> float:
    """Largest difference of E, nu and eta, in standard deviations."""
    a, b = np.argsort(one.temperature), np.argsort(other.temperature)
    names = ("youngs_modulus", "poisson_ratio", "loss_factor")
    return max(
        float(
            np.abs((getattr(other.material, n)[b] - getattr(one.material, n)[a]) / getattr(one.sigma, n)[a]).max()
        )
        for n in names
    )


@pytest.mark.slow
def test_three_sweeps_give_the_laws_of_their_time_signals(
    tmp_path: Path, cut_recording: Callable[[Path, tuple[int, ...]], None]
) -> None:
    cut_recording(tmp_path / "recorded", (8, 28, 48))
    wanted = updated(tmp_path / "recorded")
    for form in FRFS:
        assert away(wanted, updated(exported(tmp_path / "recorded", tmp_path / form, form))) < 0.1, form


@pytest.mark.slow
@pytest.mark.shared
@pytest.mark.skipif(not SHARED.is_dir(), reason="the recorded campaigns of shared/ are not here")
@pytest.mark.parametrize("form", FRFS)
def test_the_public_campaign_gives_the_same_laws(form: str, tmp_path: Path) -> None:
    assert away(updated(SHARED), updated(exported(SHARED, tmp_path / form, form))) < 0.1


@pytest.mark.slow
@pytest.mark.shared
@pytest.mark.skipif(not SHARED.is_dir(), reason="the recorded campaigns of shared/ are not here")
def test_the_public_campaign_gives_the_same_verdict(tmp_path: Path, run_flexura: Run) -> None:
    verdicts = []
    for number, folder in enumerate((SHARED, exported(SHARED, tmp_path / "mat", "mat"))):
        run = tmp_path / f"run{number}"
        status, _, said = run_flexura("gap", folder, "--out", run, "--quiet")
        assert status in (0, 1), said
        found = json.loads((run / "gap.json").read_text(encoding="utf-8"))
        verdicts.append(
            (status, found["verdict"], [re.sub(r"\d", "", str(one["name"])) for one in found["effects"]])
        )
    assert verdicts[0] == verdicts[1]
