"""A spruce plate declared with moduli 15 % wrong, recorded on the simulated rig: moduli and losses by direction.

Constants, lengths and mass are those published for a plate of tonewood (Badiane, Malvermi, Gonzalez, Antonacci,
Sarti: plate 5L): Ex/Ey is 12.1. The loss along the grain is a third of that across; the shear modulus of the plane
yz, which is not declared, is a tenth of that in the plane.
"""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from threadpoolctl import threadpool_limits

from app.blind_trial.plates import OTHER_MESH
from app.files.effect_cache import cached_departures
from app.files.experiment_toml import AcquiredExperiment, read_acquired_experiment
from app.files.laws_file import load_updated
from app.files.toml_text import toml_text
from app.main import flexura
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "exciter.toml"
TRUE = {"youngs_modulus_x": 12.1e9, "youngs_modulus_y": 0.999e9, "shear_modulus": 0.798e9}
WRONG = {"youngs_modulus_x": 1.15, "youngs_modulus_y": 0.85, "shear_modulus": 0.85}
TRANSVERSE = [0.75e9, 0.08e9]
NU_XY, LOSS = 0.471, {"x": 0.009, "y": 0.027, "shear": 0.018}
TEMPERATURE = np.array([5.0, 12.0, 19.0, 26.0, 33.0])
SOFTENING = 1.0 - 0.002 * (TEMPERATURE - 20.0)
BOX = {"youngs_modulus": [3e9, 13e9], "poisson_ratio": [0.02, 0.35], "loss_factor": [0.004, 0.08]}
HIDDEN = {
    "sheet_loss": {
        "ratio": float(np.log(LOSS["y"] / LOSS["x"])),
        "shear": float(np.log(LOSS["shear"] / np.sqrt(LOSS["x"] * LOSS["y"]))),
    },
    "plate_thickness": {"share": 0.004},
    "transducer_place acc": {"dx": 4e-4, "dy": -3e-4},
}
"""What the plate has and the declaration does not say, within its tolerances but for the losses."""


class Recorded(Twin[EffectPlate]):
    """The plate that is recorded."""

    def uncertified_frf(self, laws, frequency, effects=None, point=None):  # type: ignore[no-untyped-def]
        """Return its transfer with what is hidden."""
        return super().uncertified_frf(laws, frequency, {**HIDDEN, **(effects or {})}, point)


def run(*words: object) -> Any:
    with threadpool_limits(1):
        return CliRunner().invoke(flexura, [str(word) for word in words])


def declaration(orthotropy: dict[str, Any]) -> dict[str, Any]:
    """Return the experiment as a table: the example's rig around a plate of spruce."""
    table = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
    mean, ratio = (
        0.5 * (TRUE["youngs_modulus_x"] + TRUE["youngs_modulus_y"]),
        TRUE["youngs_modulus_y"] / TRUE["youngs_modulus_x"],
    )
    nu = NU_XY * float(np.sqrt(ratio))
    del table["patch"]
    table["plate"] = {
        **{"length_x": 0.5814, "length_y": 0.2176, "thickness": 0.005, "mass": 0.2728},
        "material": {**BOX, "orthotropy": orthotropy},
    }
    table["drive"][0]["point"] = [0.03, 0.03]
    table["sensor"] = [
        {**table["sensor"][0], "point": [0.5514, 0.1876], "side": "top", "mass": 0.0022},
        {**table["sensor"][1], "sensitivity": 5.0, "points": [[0.25, 0.06], [0.40, 0.20]]},
    ]
    table["cards"]["responses"] = ["cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2", "cDAQ1Mod1/ai3"]
    table["sweep"] |= {"band": [60.0, 600.0], "duration": 4.0, "tail": 5.0, "levels": [0.5]}
    table["programme"] |= {"lowest": 15.0, "highest": 25.0, "every": 5.0}
    table["simulation"]["laws"] = {
        "temperature": TEMPERATURE.tolist(),
        "youngs_modulus": (mean * SOFTENING).tolist(),
        "poisson_ratio": [nu] * len(TEMPERATURE),
        "loss_factor": [float(np.sqrt(LOSS["x"] * LOSS["y"]))] * len(TEMPERATURE),
    }
    return table


def written(folder: Path, name: str, orthotropy: dict[str, Any]) -> AcquiredExperiment:
    path = folder / f"{name}.toml"
    path.write_text(toml_text(declaration(orthotropy), ""), encoding="utf-8")
    return read_acquired_experiment(path)


def specimen(experiment: AcquiredExperiment) -> Recorded:
    """Return the plate with its true moduli, on another mesh than the twin of the analysis."""
    recorded = experiment.recorded(experiment.sample_rate)
    material = recorded.plate.material
    assert material is not None
    operators = cached_departures(recorded, material.box, lambda stage, share: None, OTHER_MESH)
    return Recorded.of(recorded, EffectPlate(operators), tolerances=tolerances(recorded, operators.movable))


@pytest.mark.slow
def test_moduli_and_losses_by_direction_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    exact = written(tmp_path, "true", {**TRUE, "transverse_shear_modulus": TRANSVERSE})
    plate = specimen(exact)
    monkeypatch.setattr("app.rig.simulated_rig.campaign_twin", lambda *_: plate)
    written(tmp_path, "declared", {name: WRONG[name] * value for name, value in TRUE.items()})
    recorded = run("acquire", tmp_path / "declared.toml", "--out", tmp_path / "campaign")
    assert recorded.exit_code == 0, recorded.output
    found = run("update", tmp_path / "campaign", "--json", "--out", tmp_path / "run")
    assert found.exit_code == 0, found.output
    record = json.loads(found.stdout)
    assert len(record["temperatures"]) == 3
    # the laws' nu is not the middle of the range for which a modulus was turned into a share
    material = exact.plate.material
    assert material is not None
    middle, nu = (
        np.mean(BOX["poisson_ratio"]),
        NU_XY * np.sqrt(TRUE["youngs_modulus_y"] / TRUE["youngs_modulus_x"]),
    )
    truth = {**TRUE, "shear_modulus": TRUE["shear_modulus"] * (1.0 + middle) / (1.0 + nu)}
    for row in record["temperatures"]:
        softening = np.interp(row["temperature_c"], TEMPERATURE, SOFTENING)
        for name, value in truth.items():
            estimate, sigma = row[f"{name}_pa"], row["sigma"][f"{name}_pa"]
            assert abs(estimate / (softening * value) - 1.0) < 0.03, name
            assert abs(estimate - softening * value) < 2.0 * sigma, name
            assert sigma < 0.03 * estimate
        for name, value in LOSS.items():
            estimate, sigma = row[f"loss_factor_{name}"], row["sigma"][f"loss_factor_{name}"]
            assert abs(estimate / value - 1.0) < 0.02, name
            assert abs(estimate - value) < 3.0 * sigma, name
        assert abs(row["poisson_ratio_xy"] - NU_XY) < 3.0 * row["sigma"]["poisson_ratio_xy"]
        assert "youngs_modulus_pa" not in row  # no modulus that the plate has in no direction
    updated, _ = load_updated(tmp_path / "run" / "laws.h5")
    assert updated.sheet is not None
    assert updated.sheet.value.youngs_modulus_y[0] == record["temperatures"][0]["youngs_modulus_y_pa"]
    declared = (TRUE["youngs_modulus_y"] / TRUE["youngs_modulus_x"] - 1.0) / (
        TRUE["youngs_modulus_y"] / TRUE["youngs_modulus_x"] + 1.0
    )
    assert record["sheet"]["delta_e"] == pytest.approx(declared, abs=2e-3)
