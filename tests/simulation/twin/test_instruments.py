"""Forces, motions and charges on a coarse plate: reciprocity, modal sums, limits, and the full model."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from simulation.reduction.plate_basis import reduce_with_footprints
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.unknowns import factorize
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments, Pickup
from simulation.twin.twin import Twin

LOAD = ElectricLoad(305e3, 120e-12)
MATERIAL = (2.1e9, 0.372, 0.071)
LINES = np.linspace(110.0, 690.0, 60)
HAMMER, ACCELEROMETER, LASER = (
    Footprint((0.07, 0.06), 0.002, -1.0),
    Footprint((0.17, 0.12), 0.004, 1.0, 0.004),
    Footprint((0.1, 0.15), 0.0, 1.0),
)


@pytest.fixture(scope="module")
def reduced(coarse_model):
    box = MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1))
    return reduce_with_footprints(coarse_model, box, (100.0, 700.0), (HAMMER, ACCELEROMETER, LASER))[0]


@pytest.fixture(scope="module")
def experiment(declare, three_patches):
    plain = declare(three_patches, (100.0, 700.0))
    roles = {patch.id: "shorted" if patch.role == "actuator" else patch.role for patch in three_patches}
    declared = plain.model_dump() | {
        "patch": [patch.model_dump() | {"role": roles[patch.id]} for patch in three_patches],
        "drive": [{"id": "hammer", "point": HAMMER.point}],
        "sensor": [
            {"id": "acc", "kind": "acceleration", "point": ACCELEROMETER.point, "mass": ACCELEROMETER.mass},
            {"id": "laser", "kind": "velocity", "points": [LASER.point]},
        ],
    }
    return Experiment.model_validate(declared)


@pytest.fixture(scope="module")
def twin(experiment, reduced):
    return Twin.of(experiment, DeclaredPlate(reduced))


def read(reduced, source, pickups, connected=(), amplitude=1.0, load=LOAD):
    """Drive one port of the plate and read others, in all coordinates."""
    instruments = Instruments(source, amplitude, connected, (load,) * len(connected), tuple(pickups))
    twin = Twin(DeclaredPlate(reduced), instruments, reach=np.inf)
    return twin.frf(LocalLaws.of_material(*MATERIAL), LINES)


def motion(port, order=0):
    return Pickup(port, voltage=False, order=order)


def test_what_is_declared_is_what_was_reduced(experiment):
    assert experiment.footprints == (HAMMER, ACCELEROMETER, LASER)


def test_reciprocity(reduced):
    """Maxwell: force here and motion there; and, patch on one side, V per N against m per V."""
    there, back = read(reduced, 3, [motion(5)]), read(reduced, 5, [motion(3)])
    assert np.abs(there - back).max() < 1e-9 * np.abs(there).max()
    # -b'u per volt's worth of force against u of the point per volt: q = -b' Z^-1 (-d F), w = d' Z^-1 (-b V)
    charge = read(reduced, 3, [motion(1)], amplitude=-1.0)
    deflection = read(reduced, 1, [motion(3)])
    assert np.abs(charge + deflection).max() < 1e-9 * np.abs(charge).max()


def test_a_force_and_a_deflection_are_a_modal_sum(reduced):
    """Modes with phi' phi = 1: w = sum of phi(there) phi(here) / (lambda - w^2), lambda = 0 of the rigid ones."""
    stiffness = reduced.stiffness(*MATERIAL)
    values, shapes = np.linalg.eig(stiffness)
    elastic = values.real > (2 * np.pi * 20.0) ** 2
    assert (~elastic).sum() == 3
    shapes = shapes / np.sqrt(np.einsum("ij,ij->j", shapes, shapes))
    here, there = (reduced.footprints[k] @ shapes[:, elastic] for k in (0, 2))
    omega2 = (2 * np.pi * LINES) ** 2
    expected = (here * there) @ (1.0 / (values[elastic, None] - omega2))
    rigid = np.linalg.eigh(stiffness.real)[1][:, :3]
    expected -= (reduced.footprints[0] @ rigid) @ (reduced.footprints[2] @ rigid) / omega2
    found = read(reduced, 3, [motion(5)], amplitude=-1.0)[0]  # a force along z
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_velocity_and_acceleration_are_derivatives_of_the_deflection(reduced):
    w, v, a = read(reduced, 3, [motion(5, order) for order in range(3)], connected=(1, 2))
    omega = 2 * np.pi * LINES
    assert v == pytest.approx(1j * omega * w, rel=1e-12)
    assert a == pytest.approx(-(omega**2) * w, rel=1e-12)


