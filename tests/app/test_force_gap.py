"""A hammer test compared with its twin: nothing is named where nothing is hidden, and what is hidden is named.

The plate that is hit lies on other cells than any twin and keeps functions of higher degree, and nothing of what
makes the effects of the library takes part in it: a mass is one more accelerometer, a string one more support.
"""

import json
import runpy
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.experiment import Experiment
from app.files.campaigns.channels import read_experiment
from app.files.campaigns.kind import DECLARATION
from app.files.settings_toml import toml_text

ROOT = Path(__file__).resolve().parents[2]
MAKER = ROOT / "docs" / "make_hammer_example.py"
EXAMPLE = ROOT / "examples" / "hammer-plate"
DISC = 0.0015
"""Radius on which a twin lets strings and cables act: half of the plate's thickness, m."""

Run = Callable[..., tuple[int, str, str]]

pytestmark = pytest.mark.slow


def polypropylene(temperature: float) -> tuple[float, float, float]:
    warmer = temperature - 20.0
    return 2.1e9 * (1.0 - 0.009 * warmer), 0.38 + 5e-4 * warmer, 0.05 + 6e-4 * warmer


def mixed() -> Experiment:
    """Declare a plate of polypropylene, hit, and read by a patch, an accelerometer and a laser."""
    declared = read_experiment(EXAMPLE)
    table = declared.model_dump(mode="json")
    table["plate"] = {"length_x": 0.2, "length_y": 0.15, "thickness": 0.003, "mass": 0.0855}
    table["patch"] = [
        {"id": "S1", "role": "sensor", "center": [0.035, 0.03], "size": [0.02, 0.02], "thickness": 5e-4}
    ]
    table["drive"] = [{"id": "hammer", "kind": "force", "point": [0.15, 0.105]}]
    table["sensor"] = [
        {"id": "acc1", "kind": "acceleration", "point": [0.05, 0.12], "mass": 0.0006},
        {"id": "laser", "kind": "velocity", "point": [0.17, 0.03]},
    ]
    table["string"] = [{"point": [0.03, 0.14]}, {"point": [0.17, 0.14]}]
    table["cable"] = [{"point": [0.1, 0.02]}]
    table["protocol"] |= {"tail": 1.9, "levels": [2.0], "band": [100.0, 800.0]}
    return Experiment.model_validate(table)


def with_mass(declared: Experiment, kilograms: float) -> Experiment:
    """Return the plate with a mass where the cable is."""
    table = declared.model_dump(mode="json")
    point = table["cable"][0]["point"]
    table["sensor"].append(
        {"id": "hidden", "kind": "acceleration", "point": point, "radius": DISC, "mass": kilograms}
    )
    return Experiment.model_validate(table)


def on_springs(declared: Experiment, stiffness: float) -> Experiment:
    """Return the plate held by its strings as by springs."""
    table = declared.model_dump(mode="json")
    table["plate"]["support"] = [
        {"kind": "elastic", "point": string["point"], "radius": DISC, "stiffness": stiffness}
        for string in table["string"]
    ]
    return Experiment.model_validate(table)


def compared(run: Run, folder: Path, declared: Experiment, made: Experiment, *laws: Any) -> dict[str, Any]:
    """Record a campaign and compare it with its twin."""
    folder.mkdir()
    (folder / DECLARATION).write_text(toml_text(declared.model_dump(mode="json"), ""), encoding="utf-8")
    runpy.run_path(str(MAKER))["record"](declared, folder, made, *laws)
    status, output, message = run("gap", folder, "--json")
    assert status in (0, 1), message
    found: dict[str, Any] = json.loads(output)
    return found


def found_effects(record: dict[str, Any]) -> dict[str, dict[str, tuple[float, float]]]:
    return {
        effect["name"]: {name: (p["value"], p["sigma"]) for name, p in effect["parameters"].items()}
        for effect in record["effects"]
    }


def test_nothing_hidden_in_the_example(tmp_path: Path, run_flexura: Run) -> None:
    status, output, message = run_flexura("gap", EXAMPLE, "--json", "--out", tmp_path / "run")
    record = json.loads(output)
    assert (status, record["verdict"], record["effects"]) == (0, "none", []), message


