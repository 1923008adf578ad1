"""A plate driven by one patch, then by another, on the simulated rig: two campaigns, joined and updated as one."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from app.files.declarations.simulation_section import Laws
from app.files.settings_toml import read_table, toml_text

QUICK = Path(__file__).resolve().parents[2] / "examples" / "quick-rig.toml"
GAINS = {"A1": 13.7, "A2": 11.9}

pytestmark = pytest.mark.slow


def test_both_amplifiers_and_one_material_are_found(
    tmp_path: Path, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    second = {"id": "A2", "center": [0.05, 0.15], "size": [0.02, 0.02], "thickness": 5e-4}
    folders = []
    for seed, (driven, gain) in enumerate(GAINS.items(), 1):
        table = dict(read_table(QUICK))
        patches = [*table["patch"], second]
        table["patch"] = [
            patch if patch["id"] == "S1" else patch | {"role": "actuator" if patch["id"] == driven else "shorted"}
            for patch in patches
        ]
        table["simulation"] = table["simulation"] | {"gain": gain, "seed": seed}
        experiment, folder = tmp_path / f"{driven}.toml", tmp_path / driven
        experiment.write_text(toml_text(table, ""), encoding="utf-8")
        status, _, message = run_flexura("acquire", experiment, "--out", folder)
        assert status == 0, message
        folders.append(folder)
    status, _, message = run_flexura("import", *folders, "--out", tmp_path / "both")
    assert status == 0, message
    status, output, message = run_flexura("update", tmp_path / "both", "--json")
    assert status == 0, message
    found = json.loads(output)
    gains = {name: gain["gain"] for name, gain in found["gains"].items()}
    assert gains == pytest.approx(GAINS, rel=0.03)  # d31 is declared to 5 % only
    laws = Laws.model_validate(read_table(QUICK)["simulation"]["laws"]).laws()
    assert [sweep["actuator"] for sweep in found["temperatures"]] == ["A1"] * 4 + ["A2"] * 4
    for sweep in found["temperatures"]:
        true = laws.at(sweep["temperature_c"])
        assert sweep["youngs_modulus_pa"] == pytest.approx(
            true.youngs_modulus.item(), rel=2e-3
        )  # 0.1 K read wrong
        assert sweep["poisson_ratio"] == pytest.approx(true.poisson_ratio.item(), abs=5e-4)