def test_charge_is_what_a_large_input_capacitance_takes(reduced):
    large = 1e-3
    voltage = read(reduced, 3, [Pickup(1)], connected=(1,), load=ElectricLoad(1e12, large))
    charge = read(reduced, 3, [motion(1)])
    assert np.abs(large * voltage - charge).max() < 1e-4 * np.abs(charge).max()


def test_an_open_patch_stiffens_the_plate_and_a_shorted_one_does_not(experiment, reduced):
    def frf(role):
        patches = [patch.model_copy(update={"role": role}) for patch in experiment.patch]
        changed = experiment.model_copy(update={"patch": tuple(patches)})
        twin = replace(Twin.of(changed, DeclaredPlate(reduced)), reach=np.inf)
        return twin.frf(LocalLaws.of_material(*MATERIAL), LINES)

    shorted, opened = frf("shorted"), frf("open")
    assert 1e-4 < np.abs(opened - shorted).max() / np.abs(shorted).max() < 0.5
    bare = read(reduced.loaded(np.array([0.0, ACCELEROMETER.mass, 0.0])), 3, [motion(4, 2), motion(5, 1)])
    assert np.abs(shorted - bare).max() < 1e-9 * np.abs(bare).max()


def test_voltages_and_motions_of_a_loaded_plate_against_the_full_model(coarse_model, twin):
    rows = coarse_model.footprint_rows((HAMMER, ACCELEROMETER, LASER))
    found = twin.frf(LocalLaws.of_material(*MATERIAL), LINES)
    for f in (LINES[7], LINES[31], LINES[52]):
        omega = 2 * np.pi * f
        stiffness = coarse_model.stiffness(*MATERIAL)
        factors = factorize(stiffness - omega**2 * coarse_model.mass)
        columns = np.hstack([coarse_model.coupling, rows.T])
        g = columns.T @ factors.solve(columns.astype(complex))
        # Sherman and Morrison: the mass adds a term of rank one; a push on the top face is a force along -z
        g = g + np.outer(g[:, 4], g[4]) / (1.0 / (omega**2 * ACCELEROMETER.mass) - g[4, 4])
        across = np.diag(coarse_model.capacitance[1:] + LOAD.capacitance + 1.0 / (1j * omega * LOAD.resistance))
        volts = -np.linalg.solve(across + g[1:3, 1:3], g[1:3, 3])
        w = -(g[4:, 3] + g[4:, 1:3] @ volts)
        expected = np.array([*volts, -(omega**2) * w[0], 1j * omega * w[1]])
        size = np.sqrt(np.mean(np.abs(found) ** 2, axis=1))
        assert np.all(np.abs(found[:, f == LINES][:, 0] - expected) < 3e-4 * size)


@pytest.mark.parametrize("index", [0, 1, 2])
def test_sensitivities_equal_central_differences(twin, index):
    twin = replace(twin, reach=np.inf)
    line = twin.linearise(LocalLaws.of_material(*MATERIAL), LINES)
    # derivatives are by log E, nu and log eta
    value, slopes = line.transfer, line.by_material / np.array([MATERIAL[0], 1.0, MATERIAL[2]])[:, None, None]
    assert np.allclose(value, twin.frf(LocalLaws.of_material(*MATERIAL), LINES), rtol=1e-10)

    def central(step):
        up, down = list(MATERIAL), list(MATERIAL)
        up[index] += step
        down[index] -= step
        one, other = (twin.frf(LocalLaws.of_material(*there), LINES) for there in (up, down))
        return (one - other) / (2 * step)

    step = 2e-4 * MATERIAL[index]
    expected = (4 * central(step) - central(2 * step)) / 3
    assert slopes.shape == (3, 4, LINES.size)
    error = np.abs(slopes[index] - expected).max(axis=1)
    assert np.all(error < 1e-5 * np.abs(expected).max(axis=1))


def test_a_mass_lowers_every_mode_it_moves(reduced):
    heavier = reduced.loaded(np.array([0.0, 0.01, 0.0]))
    poles = [model.modal_form(*MATERIAL).damped_poles().real for model in (reduced, heavier)]
    bare, loaded = (np.sqrt(p[p < (2 * np.pi * reduced.band[1]) ** 2].clip(0.0)) / (2 * np.pi) for p in poles)
    count = min(len(bare), len(loaded))
    elastic = bare[:count] > 1.0  # rigid motions stay at 0 Hz, but for rounding
    assert np.all(loaded[:count][elastic] < bare[:count][elastic] * (1 + 1e-9))
    assert loaded[:count].sum() < 0.999 * bare[:count].sum()


