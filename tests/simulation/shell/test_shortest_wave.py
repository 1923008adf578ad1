"""Cells small enough for the shortest wave, whose length is checked against two independent solutions."""

import numpy as np
import pytest

from analysis.declaration.outline import CircleOutline
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness, shortest_wave
from tests.simulation.verification.exact_plates import PlateWaves

BOX = MaterialBox((0.8e9, 4e9), (0.30, 0.49), (0.02, 0.15))
DISC = CircleOutline(kind="circle", center=(0.0, 0.0), radius=0.1)


def disc(thickness: float = 0.003) -> Plate:
    return Plate(outline=DISC, thickness=thickness, mass=950.0 * np.pi * 0.01 * thickness)


def test_a_thin_plate_has_kirchhoffs_wave() -> None:
    plate, band = disc(0.0005), (100.0, 500.0)
    stiffness, mass = 0.8e9 * 0.0005**3 / 12.0 / (1.0 - 0.3**2), 950.0 * 0.0005
    kirchhoff = 2.0 * np.pi * (stiffness / mass / (2.0 * np.pi * 500.0) ** 2) ** 0.25
    assert shortest_wave(plate, BOX, band) == pytest.approx(kirchhoff, rel=2e-3)


def test_a_thick_plate_has_the_wave_of_the_exact_solutions() -> None:
    """At a wavelength of three thicknesses Kirchhoff's would be a third too long."""
    h, nu, top = 0.02, 0.3, 12e3
    stiffness = 0.8e9 * h**3 / 12.0 / (1.0 - nu**2)
    omega = 2.0 * np.pi * top * 0.1**2 * np.sqrt(950.0 * h / stiffness)
    squared = np.max(PlateWaves(h / 0.1, nu).bending(np.array([omega]))[0])
    found = shortest_wave(disc(h), BOX, (100.0, top))
    assert found == pytest.approx(2.0 * np.pi * 0.1 / np.sqrt(squared), rel=1e-9)
    assert found < 4.0 * h


@pytest.mark.parametrize("top", [1500.0, 3000.0])
def test_little_energy_is_above_the_highest_degree(top: float) -> None:
    """A disc without small cells in its middle: with cells of 40 mm, 4e-5 and 3e-3 of the energy."""
    patches = [
        Patch(id="A", role="actuator", center=(-0.03, 0.02), diameter=0.02, thickness=0.0005),
        Patch(id="S", role="sensor", center=(0.04, 0.015), diameter=0.02, thickness=0.0005),
    ]
    assert assemble_for(disc(), patches, BOX, (100.0, top), fineness=Fineness()).dropped < 1e-5


@pytest.mark.parametrize("angle", [0.0, 35.0])
def test_the_wave_of_a_sheet_is_that_across_its_grain(angle: float) -> None:
    sheet = {"youngs_modulus_x": 4.6e9, "youngs_modulus_y": 0.4e9, "shear_modulus": 0.4e9, "angle": angle}
    material = {"youngs_modulus": (1.5e9, 4e9), "poisson_ratio": (0.1, 0.3), "loss_factor": (0.01, 0.1)}
    plate = Plate.model_validate({**disc(0.0005).model_dump(), "material": {**material, "orthotropy": sheet}})
    assert plate.material is not None
    across = 2.0 * 1.5e9 * 0.4 / (4.6 + 0.4)  # of the softest material in the ranges
    stiffness, mass = across * 0.0005**3 / 12.0 / (1.0 - 0.1**2), 950.0 * 0.0005
    kirchhoff = 2.0 * np.pi * (stiffness / mass / (2.0 * np.pi * 500.0) ** 2) ** 0.25
    assert shortest_wave(plate, plate.material.box, (100.0, 500.0)) == pytest.approx(kirchhoff, rel=4e-3)
