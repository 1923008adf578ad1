"""Campaigns made on another mesh and degree than the twin's return the material put in, from steel to PMMA."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.declaration.plate_material import material_box
from analysis.experiment import Patch, Plate
from analysis.material import LocalLaws
from analysis.recordings.frf import Frf
from analysis.updating.update import update
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble_for
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.fineness import Fineness
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

LOAD = ElectricLoad(305e3, 120e-12)
TEMPERATURE = np.array([10.0, 40.0])
OTHER = Fineness(MeshRecipe(spacing=0.055, strip=1.07, edge_strip=1.27, growth=0.9), degree=9, tolerance=2e-9)
Laws = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], ...]]

PLATES: dict[str, tuple[float, float, Laws]] = {  # density, thickness, E(T), nu(T), eta(T)
    "aluminium": (2700.0, 0.002, lambda t: (69e9 * (1 - 5e-4 * t), 0.33 + 0 * t, 1e-3 + 0 * t)),
    "steel": (7850.0, 0.001, lambda t: (208e9 * (1 - 2.5e-4 * t), 0.29 + 0 * t, 1e-3 + 0 * t)),
    "pmma": (1190.0, 0.003, lambda t: (5.2e9 * np.exp(-0.008 * t), 0.36 + 4e-4 * t, 0.055 + 3e-4 * t)),
    "pp-gf": (1120.0, 0.003, lambda t: (7e9 * np.exp(-0.01 * t), 0.37 + 8e-4 * t, 0.025 + 3e-4 * t)),
}


def twin(kind: str, patches: list[Patch], band: tuple[float, float], fineness: Fineness) -> Twin:
    density, thickness, _ = PLATES[kind]
    mass = density * 0.24 * 0.19 * thickness
    plate = Plate(length_x=0.24, length_y=0.19, thickness=thickness, mass=mass, material={"kind": kind})
    box = material_box(plate.material)
    reduced = reduce(assemble_for(plate, patches, box, band, fineness=fineness), box, band)[0]
    return Twin(DeclaredPlate(reduced), Instruments.of_patches(0, (1,), LOAD))


def measured(truth: Twin, constants: tuple[NDArray[np.float64], ...], spacing: float) -> Frf:
    """One sweep at each temperature; noise of 1 % of rms|H| and an amplifier of 12.3 V/V."""
    lines = np.arange(truth.band[0], truth.band[1], spacing)
    clean = 12.3 * np.array(
        [truth.frf(LocalLaws.of_material(*row), lines) for row in zip(*constants, strict=True)]
    )
    variance = np.full(clean.shape, 1e-4) * (np.abs(clean) ** 2).mean((1, 2), keepdims=True)
    real, imaginary = np.random.default_rng(1).standard_normal((2, *clean.shape)) * np.sqrt(variance / 2)
    count = len(clean)
    return Frf(
        temperature=TEMPERATURE,
        direction=("up",) * count,
        level=np.ones(count),
        frequency=lines,
        h=clean + real + 1j * imaginary,
        variance=variance,
        coherence=np.ones(clean.shape),
        excluded=np.zeros(lines.size, dtype=bool),
        channels=("S1",),
    )


def check(model: Twin, truth: Twin, kind: str, spacing: float) -> None:
    e, nu, eta = constants = PLATES[kind][2](TEMPERATURE)
    found = update(measured(truth, constants, spacing), model)
    assert found.settled.all()
    np.testing.assert_allclose(found.material.youngs_modulus, e, rtol=0.01)
    np.testing.assert_allclose(found.material.poisson_ratio, nu, atol=0.01)
    np.testing.assert_allclose(found.material.loss_factor, eta, rtol=0.03)


def test_sharp_resonances_update_in_a_short_band(patches: list[Patch], coarse_mesh: MeshRecipe) -> None:
    kind, band = "steel", (100.0, 400.0)
    model = twin(kind, patches, band, Fineness(coarse_mesh, degree=5, tolerance=1e-7))
    truth = twin(kind, patches, band, Fineness(replace(coarse_mesh, spacing=0.06), degree=6, tolerance=3e-8))
    check(model, truth, kind, 0.1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", PLATES)
def test_every_material_updates_over_the_whole_band(kind: str, patches: list[Patch]) -> None:
    """Other cells and degree 9 against the twin's own mesh."""
    band = (100.0, 1500.0)
    check(twin(kind, patches, band, Fineness()), twin(kind, patches, band, OTHER), kind, 0.4)
