"""A declaration that contradicts the resonances stops before a twin is built; a good one goes on."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from analysis.declaration.plate_material import PlateMaterial
from analysis.experiment import Experiment
from analysis.recordings.frf import Frf, campaign_frf
from app.files.bad_file import ResultFileError
from app.files.basis_cache import cached_reduction
from app.files.campaigns.loading import load_campaign
from app.stages.comparison.declaration_check import check_declaration

RECORDED = Path(__file__).parents[5] / "shared" / "data" / "campaigns"


def silent(stage: str, share: float) -> None:
    pass


@pytest.fixture(scope="module")
def recording(cut_recording: Callable[[Path, tuple[int, ...]], None], tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("look") / "plate"
    cut_recording(folder, (0, 20, 60))
    return folder


@pytest.fixture(scope="module")
def measured(recording: Path) -> tuple[Experiment, Frf]:
    campaign = load_campaign(recording)
    return campaign.experiment, campaign_frf(campaign)


def declared(experiment: Experiment, **changes: object) -> Experiment:
    return experiment.model_copy(update={"plate": experiment.plate.model_copy(update=changes)})


def test_a_good_declaration_goes_on_without_a_word(measured: tuple[Experiment, Frf]) -> None:
    assert check_declaration(*measured, silent) == ()


def test_a_wrong_material_is_told_with_what_to_declare(measured: tuple[Experiment, Frf]) -> None:
    experiment, frf = measured
    with pytest.raises(ResultFileError, match=r'declare in \[plate\.material\] kind = "polypropylene"'):
        check_declaration(declared(experiment, material=PlateMaterial(kind="aluminium")), frf, silent)


@pytest.mark.parametrize("verb", ["update", pytest.param("gap", marks=pytest.mark.slow)])
def test_half_the_thickness_stops_a_verb_and_is_told_in_millimetres(
    verb: str, recording: Path, tmp_path: Path, run_flexura: Callable[..., tuple[int, str, str]], monkeypatch
) -> None:
    monkeypatch.setenv("FLEXURA_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "plate"
    shutil.copytree(recording, folder)
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert "\nthickness = 0.003\n" in text
    changed = text.replace("\nthickness = 0.003\n", "\nthickness = 0.0015\n", 1)
    (folder / "campaign.toml").write_text(changed, encoding="utf-8")
    status, out, err = run_flexura(verb, folder, "--out", tmp_path / "run")
    assert (status, out) == (2, "")
    assert re.search(r"thickness 1\.5 mm declared; the resonances at 20 °C say 3\.[0-9]", err)
    assert not list((tmp_path / "cache").glob("*.h5"))


def test_a_basis_that_does_not_converge_is_a_sentence(tmp_path: Path, measured, monkeypatch) -> None:
    from simulation.meshing.plate_mesh import MeshRecipe
    from simulation.reduction.basis_key import BasisTraining
    from simulation.shell.fineness import Fineness

    monkeypatch.setenv("FLEXURA_CACHE", str(tmp_path))
    experiment, _ = measured
    with pytest.raises(ResultFileError, match=r"E 2 to 2\.1 GPa.* Lower the upper end of the band, or narrow"):
        cached_reduction(
            experiment.plate,
            experiment.patch,
            PlateMaterial(youngs_modulus=(2e9, 2.1e9), poisson_ratio=(0.37, 0.38), loss_factor=(0.05, 0.06)).box,
            (100.0, 300.0),
            fineness=Fineness(MeshRecipe(spacing=0.08, grading=0.0, pieces=1), degree=3, tolerance=1e-5),
            training=BasisTraining(tolerance=1e-18),
        )


@pytest.mark.shared
@pytest.mark.skipif(not RECORDED.is_dir(), reason="the recorded campaigns are not beside the checkout")
@pytest.mark.parametrize(
    "name",
    [
        "pp-plate-orthotropic",
        pytest.param("pp-plate-nominal", marks=pytest.mark.slow),
        pytest.param("pp-plate-two-effects", marks=pytest.mark.slow),
    ],
)
def test_recordings_with_and_without_effects_go_on(name: str) -> None:
    campaign = load_campaign(RECORDED / name)
    some = replace(campaign, sweeps=campaign.sweeps[:: max(1, len(campaign.sweeps) // 3)])
    assert check_declaration(campaign.experiment, campaign_frf(some), silent) == ()
