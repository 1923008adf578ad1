from dataclasses import replace

import numpy as np
import pytest

from analysis.declaration.plate_material import PlateMaterial
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.basis_key import BasisTraining, basis_key
from simulation.shell.fineness import Fineness

BOX, BAND = MaterialBox((1e9, 4e9), (0.3, 0.45), (0.02, 0.1)), (100.0, 900.0)


@pytest.fixture
def key(plate, patches):
    return basis_key(plate, patches, BOX, BAND)


def test_key_is_repeatable_and_hexadecimal(plate, patches, key):
    assert key == basis_key(plate.model_copy(), list(patches), BOX, BAND)
    assert len(bytes.fromhex(key)) == 32


def test_names_and_roles_do_not_count(plate, patches, key):
    renamed = [p.model_copy(update={"id": f"x{k}", "role": "actuator"}) for k, p in enumerate(patches)]
    assert basis_key(plate, renamed, BOX, BAND) == key


def test_everything_else_counts(plate, patches, key):
    moved = [patches[0].model_copy(update={"center": (0.2, 0.1551)}), patches[1]]
    turned = [patches[0].model_copy(update={"side": "bottom"}), patches[1]]
    points = np.array([[0.1, 0.1]])
    others = [
        basis_key(plate.model_copy(update={"thickness": 0.0031}), patches, BOX, BAND),
        basis_key(plate.model_copy(update={"boundary": "clamped"}), patches, BOX, BAND),
        basis_key(plate, moved, BOX, BAND),
        basis_key(plate, turned, BOX, BAND),
        basis_key(plate, patches[::-1], BOX, BAND),
        basis_key(plate, patches, replace(BOX, poisson_ratio=(0.3, 0.46)), BAND),
        basis_key(plate, patches, BOX, (100.0, 901.0)),
        basis_key(plate, patches, BOX, BAND, points),
        basis_key(plate, patches, BOX, BAND, points + 1e-12),
        basis_key(plate, patches, BOX, BAND, points, field_certified=False),
        basis_key(plate, patches, BOX, BAND, fineness=Fineness(degree=5)),
        basis_key(plate, patches, BOX, BAND, fineness=Fineness(tolerance=1e-8)),
        basis_key(plate, patches, BOX, BAND, fineness=Fineness(MeshRecipe(spacing=0.05))),
        basis_key(plate, patches, BOX, BAND, training=BasisTraining(tolerance=1e-5)),
    ]
    assert len({key, *others}) == len(others) + 1


def test_of_a_material_only_the_orthotropy_counts(plate, patches, key):
    """Ranges of an isotropic one are in the box; a sheet stiffer one way than the other is another plate."""

    def of(**material):
        return basis_key(plate.model_copy(update={"material": PlateMaterial(**material)}), patches, BOX, BAND)

    assert of(kind="pmma") == of(kind="steel") == key
    orthotropic = {"delta_e": 0.1, "delta_g": 0.0}
    turned = {**orthotropic, "angle": 20.0}
    assert len({key, *(of(kind="pp-gf", orthotropy=o) for o in (orthotropic, turned))}) == 3
