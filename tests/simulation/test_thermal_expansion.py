"""A plate that grows with temperature: against the same plate declared in its grown dimensions."""

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.declaration.plate import Plate
from analysis.material import LocalLaws, Material
from analysis.updating.laws import fit_laws
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.twin import Twin

ALPHA, AT = 1.5e-4, 23.0
LAWS = LocalLaws.of_material(2.1e9, 0.372, 0.071, reference=60.0, slope=(-0.02, 3e-4, 0.01))


def test_a_bare_plate_that_has_grown_is_as_stiff_as_one_of_a_larger_modulus():
    growth = 1.05  # so that a wrong power shows
    places = np.array([(0.05, 0.03), (0.17, 0.11)])
    recipe, found = MeshRecipe(spacing=0.06, strip=2.0, edge_strip=2.0), []
    for g, modulus in ((growth, 2.0e9), (1.0, growth * 2.0e9)):
        plate = Plate(length_x=0.24 * g, length_y=0.19 * g, thickness=0.003 * g, mass=0.13)
        scaled = MeshRecipe(spacing=recipe.spacing * g**0.5, strip=2.0, edge_strip=2.0)
        model = assemble(plate, [], recipe=scaled, degree=4)
        discs = [Footprint((float(x), float(y)), 0.002 * g) for x, y in places * g]
        rows = model.footprint_rows(discs)
        stiffness = model.stiffness(modulus, 0.37)
        z = stiffness.toarray() - (2 * np.pi * 400.0) ** 2 * model.mass.toarray()
        found.append(rows @ np.linalg.solve(z, rows.T))
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_laws_of_a_plate_that_grows():
    temperature = np.linspace(50.0, 70.0, 5)
    growth = 1.0 + ALPHA * (temperature - AT)
    grown = LAWS.grown(ALPHA, AT)
    assert grown.youngs_modulus(temperature) == pytest.approx(growth * LAWS.youngs_modulus(temperature), rel=1e-8)
    assert grown.poisson_ratio(temperature) == pytest.approx(LAWS.poisson_ratio(temperature), rel=1e-15)
    assert grown.loss_factor(temperature) == pytest.approx(LAWS.loss_factor(temperature), rel=1e-15)
    wide = np.linspace(0.0, 60.0, 13)
    values = Material(
        *(np.asarray(law(wide)) for law in (LAWS.youngs_modulus, LAWS.poisson_ratio, LAWS.loss_factor))
    )
    laws = fit_laws(wide, values, Material(1e6 * np.ones(13), 1e-4 * np.ones(13), 1e-4 * np.ones(13)))
    ratio = laws.grown(ALPHA, AT).at(wide).youngs_modulus / laws.at(wide).youngs_modulus
    assert ratio == pytest.approx(1.0 + ALPHA * (wide - AT), rel=1e-6)


def test_a_twin_of_a_plate_that_grows(declare, three_patches, coarse):
    still = declare(three_patches, (100.0, 700.0))
    growing = still.model_copy(
        update={"plate": still.plate.model_copy(update={"expansion": ALPHA, "dimensions_at": AT})}
    )
    lines = np.array([150.0, 320.0, 610.0])
    plain, grown = (Twin.of(one, DeclaredPlate(coarse)) for one in (still, growing))
    as_stiff = LocalLaws.of_material(2.1e9 * (1.0 + ALPHA * (60.0 - AT)), 0.372, 0.071, reference=60.0)
    laws = LocalLaws.of_material(2.1e9, 0.372, 0.071, reference=60.0)
    assert grown.frf(laws, lines) == pytest.approx(plain.frf(as_stiff, lines), rel=1e-9)
    assert grown.frf(laws, lines) != pytest.approx(plain.frf(laws, lines), rel=1e-3)


def test_a_plate_grows_from_a_temperature_that_is_declared():
    with pytest.raises(ValueError, match="dimensions_at is missing"):
        Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.13, expansion=ALPHA)


def test_a_twin_answers_in_all_of_its_box_however_the_plate_has_grown(declare, three_patches, coarse):
    still = declare(three_patches, (100.0, 700.0))
    plate = still.plate.model_copy(update={"expansion": ALPHA, "dimensions_at": AT})
    twin = Twin.of(still.model_copy(update={"plate": plate}), DeclaredPlate(coarse))
    low, high = twin.box.youngs_modulus
    assert coarse.box.youngs_modulus[0] < low < high < coarse.box.youngs_modulus[1]
    for temperature in (-80.0, 20.0, 200.0):
        for modulus in (low, high):
            twin.frf(LocalLaws.of_material(modulus, 0.37, 0.07, reference=temperature), [300.0])
