"""Plates in any state: against the plain assembly, plates of other constants, and beams of another modulus."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

from analysis.experiment import Plate
from analysis.material import LocalLaws
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import plane_stress_moduli
from simulation.shell.unknowns import factorize
from simulation.state.plate_state import PlateState
from simulation.state.state_matrices import FullPlate

E, NU, ETA = 2e9, 0.38, 0.06
LAWS = LocalLaws.of_material(E, NU, ETA, slope=(-0.02, 0.002, -0.01))
LINE = np.array([500.0])
MATRICES = ("plate", "plate_loss", "patches", "mass", "normal")


@pytest.fixture(scope="module")
def full(coarse_model) -> FullPlate:
    return FullPlate.of(coarse_model)


def state_of(full: FullPlate, laws: LocalLaws = LAWS) -> PlateState:
    return PlateState.baseline(*full.sampling, laws, laws.reference, LINE)


def assert_same(found, wanted, share=1e-12):
    assert abs(found - wanted).max() <= share * abs(wanted).max()


def assert_all_same(found, wanted):
    for name in (*MATRICES, "coupling"):
        assert_same(getattr(found, name), getattr(wanted, name))


def test_the_plain_state_is_the_plain_assembly(full, coarse_model):
    found = full.matrices(state_of(full))
    c1, c2 = plane_stress_moduli(E, NU)
    stiffness = c1 * coarse_model.stiffness_1 + c2 * coarse_model.stiffness_2
    assert_same(found.plate, stiffness)
    assert_same(found.plate_loss, ETA * stiffness)
    assert_same(found.patches, coarse_model.stiffness_patch)
    assert_same(found.mass, coarse_model.mass)
    assert_same(found.coupling, coarse_model.coupling)


def test_every_matrix_is_symmetric_whatever_the_state(full):
    state = state_of(full)
    state = state.with_(
        thickness=1.0 + 0.05 * (state.xi - state.zeta),
        temperature=state.temperature + 3.0 * state.xi,
        modulus_x=0.9,
        modulus_y=1.1,
        bond=0.7,
        offset_x=0.001,
        offset_y=-0.002,
    )
    matrices = full.matrices(state)
    for name in MATRICES:
        matrix = getattr(matrices, name)
        assert abs(matrix - matrix.T).max() <= 1e-15 * abs(matrix).max()


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.002, -0.0015)])
def test_an_offset_changes_no_weight(full, plate, three_patches, offset):
    """Motion without strain: a translation weighs what plate and patches weigh, wherever the sensor sits."""
    ceramics = full.shell.materials
    patches = sum(ceramics[p.material].density * p.thickness * p.area for p in three_patches)
    matrices = full.matrices(state_of(full).with_(offset_x=offset[0], offset_y=offset[1]))
    field, function = np.divmod(full.unknowns.chosen, full.shell.space.size)
    constant = function < len(full.shell.space.mesh.points)  # functions of points alone sum to one
    for component in (0, 1, 2):
        rigid = ((field == component) & constant).astype(float)
        assert rigid @ (matrices.mass @ rigid) == pytest.approx(plate.mass + patches, rel=1e-12)
        strain = rigid @ ((matrices.plate + matrices.patches) @ rigid)
        assert abs(strain) < 1e-9 * abs(matrices.plate).max()


def test_evenly_thicker_is_another_plate(full):
    plate = full.shell.plate
    found = full.matrices(state_of(full).with_(thickness=np.full(full.sampling[0].size, 1.02)))
    thicker = plate.model_copy(update={"thickness": 1.02 * plate.thickness, "mass": 1.02 * plate.mass})
    other = replace(full, shell=replace(full.shell, plate=thicker))  # on the same mesh
    assert_all_same(found, other.matrices(state_of(other)))


def test_a_gradient_is_nothing_to_a_material_without_slopes(full):
    laws = LocalLaws.of_material(E, NU, ETA)
    state = state_of(full, laws)
    tilted = state.with_(temperature=state.temperature + 5.0 * state.xi - 3.0 * state.zeta)
    assert_all_same(full.matrices(tilted), full.matrices(state))


def test_a_gradient_is_a_local_modulus(full):
    """Warm at one edge, a plate stores energies between those of the plain plate's warm and cold ones."""
    laws = LocalLaws.of_material(E, NU, ETA, slope=(-0.02, 0.0, 0.0))
    state = state_of(full, laws)
    warmer, colder = (full.matrices(state.with_(temperature=state.temperature + s * 2.0)) for s in (1, -1))
    plain = full.matrices(state)
    assert_same(warmer.plate, np.exp(-0.04) * plain.plate)
    assert_same(warmer.plate_loss, np.exp(-0.04) * plain.plate_loss)
    assert_same(warmer.patches, plain.patches)
    tilted = full.matrices(state.with_(temperature=state.temperature + 2.0 * state.xi))
    field = full.unknowns.chosen // full.shell.space.size
    bending = np.random.default_rng(2).standard_normal((full.unknowns.size, 20)) * (field >= 2)[:, None]
    energies = [np.einsum("nk,nk->k", bending, m.plate @ bending) for m in (warmer, tilted, colder)]
    assert (energies[0] < energies[1]).all()
    assert (energies[1] < energies[2]).all()


