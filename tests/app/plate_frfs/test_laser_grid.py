"""A laser's grid of 200 points over a plate with one patch, at one temperature, from files to the twin."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox
from analysis.sweep_point import SweepPoint
from app.blind_trial.plates import OTHER_MESH
from app.files.plate_toml import read_plate_measurement
from app.files.uff58 import write_frfs
from app.plate_frfs.given_campaign import declared_experiment
from simulation.effects.library import library
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

Run = Callable[..., tuple[int, str, str]]
E_TRUE, NU_TRUE, ETA_TRUE = 1.55e9, 0.40, 0.05
HIDDEN, PLACE = 0.005, (0.16, 0.07)
LINES = np.arange(100.0, 1500.0, 1.0)
PLATE = """
format = "flexura-plate/1"
title = "polypropylene plate, laser grid"

[plate]
length_x = 0.24
length_y = 0.19
thickness = 0.003
mass = 0.12996

[[patch]]
id = "A1"
role = "actuator"
center = [0.2, 0.155]
size = [0.02, 0.02]
thickness = 0.0005
material = "NCE51"

[[sensor]]
id = "laser"
kind = "velocity"
grid = [20, 10]
margin = 0.008

[tolerances]
thickness = 0.0
mass = 0.0
length = 0.0
"""
FRF = '\n[[frf]]\nfile = "frfs.uff"\nunits = ["m/s", "V"]\ntemperature = 22.0\n'


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Write a test of the bare plate and one with a mass, 1 % noise; mesh and degree are not the twin's."""
    folder = tmp_path_factory.mktemp("grid")
    file = folder / "plate.toml"
    file.write_text(f"{PLATE}\n[[cable]]\npoint = [{PLACE[0]}, {PLACE[1]}]\n{FRF}", encoding="utf-8")
    said, rest = read_plate_measurement(file)
    experiment = declared_experiment(file, said, rest, (float(LINES[0]), float(LINES[-1])))
    box = MaterialBox((1.2e9, 2.0e9), (0.36, 0.44), (0.03, 0.09))
    plate = EffectPlate(reduce_with_effects(experiment, box, fineness=OTHER_MESH)[0])
    laws = LocalLaws(22.0, np.array([np.log(E_TRUE), NU_TRUE, np.log(ETA_TRUE)]), np.zeros(3), np.zeros(3))
    twin = Twin.of(experiment, plate, library(experiment), {})
    made = {}
    for name, effects in (("bare", {}), ("loaded", {"point_mass": {"mass": HIDDEN}})):
        h = twin.frf(laws, LINES, effects, SweepPoint(22.0, 0.0, 1.0))
        rng = np.random.default_rng(3)
        noise = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
        h = h + 0.01 / np.sqrt(2) * np.sqrt((np.abs(h) ** 2).mean(axis=1, keepdims=True)) * noise
        made[name] = folder / name
        made[name].mkdir()
        units = ("m/s", "V")
        frfs = [
            MeasuredTransfer(f"laser{k}", f"{k}:+3", "901:+3", "velocity", LINES, row, "voltage", units)
            for k, row in enumerate(h, start=1)
        ]
        write_frfs(made[name] / "frfs.uff", frfs)
        sensors = ", ".join(f'"{k}" = "laser{k}"' for k in range(1, len(h) + 1))
        declared = f"{PLATE}{FRF}sensors = {{ {sensors} }}\n"
        (made[name] / "plate.toml").write_text(declared, encoding="utf-8")
    return made


@pytest.mark.slow
def test_a_grid_gives_the_material(simulated: dict[str, Path], run_flexura: Run) -> None:
    status, out, said = run_flexura("update", simulated["bare"], "--json")
    assert status == 0, said
    (row,) = json.loads(out)["temperatures"]
    assert row["youngs_modulus_pa"] == pytest.approx(E_TRUE, rel=1e-3)
    assert row["poisson_ratio"] == pytest.approx(NU_TRUE, abs=5e-4)
    assert row["loss_factor"] == pytest.approx(ETA_TRUE, rel=0.01)
    points = json.loads(out)["pairing"]["points"]
    assert len(points["comac"]) == 200
    assert points["said"] == []


@pytest.mark.slow
def test_a_hidden_mass_is_named_and_located_on_a_grid(simulated: dict[str, Path], run_flexura: Run) -> None:
    status, out, said = run_flexura("gap", simulated["loaded"], "--json")
    assert status == 0, said
    (effect,) = json.loads(out)["effects"]
    found = {name: one["value"] for name, one in effect["parameters"].items()}
    assert effect["name"] == "mass_at_place"
    assert found["mass"] == pytest.approx(HIDDEN, rel=0.02)
    assert np.hypot(found["x"] - PLACE[0], found["y"] - PLACE[1]) < 0.01
