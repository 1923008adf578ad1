"""A hammer, an accelerometer and a laser: recorded, imported, identified and updated like any other campaign."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.kind import DECLARATION
from app.files.campaigns.recorded import read_recorded_campaign
from app.files.settings_toml import toml_text
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.plate_basis import reduce_with_footprints
from simulation.shell.assembly import assemble
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.twin import Twin

Run = Callable[..., tuple[int, str, str]]
RATE, SWEEP, TAIL, BAND = 51_200.0 / 12, 2.0, 0.6, (100.0, 600.0)
SAMPLES = round((SWEEP + TAIL) * RATE)
TRUE = {20.0: (2.1e9, 0.38, 0.05), 30.0: (1.9e9, 0.385, 0.056), 40.0: (1.7e9, 0.39, 0.063)}
CALIBRATION = 1.02
UNITS = {"drive": "N", "acc1": "m/s^2", "laser": "m/s", "S1": "V"}
"""As the recorder writes them; m/s^2 is m/s2."""


def declaration() -> Experiment:
    return Experiment.model_validate(
        {
            "title": "hammer and accelerometer",
            "plate": {"length_x": 0.16, "length_y": 0.12, "thickness": 0.003, "mass": 0.0547},
            "patch": [
                {"id": "S1", "role": "sensor", "center": (0.03, 0.03), "size": (0.02, 0.02), "thickness": 5e-4}
            ],
            "drive": [{"id": "hammer", "kind": "force", "point": (0.11, 0.08)}],
            "sensor": [
                {"id": "acc1", "kind": "acceleration", "point": (0.05, 0.09), "mass": 0.0006, "side": "bottom"},
                {"id": "laser", "kind": "velocity", "point": (0.13, 0.02)},
            ],
            "acquisition": {
                "module": "NI-9234",
                "sample_rate": RATE,
                "input_resistance": 305e3,
                "input_capacitance": 1.2e-10,
            },
            "protocol": {
                "sweep": "linear",
                "band": BAND,
                "sweep_duration": SWEEP,
                "tail": TAIL,
                "repeats": 3,
                "ramp_rate": 0.4,
                "temperatures": tuple(TRUE),
                "directions": ("up",),
                "levels": (2.0,),
            },
            "oven": {"room_temperature": 22.0},
        }
    )


def channels(specimen: Twin, material: tuple[float, float, float], rng: np.random.Generator) -> dict[str, Any]:
    """One repeat: a short pulse of force, and what the plate answers, with half a per cent of noise."""
    time = np.arange(SAMPLES) / RATE
    force = 2.0 * np.exp(-(((time - 0.02) / 4e-4) ** 2))
    grid = np.fft.rfftfreq(SAMPLES, 1.0 / RATE)
    inside = (grid > 60.0) & (grid < 800.0)
    answers = np.zeros((specimen.outputs, grid.size), complex)
    answers[:, inside] = specimen.uncertified_frf(LocalLaws.of_material(*material), grid[inside])
    signals = np.fft.irfft(CALIBRATION * answers * np.fft.rfft(force), SAMPLES)
    signals += 2e-3 * signals.std(axis=1)[:, None] * rng.standard_normal(signals.shape)
    return {"drive": force, "S1": signals[0], "acc1": signals[1], "laser": signals[2]}


@pytest.fixture(scope="module")
def specimen() -> Twin:
    """Return the plate that is recorded, on a coarse mesh of its own."""
    experiment = declaration()
    model = assemble(
        experiment.plate, experiment.patch, recipe=MeshRecipe(spacing=0.08, growth=2.0, pieces=1), degree=5
    )
    box = MaterialBox((1.5e9, 2.4e9), (0.36, 0.41), (0.03, 0.08))
    reduced, _ = reduce_with_footprints(model, box, (60.0, 800.0), experiment.footprints)
    return Twin.of(experiment, DeclaredPlate(reduced))


def write(folder: Path, specimen: Twin, units: dict[str, str]) -> Path:
    """Write a recording of the specimen, in these units."""
    rng = np.random.default_rng(5)
    (folder / "sweeps").mkdir(parents=True)
    table = declaration().model_dump(mode="json")
    (folder / DECLARATION).write_text(toml_text(table, ""), encoding="utf-8")
    for step, (temperature, material) in enumerate(TRUE.items()):
        with TdmsWriter(folder / "sweeps" / f"{step:03d}.tdms") as writer:
            root = {
                "oven_temperature_start": temperature,
                "oven_temperature_end": temperature,
                "direction": "up",
                "level": 2.0,
                "step": step,
                "start_time": "2026-01-05T08:00:00",
            }
            parts: list[Any] = [RootObject(root)]
            for repeat in range(3):
                parts.append(GroupObject(f"repeat {repeat + 1}"))
                for name, samples in channels(specimen, material, rng).items():
                    given = {
                        "wf_increment": 1.0 / RATE,
                        "wf_start_offset": 0.0,
                        "wf_samples": SAMPLES,
                        "unit_string": units[name],
                    }
                    group = f"repeat {repeat + 1}"
                    parts.append(ChannelObject(group, name, samples.astype(np.float32), given))
            writer.write_segment(parts)
    return folder


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory, specimen: Twin) -> Path:
    return write(tmp_path_factory.mktemp("force") / "plate", specimen, UNITS)


def test_units_are_held_against_the_declaration(recorded: Path, specimen: Twin, tmp_path: Path) -> None:
    campaign = read_recorded_campaign(recorded)
    assert campaign.sweeps[0].responses.shape == (3, 3, SAMPLES)
    wrong = write(tmp_path / "wrong", specimen, UNITS | {"acc1": "V"})
    with pytest.raises(CampaignFileError, match=r"repeat 1/acc1 unit_string.*'V'.*'m/s2'"):
        read_recorded_campaign(wrong)


def test_import_identify_and_update(recorded: Path, run_flexura: Run) -> None:
    status, output, message = run_flexura("import", recorded, "--json")
    assert (status, json.loads(output)["sensors"]) == (0, ["S1", "acc1", "laser"]), message
    folder = recorded.with_name("plate-campaign")
    with h5py.File(folder / "sweeps" / "0000_up_T+020.0.h5") as file:
        assert file["drive"].attrs["unit"] == "N"
        assert json.loads(file["responses"].attrs["unit"]) == ["V", "m/s2", "m/s"]
    status, _, message = run_flexura("identify", folder)
    assert status == 0, message
    status, output, message = run_flexura("update", folder, "--json")
    assert status == 0, message
    found = json.loads(output)
    assert "N/N" in message
    assert abs(found["gain"] - CALIBRATION) < 3.0 * found["sigma_gain"]  # mass and sensitivities are not exact
    assert found["gain"] == pytest.approx(CALIBRATION, rel=0.02)
    for row, (e, nu, eta) in zip(found["temperatures"], TRUE.values(), strict=True):
        assert row["youngs_modulus_pa"] == pytest.approx(e, rel=0.01)
        assert row["poisson_ratio"] == pytest.approx(nu, abs=0.003)
        assert row["loss_factor"] == pytest.approx(eta, rel=0.03)
    run = recorded.with_name("plate-run")
    with h5py.File(next(recorded.parent.rglob("frf.h5")) if not run.exists() else run / "frf.h5") as file:
        labels = json.loads(file["frf"].attrs["labels"])
    assert labels == ["S1/hammer [V/N]", "acc1/hammer [m/s2/N]", "laser/hammer [m/s/N]"]