def test_without_a_bond_patches_bend_alone(full):
    loose, half, tight = (full.matrices(state_of(full).with_(bond=bond)) for bond in (0.0, 0.5, 1.0))
    assert abs(loose.coupling).max() == 0.0
    assert_same(half.coupling, 0.5 * tight.coupling)
    assert_same(half.patches, 0.5 * (loose.patches + tight.patches))
    field = full.unknowns.chosen // full.shell.space.size
    in_plane = np.flatnonzero(field < 2)
    assert abs(loose.patches[in_plane]).max() == 0.0
    assert_same(loose.mass, tight.mass)


def test_a_moved_sensor_is_a_sensor_declared_there(plate, three_patches, coarse_mesh):
    """Two meshes, one stretched and one made for the place: they differ by their discretisation error."""
    offset = (0.002, -0.0015)
    full = FullPlate.of(assemble(plate, three_patches, recipe=coarse_mesh, degree=6))
    there = [
        p.model_copy(update={"center": (p.center[0] + offset[0], p.center[1] + offset[1])}) if p.id == "S1" else p
        for p in three_patches
    ]
    declared = assemble(plate, there, recipe=coarse_mesh, degree=6)
    state = state_of(full).with_(offset_x=offset[0], offset_y=offset[1])
    for f in (160.0, 430.0):
        moved, still = (_compliance(full.matrices(s), f)[0, 1] for s in (state, state_of(full)))
        wanted = declared.compliance(E, NU, ETA, f)[0, 1, 0]
        assert abs(moved - wanted) < 0.02 * abs(wanted - still)
        assert abs(wanted - still) > 0.02 * abs(still)


def _compliance(matrices, frequency):
    z = matrices.plate + 1j * matrices.plate_loss + matrices.patches
    z = z - (2 * np.pi * frequency) ** 2 * matrices.mass
    return matrices.coupling.T @ factorize(z).solve(matrices.coupling.astype(complex))


@pytest.mark.parametrize("delta_e", [-0.1, 0.1])
def test_a_narrow_strip_bends_with_its_own_modulus(coarse_mesh, delta_e):
    """Free Euler beam along x: f = (4.7300/L)**2 sqrt(E_x h**2/(12 rho))/2 pi, the lowest two."""
    length, width, h, rho = 0.3, 0.01, 0.002, 900.0
    plate = Plate(length_x=length, length_y=width, thickness=h, mass=rho * length * width * h)
    full = FullPlate.of(assemble(plate, recipe=coarse_mesh, degree=5))
    state = state_of(full).with_(modulus_x=1.0 - delta_e, modulus_y=1.0 + delta_e)
    matrices = full.matrices(state)
    shift = (2 * np.pi * 5.0) ** 2
    squares = eigsh(
        matrices.plate + shift * matrices.mass, 10, matrices.mass, sigma=0.0, return_eigenvectors=False
    )
    found = np.sort(np.sqrt(np.abs(squares - shift))) / (2 * np.pi)
    roots = np.array([4.730041, 7.853205])
    beam = (roots / length) ** 2 * np.sqrt((1.0 - delta_e) * E * h**2 / (12.0 * rho)) / (2 * np.pi)
    elastic = found[found > 5.0]
    for frequency in beam:
        assert np.abs(elastic / frequency - 1.0).min() < 2e-3