@pytest.mark.parametrize("kilograms", [0.002])
def test_a_mass_on_a_sheet_of_metal(tmp_path: Path, run_flexura: Run, kilograms: float) -> None:
    declared = read_experiment(EXAMPLE)
    record = compared(run_flexura, tmp_path / "plate", declared, with_mass(declared, kilograms))
    found = found_effects(record)
    assert set(found) == {"point_mass"}, record["verdict"]
    assert found["point_mass"]["mass"][0] == pytest.approx(kilograms, rel=0.03)


def test_springs_under_a_sheet_of_metal(tmp_path: Path, run_flexura: Run) -> None:
    declared = read_experiment(EXAMPLE)
    found = found_effects(compared(run_flexura, tmp_path / "plate", declared, on_springs(declared, 2000.0)))
    assert set(found) == {"suspension"}
    assert found["suspension"]["stiffness"][0] == pytest.approx(2000.0, rel=0.05)


def test_nothing_hidden_in_a_plate_with_patch_accelerometer_and_laser(tmp_path: Path, run_flexura: Run) -> None:
    record = compared(run_flexura, tmp_path / "plate", mixed(), mixed(), polypropylene)
    assert (record["verdict"], record["effects"]) == ("none", [])


def test_a_mass_on_a_plate_with_patch_accelerometer_and_laser(tmp_path: Path, run_flexura: Run) -> None:
    record = compared(run_flexura, tmp_path / "plate", mixed(), with_mass(mixed(), 0.0008), polypropylene)
    found = found_effects(record)
    assert set(found) == {"point_mass"}, record["verdict"]
    assert found["point_mass"]["mass"][0] == pytest.approx(0.0008, rel=0.03)


def test_a_mass_on_a_plate_that_two_hammers_hit(tmp_path: Path, run_flexura: Run) -> None:
    """One campaign of both, a gain for each: the cell of the second reads a quarter more than there is."""
    table = mixed().model_dump(mode="json")
    table["drive"].append({"id": "second", "kind": "force", "point": [0.05, 0.045]})
    declared = Experiment.model_validate(table)
    folder, maker = tmp_path / "plate", runpy.run_path(str(MAKER))
    (folder / "sweeps").mkdir(parents=True)
    (folder / DECLARATION).write_text(toml_text(declared.model_dump(mode="json"), ""), encoding="utf-8")
    rng = np.random.default_rng(12)
    temperatures = declared.protocol.temperatures
    for source, (drive, read) in enumerate(zip(declared.drive, (1.0, 1.25), strict=True)):
        alone = declared.model_copy(update={"drive": (drive,)})
        twin = maker["plate"](with_mass(alone, 0.001), polypropylene)
        for step, temperature in enumerate(temperatures):
            root = {
                "oven_temperature_start": temperature,
                "oven_temperature_end": temperature,
                "direction": "up",
                "level": 2.0,
                "actuator": drive.id,
                "step": source * len(temperatures) + step,
                "start_time": f"2026-01-05T{8 + step:02d}:{10 * source:02d}:00",
            }
            hits = maker["hits"](alone, twin, polypropylene(temperature), rng)
            hits = [{**channels, "drive": read * channels["drive"]} for channels in hits]
            path = folder / "sweeps" / f"{drive.id}_{step:03d}.tdms"
            maker["write_sweep"](path, alone, root, hits)
    run = tmp_path / "run"
    status, output, message = run_flexura("gap", folder, "--json", "--out", run)
    assert status == 0, message
    record = json.loads(output)
    found = found_effects(record)
    assert set(found) == {"point_mass"}, record["verdict"]
    assert found["point_mass"]["mass"][0] == pytest.approx(0.001, rel=0.03)
    twin = tomllib.loads((run / "twin.toml").read_text(encoding="utf-8"))
    gains = [twin["gain"]["value"], twin["further_gain"][0]["value"]]
    assert gains == pytest.approx([maker["CALIBRATION"], maker["CALIBRATION"] / 1.25], rel=0.02)
