"""The coarse plate against a finer one: resonances over a hundredfold range of moduli."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.experiment import Experiment, Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.coarse_plate import CoarsePlate
from simulation.shell.assembly import assemble
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize


@pytest.fixture(scope="module")
def experiment(declare: Callable[..., Experiment], three_patches: list[Patch]) -> Experiment:
    return declare(three_patches, (100.0, 700.0))


@pytest.fixture(scope="module")
def known(experiment: Experiment) -> CoarsePlate:
    return CoarsePlate.of(experiment, MaterialBox((0.5e9, 50e9), (0.34, 0.42), (0.01, 0.1)))


@pytest.fixture(scope="module")
def finer(plate: Plate, three_patches: list[Patch], coarse_mesh: MeshRecipe) -> ShellModel:
    return assemble(plate, three_patches, recipe=coarse_mesh, degree=5)


@pytest.mark.parametrize("modulus", [0.6e9, 2e9, 40e9])
def test_resonances_are_those_of_the_mesh(finer: ShellModel, known: CoarsePlate, modulus: float) -> None:
    full = finer.eigenfrequencies(modulus, 0.38, 40)
    full = full[(full > 100.0) & (full < 700.0)]
    stiffness = known.reduced.stiffness(modulus, 0.38, 0.0).real
    found = np.sqrt(np.abs(np.linalg.eigvalsh(stiffness))) / (2 * np.pi)
    assert full.size >= 2
    assert [np.abs(found / f - 1.0).min() for f in full] == pytest.approx([0.0] * full.size, abs=0.03)


def test_a_hammer_and_a_loaded_accelerometer_are_nearly_those_of_direct_solution(
    finer: ShellModel, experiment: Experiment
) -> None:
    hammer, accelerometer = (0.07, 0.06), (0.17, 0.12)
    dumped = experiment.model_dump()
    declared = dumped | {
        "patch": [patch | {"role": "shorted"} for patch in dumped["patch"]],
        "drive": [{"id": "hammer", "point": hammer, "side": "bottom"}],
        "sensor": [{"id": "acc", "kind": "acceleration", "point": accelerometer, "mass": 0.002}],
    }
    bare = Experiment.model_validate(declared)
    known = CoarsePlate.of(bare, MaterialBox((0.5e9, 50e9), (0.34, 0.42), (0.01, 0.1)))
    lines = np.linspace(150.0, 650.0, 6)
    found = known.frf(2e9, 0.38, lines)[0]
    assert [pickup.order for pickup in known.instruments.pickups] == [2]
    rows = finer.footprint_rows(bare.footprints)
    for f, a in zip(lines, found, strict=True):
        omega2 = (2 * np.pi * f) ** 2
        z = finer.stiffness(2e9, 0.38, 0.04) - omega2 * finer.mass
        g = rows @ factorize(z).solve(rows.T.astype(complex))
        loaded = g[1, 0] / (1.0 - omega2 * 0.002 * g[1, 1])  # Sherman and Morrison
        assert abs(a + omega2 * loaded) < 0.35 * np.abs(found).max()


def test_voltages_are_nearly_those_of_direct_solution(finer: ShellModel, known: CoarsePlate) -> None:
    lines = np.linspace(150.0, 650.0, 6)
    load = ElectricLoad(305e3, 1.2e-10)
    full = finer.frf(2e9, 0.38, 0.04, lines, actuator=0, sensors=(1, 2), load=load)
    wrong = np.abs(known.frf(2e9, 0.38, lines) - full)
    assert wrong.max() < 0.25 * np.abs(full).max()
