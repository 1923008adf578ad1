"""The twin with effects, driven by a hammer and read by a patch, an accelerometer and a laser."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.library import library
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

BAND = (100.0, 500.0)
LINES = np.linspace(*BAND, 40)
POINT = SweepPoint(24.0, 0.4 / 60.0, 2.0)
LAWS = LocalLaws(
    23.0, np.array([np.log(2e9), 0.38, np.log(0.06)]), np.array([-0.02, 0.002, -0.01]), np.array([1e-4, 0.0, 1e-4])
)
PLACES = ((0.07, 0.06), (0.17, 0.12), (0.1, 0.15))
MASS = 0.004


@pytest.fixture(scope="module")
def operators(declare, patches, coarse_mesh):
    """With strings where the transducers are: what a plate does at points is what it does at small footprints."""
    plain = declare(patches, BAND, strings=PLACES)
    box = MaterialBox((1e9, 3.2e9), (0.33, 0.46), (0.02, 0.12))
    ops = reduce_with_effects(plain, box, fineness=Fineness(coarse_mesh, degree=3, tolerance=0.0))[0]
    return replace(ops, footprints=ops.deflection[: len(PLACES)])


@pytest.fixture(scope="module")
def experiment(declare, patches):
    hammer, accelerometer, laser = PLACES
    dumped = declare(patches, BAND, strings=PLACES).model_dump()
    return Experiment.model_validate(
        dumped
        | {
            "patch": [dumped["patch"][0] | {"role": "open"}, dumped["patch"][1]],
            "drive": [{"id": "hammer", "point": hammer, "radius": 0.0}],
            "sensor": [
                {"id": "acc", "kind": "acceleration", "point": accelerometer, "radius": 0.0, "mass": MASS},
                {"id": "laser", "kind": "velocity", "point": laser},
            ],
        }
    )


@pytest.fixture(scope="module")
def twin(experiment, operators):
    return replace(Twin.of(experiment, EffectPlate(operators), library(experiment)), reach=np.inf).referred(LAWS)


@pytest.mark.parametrize(
    ("effect", "values", "parameter", "step"),
    [
        ("orthotropy", {"delta_e": 0.03, "delta_g": 0.02}, "delta_e", 1e-4),
        ("bond_shear_lag", {"gamma25": 0.1, "softening": 0.03}, "gamma25", 1e-3),
        ("suspension", {"stiffness": 200.0, "damping": 0.3}, "damping", 1e-3),
        ("point_mass", {"mass": 0.001}, "mass", 1e-6),
        ("high_pass", {"corner": 5.0}, "corner", 1e-2),
        ("amplitude_softening", {"a": 1e-3, "b": 1e-3}, "a", 1e-5),
        ("thermal_gradient", {"gx": 1.0, "gy": 0.5}, "gx", 1e-1),
    ],
)
def test_derivatives_of_every_kind_of_output(twin, effect, values, parameter, step):
    line = twin.linearise(LAWS, LINES, {effect: values}, POINT, [(effect, parameter, values)])
    moved = [
        twin.frf(LAWS, LINES, {effect: {**values, parameter: values[parameter] + k * step}}, POINT)
        for k in (1, -1, 2, -2)
    ]
    quotient = (8.0 * (moved[0] - moved[1]) - (moved[2] - moved[3])) / (12.0 * step)
    assert line.transfer.shape == (3, LINES.size)
    error = np.abs(line.by_parameter[0] - quotient).max(axis=1)
    rounding = 1e-10 * np.abs(moved[0]).max(axis=1) / step
    assert np.all(error < 1e-5 * np.abs(quotient).max(axis=1) + rounding)


def test_derivatives_by_the_material(twin):
    line = twin.linearise(LAWS, LINES, point=POINT)
    for law in range(3):
        d = 1e-4 * np.eye(3)[law]
        one, other, two, third = (
            twin.frf(replace(LAWS, value=LAWS.value + s * d), LINES, point=POINT) for s in (1, -1, 2, -2)
        )
        quotient = (8.0 * (one - other) - (two - third)) / 12e-4
        error = np.abs(line.by_material[law] - quotient).max(axis=1)
        assert np.all(error < 5e-6 * np.abs(quotient).max(axis=1))


def test_the_accelerometers_mass_is_a_point_mass(twin, experiment):
    """Declared, or as the effect of a string's place: the cable's point moved under the accelerometer."""
    dumped = experiment.model_dump()
    light = {**dumped["sensor"][0], "mass": 0.0}
    bare = Experiment.model_validate(
        dumped | {"sensor": [light, dumped["sensor"][1]], "cable": [{"point": PLACES[1]}]}
    )
    other = replace(Twin.of(bare, EffectPlate(twin.plate.operators), library(bare)), reach=np.inf)
    loaded = other.frf(LAWS, LINES, {"point_mass": {"mass": MASS}}, POINT)
    declared = twin.frf(LAWS, LINES, point=POINT)
    assert np.abs(loaded - declared).max() < 1e-8 * np.abs(declared).max()


def test_a_motion_is_read_as_often_differentiated_as_declared(twin, experiment):
    sensors = [
        {"id": kind, "kind": kind, "point": PLACES[2]} for kind in ("displacement", "velocity", "acceleration")
    ]
    sensors[2]["radius"] = 0.0
    dumped = experiment.model_dump()
    moving = Experiment.model_validate(dumped | {"sensor": sensors})
    operators = replace(twin.plate.operators, footprints=twin.plate.operators.footprints[[0, 2, 2, 2]])
    w, v, a = replace(Twin.of(moving, EffectPlate(operators), library(moving)), reach=np.inf).frf(
        LAWS, LINES, point=POINT
    )[1:]
    omega = 2 * np.pi * LINES
    assert v == pytest.approx(1j * omega * w, rel=1e-10)
    assert a == pytest.approx(-(omega**2) * w, rel=1e-10)


def test_effects_of_patches_need_patches(experiment):
    dumped = experiment.model_dump()
    without = Experiment.model_validate(dumped | {"patch": []})
    gone = {"bond_shear_lag", "piezo_drift", "feedthrough", "sensor_offset", "patch_debond", "patch_loss"}
    gone |= {"piezo_loss", "permittivity_drift", "insulation_leak", "depolarization"}
    assert set(library(without)) == set(library(experiment)) - gone
    assert "feedthrough" not in library(experiment)  # the drive is no voltage


def test_undeclared_footprints_are_refused(experiment, operators):
    bare = replace(operators, footprints=np.zeros((0, 0)))
    with pytest.raises(ValueError, match="3 footprints are declared, the reduced plate holds 0"):
        Twin.of(experiment, EffectPlate(bare), library(experiment)).frf(LAWS, LINES, point=POINT)


def test_ports_are_patches_then_footprints(experiment):
    instruments = Instruments.of(experiment)
    assert (instruments.source, instruments.connected, instruments.seen) == (2, (1, 0), (1, 0, 3, 4))


@pytest.fixture(scope="module")
def joint(experiment, operators):
    """Make the twin that a patch and the hammer drive in turn, and that of the hammer, the patch held at 0 V."""
    dumped = experiment.model_dump()

    def with_patch(role):
        changed = Experiment.model_validate(
            dumped | {"patch": [dumped["patch"][0] | {"role": role}, dumped["patch"][1]]}
        )
        return replace(Twin.of(changed, EffectPlate(operators), library(changed)), reach=np.inf).referred(LAWS)

    return with_patch("actuator"), with_patch("shorted")


def test_only_a_voltage_leaks_past_the_plate(joint):
    both, _ = joint
    gain = 0.01
    for source, leaks in ((0, [gain, 0.0, 0.0]), (1, [0.0, 0.0, 0.0])):
        point = replace(POINT, source=source)
        plain, fed = (both.frf(LAWS, LINES, on, point) for on in ({}, {"feedthrough": {"gain": gain}}))
        np.testing.assert_allclose(fed - plain, np.tile(np.array(leaks)[:, None], LINES.size), atol=1e-12)


def test_whichever_input_drives_strain_is_counted_from_that_of_the_first(joint):
    both, hammer = joint
    on = {"amplitude_softening": {"a": 0.05, "b": 0.1}}
    louder = SweepPoint(POINT.temperature, POINT.rate, 30.0, source=1)
    same_unit = replace(hammer, peak_energy=both.peak_energy)
    expected = same_unit.frf(LAWS, LINES, on, replace(louder, source=0))
    np.testing.assert_allclose(both.frf(LAWS, LINES, on, louder), expected, rtol=1e-9)
    assert both.peak_energy != pytest.approx(hammer.peak_energy, rel=0.1)
    found = both.linearise(LAWS, LINES, on, louder, [("amplitude_softening", "a", {})])
    stepped = [
        both.frf(LAWS, LINES, {"amplitude_softening": {"a": 0.05 + s * 1e-5, "b": 0.1}}, louder) for s in (1, -1)
    ]
    numeric = (stepped[0] - stepped[1]) / 2e-5
    assert np.abs(found.by_parameter[0] - numeric).max() < 1e-4 * np.abs(numeric).max()


def test_an_undeclared_mass_of_an_accelerometer_is_the_declared_one(twin, experiment):
    dumped = experiment.model_dump()
    light = {**dumped["sensor"][0], "mass": 0.0}
    bare = Experiment.model_validate(dumped | {"sensor": [light, dumped["sensor"][1]]})
    other = replace(Twin.of(bare, EffectPlate(twin.plate.operators), library(bare)), reach=np.inf)
    loaded = other.frf(LAWS, LINES, {"accelerometer_mass": {"mass": MASS}}, POINT)
    np.testing.assert_allclose(loaded, twin.frf(LAWS, LINES, point=POINT), rtol=1e-9)
    assert "accelerometer_mass" not in library(experiment)
