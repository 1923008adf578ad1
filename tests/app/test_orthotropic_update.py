"""A spruce plate declared with moduli 15 % wrong: moduli and losses by direction, each with its deviation."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.files.results.laws_file import load_updated
from tests.app.spruce import (
    BOX,
    LOSS,
    NU_XY,
    SOFTENING,
    TEMPERATURE,
    TRANSVERSE,
    TRUE,
    WRONG,
    run,
    specimen,
    written,
)


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
