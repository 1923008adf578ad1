"""What a twin's reduced model rests on, kept for the effects that are added to it."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from analysis.experiment import Acquisition, Experiment, OvenDeclaration, Patch, Plate, Protocol
from analysis.material import MaterialBox
from app.files.basis_cache import basis_file, cached_reduction, load_plate_basis
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.reduction.plate_basis import PlateBasis
from simulation.shell.fineness import Fineness

BOX, BAND = MaterialBox((2e9, 3e9), (0.35, 0.4), (0.03, 0.1)), (100.0, 400.0)
COARSE = Fineness(
    MeshRecipe(spacing=0.08, strip=1.5, edge_strip=1.5, growth=2.0, grading=0.0, pieces=1),
    degree=3,
    tolerance=1e-5,
)
ROUGH = BasisTraining(tolerance=1e-2, lines=40)
EXPERIMENT = Experiment(
    title="a small plate",
    plate=Plate(length_x=0.12, length_y=0.1, thickness=0.003, mass=0.0342),
    patch=(
        Patch(id="A1", role="actuator", center=(0.09, 0.07), size=(0.02, 0.02), thickness=5e-4),
        Patch(id="S1", role="sensor", center=(0.04, 0.035), size=(0.02, 0.02), thickness=5e-4),
    ),
    acquisition=Acquisition(module="NI-9234", sample_rate=8e3, input_resistance=305e3, input_capacitance=1.2e-10),
    protocol=Protocol(
        sweep="linear",
        band=BAND,
        sweep_duration=2.0,
        tail=0.4,
        repeats=3,
        ramp_rate=0.4,
        temperatures=(20.0, 40.0),
        directions=("up", "down"),
        levels=(1.0,),
    ),
    oven=OvenDeclaration(room_temperature=22.0),
)
ASKED = {
    "plate": EXPERIMENT.plate,
    "patches": EXPERIMENT.patch,
    "box": BOX,
    "band": BAND,
    "attached": (),
    "fineness": COARSE,
    "training": ROUGH,
}


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLEXURA_CACHE", str(tmp_path_factory.mktemp("cache")))
        cached_reduction(**ASKED)
        yield basis_file(**ASKED)


@pytest.fixture(scope="module")
def basis(stored) -> PlateBasis:
    found = load_plate_basis(stored)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def alone():
    return reduce_with_effects(EXPERIMENT, BOX, fineness=COARSE, training=ROUGH)[0]


def test_effects_on_a_stored_basis_are_those_made_at_once(basis, alone):
    there = reduce_with_effects(EXPERIMENT, BOX, basis=basis, fineness=COARSE)[0]
    assert there.size == alone.size
    assert there.mass == pytest.approx(alone.mass, abs=1e-6 * np.abs(alone.mass).max())
    assert np.linalg.eigvalsh(there.bending[0, 0]) == pytest.approx(
        np.linalg.eigvalsh(alone.bending[0, 0]), rel=1e-4, abs=1e-6 * np.abs(alone.bending[0, 0]).max()
    )
    assert there.dropped == alone.dropped


def test_a_basis_of_another_mesh_is_made_again(basis, alone):
    turned = replace(basis, vectors=basis.vectors[::-1])
    assert (
        reduce_with_effects(EXPERIMENT, BOX, basis=turned, fineness=COARSE, training=ROUGH)[0].size == alone.size
    )
    fewer = replace(basis, kept=basis.kept[:, :-1])
    assert reduce_with_effects(EXPERIMENT, BOX, basis=fewer, fineness=COARSE, training=ROUGH)[0].size == alone.size


def test_a_damaged_basis_is_not_there(stored, tmp_path):
    raw = bytearray(stored.read_bytes())
    copy = tmp_path / stored.name
    copy.write_bytes(raw)
    with h5py.File(copy, "r+") as file:
        file["vectors"][3, 2] += 1e-9
    assert load_plate_basis(copy) is None
    assert load_plate_basis(tmp_path / "none.h5") is None