def test_many_points_are_read_off_the_certified_field(coarse_model, reduced):
    many = (HAMMER, *(Footprint((0.02 + 0.012 * k, 0.1)) for k in range(16)))
    wide = reduce_with_footprints(coarse_model, reduced.box, reduced.band, many)[0]
    rows = coarse_model.footprint_rows(many)
    f = 365.0
    direct = factorize(coarse_model.stiffness(*MATERIAL) - (2 * np.pi * f) ** 2 * coarse_model.mass)
    expected = rows @ direct.solve(rows[0].astype(complex))
    modal = wide.modal_form(*MATERIAL)
    found = modal.compliance(wide.footprints.T, wide.footprints[:1].T, [f])[:, 0, 0]
    assert np.abs(found - expected).max() < 3e-4 * np.abs(expected).max()


def test_footprints_that_were_not_reduced_are_refused(experiment, reduced):
    with pytest.raises(ValueError, match="3 footprints are declared, the reduced plate holds 0"):
        Twin.of(experiment, replace(reduced, footprints=np.zeros((0, reduced.size))))
    with pytest.raises(ValueError, match="a voltage is read of a port"):
        Instruments(0, 1.0, (), (), (Pickup(1),))


def test_several_inputs_answer_as_each_alone(experiment, reduced):
    """Of inputs that drive in turn, patches at rest are held at 0 V and forces do not act."""
    dumped = experiment.model_dump()
    drivers = [patch | {"role": "actuator"} if patch["role"] == "shorted" else patch for patch in dumped["patch"]]
    both = Experiment.model_validate(dumped | {"patch": drivers})
    joint = Twin.of(both, DeclaredPlate(reduced))
    assert [one.id for one in both.inputs] == [*(p["id"] for p in drivers if p["role"] == "actuator"), "hammer"]
    hammer = Twin.of(experiment, DeclaredPlate(reduced))
    laws = LocalLaws.of_material(*MATERIAL)
    point = SweepPoint(20.0, 0.0, 1.0, source=1)
    expected = hammer.linearise(laws, LINES)
    found = joint.linearise(laws, LINES, point=point)
    np.testing.assert_allclose(joint.frf(laws, LINES, point=point), expected.transfer, rtol=1e-12)
    np.testing.assert_allclose(found.by_material, expected.by_material, rtol=1e-9)
    first = Instruments.of(both, both.inputs[0])
    alone = Twin(DeclaredPlate(reduced), first, both).frf(laws, LINES)
    np.testing.assert_allclose(joint.frf(laws, LINES), alone, rtol=1e-12)
    assert np.abs(alone[-1] - expected.transfer[-1]).max() > 0.1 * np.abs(alone[-1]).max()


def test_parts_of_modes_make_up_what_changes_with_the_modulus(twin):
    """d/d log E moves every mode of a plate whose patches are thin by half, and d/d log eta turns it."""
    laws, eta = LocalLaws.of_material(*MATERIAL), MATERIAL[2]
    line, found = twin.linearise(laws, LINES), twin.modal_parts(laws, LINES)
    assert found.parts.shape == (len(found.poles), len(line.transfer), LINES.size)
    shift = 0.5 * found.by_pole.sum(axis=0)
    loss = 1j * eta / (1.0 + 1j * eta) * shift
    for k in range(len(shift)):
        size = np.abs(line.by_material[0, k]).max()
        assert np.abs(shift[k] - line.by_material[0, k]).max() < 0.1 * size
        assert np.abs(loss[k] - line.by_material[2, k]).max() < 0.1 * np.abs(line.by_material[2, k]).max()


def test_parts_of_modes_add_up_near_resonances(twin):
    """What they leave is a background of far modes, without resonances."""
    laws = LocalLaws.of_material(*MATERIAL)
    transfer, found = twin.frf(laws, LINES), twin.modal_parts(laws, LINES)
    rest = transfer - found.parts.sum(axis=0)
    bend = np.abs(np.diff(rest, 2, axis=1)).max(axis=1)
    assert (bend < 0.02 * np.abs(np.diff(transfer, 2, axis=1)).max(axis=1)).all()


def test_a_mode_has_one_place_at_all_temperatures(twin):
    """A stiffer plate has fewer modes in the band, each with the number that it has in a soft one."""
    soft, stiff = (twin.modal_parts(LocalLaws.of_material(e, 0.37, 0.07), LINES) for e in (1.6e9, 2.9e9))
    both = min(len(soft.poles), len(stiff.poles))
    assert both < len(soft.poles)
    ratio = np.sqrt(stiff.poles[:both].real / soft.poles[:both].real)[6:]
    assert ratio == pytest.approx(np.sqrt(2.9 / 1.6), rel=0.05)
