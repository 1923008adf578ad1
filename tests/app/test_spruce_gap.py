"""A spruce plate with an accelerometer that nobody declared, moduli 15 % wrong and 2 % of noise: what is named."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.app.spruce import SOFTENING, TEMPERATURE, TRANSVERSE, TRUE, WRONG, run, specimen, written

ACCELEROMETER = 0.0023
"""kg."""
NOISE = 9e-4
"""V rms on every input: 2 % of the response on a line."""


@pytest.mark.slow
def test_an_accelerometer_that_nobody_declared_is_named_and_the_twin_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    exact = written(
        tmp_path, "true", {**TRUE, "transverse_shear_modulus": TRANSVERSE}, accelerometer=ACCELEROMETER
    )
    plate = specimen(exact)
    monkeypatch.setattr("app.rig.simulated_rig.campaign_twin", lambda *_: plate)
    wrong = {name: WRONG[name] * value for name, value in TRUE.items()}
    written(tmp_path, "declared", wrong, accelerometer=0.0, noise=NOISE)
    recorded = run("acquire", tmp_path / "declared.toml", "--out", tmp_path / "campaign")
    assert recorded.exit_code == 0, recorded.output
    found = run("gap", tmp_path / "campaign", "--json", "--out", tmp_path / "run")
    assert found.exit_code == 0, found.output
    record = json.loads(found.stdout)
    assert record["verdict"] in ("explained", "partly_explained")
    named = {name for effect in record["effects"] for name in (effect["name"], *effect["equivalent"])}
    assert "accelerometer_mass" in named
    (mass,) = (
        effect["parameters"]["mass"] for effect in record["effects"] if effect["name"] == "accelerometer_mass"
    )
    assert mass["value"] == pytest.approx(ACCELEROMETER, rel=0.05)
    assert abs(mass["value"] - ACCELEROMETER) < 2.5 * mass["sigma"]
    laws = record["laws"]["final"]
    softening = np.interp(laws["temperature_c"], TEMPERATURE, SOFTENING)
    for name in ("youngs_modulus_x", "youngs_modulus_y"):
        np.testing.assert_allclose(laws[f"{name}_pa"], softening * TRUE[name], rtol=0.03)
    twin = tomllib.loads((tmp_path / "run" / "twin.toml").read_text(encoding="utf-8"))
    assert "accelerometer_mass" in json.dumps(twin)
