"""flexura acquire with an exciter: force sensor, accelerometer, vibrometer, displacement and charge."""

import json
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from click.testing import CliRunner, Result
from threadpoolctl import threadpool_limits

from analysis.arrays import Real
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.frf import Frf, campaign_frf
from app.files.acquisition.campaign_folder import AcquiredCampaign
from app.files.acquisition.events import append_event
from app.files.campaigns.folder import digest
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.files.results.modes_file import load_frf, save_frf
from app.main import flexura
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.plate_basis import reduce_with_footprints
from simulation.shell.assembly import assemble
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.twin import Twin

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "exciter.toml"
BOX = MaterialBox((1.3e9, 2.7e9), (0.355, 0.415), (0.055, 0.08))


def run(*words: object) -> Result:
    with threadpool_limits(1):
        return CliRunner().invoke(flexura, [str(word) for word in words])


@pytest.fixture(scope="module")
def experiment() -> AcquiredExperiment:
    return read_acquired_experiment(EXAMPLE)


@pytest.fixture(scope="module")
def twin(experiment: AcquiredExperiment) -> Twin:
    """On a coarse mesh: what the plate is matters as little here as that it is the same on both sides."""
    recorded = experiment.recorded(experiment.sample_rate)
    recipe = MeshRecipe(spacing=0.08, growth=2.0, pieces=1)
    model = assemble(recorded.plate, recorded.patch, recipe=recipe, degree=4)
    return Twin.of(
        recorded, DeclaredPlate(reduce_with_footprints(model, BOX, recorded.protocol.band, recorded.footprints)[0])
    )


@pytest.fixture(scope="module")
def folders(twin: Twin, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return an undisturbed campaign, and what a kill after its first sweep would have left of it."""
    folder = tmp_path_factory.mktemp("whole") / "campaign"
    killed = tmp_path_factory.mktemp("killed") / "campaign"
    keep = AcquiredCampaign.keep

    def keep_and_copy(store: AcquiredCampaign, *given: Any) -> None:
        keep(store, *given)
        if not killed.exists():
            shutil.copytree(folder, killed)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.rig.simulated_rig.campaign_twin", lambda *_: twin)
        patch.setattr(AcquiredCampaign, "keep", keep_and_copy)
        result = run("acquire", EXAMPLE, "--out", folder)
    assert result.exit_code == 0, result.output
    return folder, killed


@pytest.fixture(scope="module")
def folder(folders: tuple[Path, Path]) -> Path:
    return folders[0]


@pytest.fixture(scope="module")
def frf(folder: Path) -> Frf:
    return campaign_frf(load_campaign(folder))


def test_transfers_have_the_units_of_recorded_campaigns(frf: Frf, folder: Path) -> None:
    assert frf.labels == (
        "S1/shaker [V/N]",
        "Q1/shaker [C/N]",
        "acc/shaker [m/s2/N]",
        "laser1/shaker [m/s/N]",
        "laser2/shaker [m/s/N]",
        "gap/shaker [m/N]",
    )
    with h5py.File(folder / "sweeps" / "0000_up_T+015.0.h5") as file:
        assert file["drive"].attrs["unit"] == "N"
        assert json.loads(file["responses"].attrs["unit"]) == ["V", "C", "m/s2", "m/s", "m/s", "m"]
        assert file.attrs["level"] == 1.0  # the generator's volts
        assert np.abs(file["drive"][()]).max() == pytest.approx(0.6, rel=0.02)  # 0.6 N/V, not the 0.5 stated


def test_h1_is_the_twins_transfer_within_noise(experiment: AcquiredExperiment, twin: Twin, frf: Frf) -> None:
    """At the temperature that fits all channels best, which the thermocouple has read to a tenth of a kelvin.

    A hundredth of a kelvin moves this plate's resonances by more than the noise.
    """
    assert experiment.simulation is not None
    laws, kept = experiment.simulation.laws.laws(), ~frf.excluded

    def normalized(row: int, temperature: float) -> Real:
        """Rms distance from the twin in units of the noise, of each channel."""
        material = laws.at(temperature)
        constants = (material.youngs_modulus[0], material.poisson_ratio[0], material.loss_factor[0])
        expected = twin.frf(LocalLaws.of_material(*map(float, constants)), frf.frequency)
        squares = np.abs(frf.h[row] - expected) ** 2 / frf.variance[row]
        return np.asarray(np.sqrt(squares[:, kept].mean(axis=1)))

    for row, read in enumerate(frf.temperature):
        tried = read + np.linspace(-0.1, 0.1, 81)
        best = min(tried, key=lambda temperature: float((normalized(row, temperature) ** 2).sum()))
        assert best == pytest.approx(read, abs=0.06)
        np.testing.assert_allclose(normalized(row, best), 1.0, atol=0.15)


def test_a_killed_campaign_goes_on_to_the_same_samples(
    folders: tuple[Path, Path], twin: Twin, monkeypatch: pytest.MonkeyPatch
) -> None:
    killed = folders[1]
    assert len(list((killed / "sweeps").glob("*.h5"))) == 1
    monkeypatch.setattr("app.rig.simulated_rig.campaign_twin", lambda *_: twin)
    result = run("acquire", EXAMPLE, "--out", killed)
    assert result.exit_code == 0, result.output
    assert "4 sweeps" in result.stderr
    assert "3 of them now" in result.stderr
    whole, resumed = (load_campaign(one).sweeps for one in folders)
    assert [digest(sweep) for sweep in whole] == [digest(sweep) for sweep in resumed]


def test_a_sensitivity_is_not_changed_in_the_middle_of_a_campaign(folder: Path, tmp_path: Path) -> None:
    changed = tmp_path / EXAMPLE.name
    changed.write_text(EXAMPLE.read_text(encoding="utf-8").replace("sensitivity = 0.1 ", "sensitivity = 0.11 "))
    result = run("acquire", changed, "--out", folder)
    assert result.exit_code != 0
    assert "begun with another experiment; different: drive" in result.output


def test_a_sweep_that_was_given_up_is_not_missed_and_levels_stay_the_generator_s_volts(
    folder: Path, tmp_path: Path
) -> None:
    """The input is a force in N; its level is not."""
    lacking = shutil.copytree(folder, tmp_path / "campaign")
    sorted((lacking / "sweeps").glob("*.h5"))[0].unlink()
    extent = load_campaign(lacking).extent
    assert extent is not None
    assert (extent.state, extent.sweeps, extent.given_up) == ("interrupted", 3, 0)
    event = {"event": "missing", "date": "2000-01-01T00:00:00+00:00", "step": 0, "place": "15 °C up 1 V"}
    append_event(lacking, event)
    ended = load_campaign(lacking).extent
    assert ended is not None
    assert (ended.state, ended.given_up) == ("ended", 1)
    frf = campaign_frf(load_campaign(lacking))
    assert len(frf.temperature) == 3
    assert (frf.unit(0), frf.drive(0)) == ("V/N", "1 V")
    save_frf(tmp_path / "frf.h5", load_campaign(lacking).experiment, frf, {})
    assert load_frf(tmp_path / "frf.h5")[1].level_unit() == "V"
