"""A plate with effects answers to forces as well as to patches in states that it was not declared in."""

import numpy as np
import pytest

from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.library import library, untried
from simulation.reduction.effect_certification import CERTIFIED_LINES, STEEPEST_SLOPES, extreme_states, state_error
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.shell.points import attached_discs
from simulation.state.field_basis import field_basis
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

BAND = (100.0, 500.0)
BOX = MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1))


@pytest.fixture(scope="module")
def experiment(declare, patches):
    table = declare(patches, BAND).model_dump()
    return Experiment.model_validate(
        table
        | {
            "patch": [],
            "drive": [{"id": "hammer", "point": (0.07, 0.06)}],
            "sensor": [{"id": "acc", "kind": "acceleration", "point": (0.17, 0.12), "mass": 0.001}],
        }
    )


@pytest.fixture(scope="module")
def reduced(experiment, coarse_mesh):
    return reduce_with_effects(experiment, BOX, fineness=Fineness(coarse_mesh, degree=4, tolerance=1e-6))


def test_every_state_against_the_full_plate(experiment, reduced):
    ops, full, _ = reduced
    basis, rng = field_basis(BENDING_DEGREE), np.random.default_rng(3)
    laws = LocalLaws.of_material(2.2e9, 0.37, 0.05, slope=STEEPEST_SLOPES)
    attached = attached_discs(experiment.plate, experiment.attachments)
    acting = [*attached, *experiment.footprints]
    for size in (1.0, -1.0):
        small = extreme_states(basis.xi, basis.zeta, laws, 0.0, size)
        for few, exact in zip(small, extreme_states(*full.sampling, laws, 0.0, size), strict=True):
            assert state_error(full, ops, few, exact, int(rng.integers(CERTIFIED_LINES)), acting) < 3e-4
    assert 0.0 < ops.error < 1e-3


def test_a_plate_without_patches_has_effects(experiment, reduced):
    effects = library(experiment)
    assert {"orthotropy", "point_mass", "suspension"} <= set(effects)
    assert {"sensor_offset", "bond_shear_lag", "piezo_drift"} <= set(untried(experiment))
    laws = LocalLaws.of_material(2.2e9, 0.37, 0.05)
    twin, point = Twin.of(experiment, EffectPlate(reduced[0]), effects), SweepPoint(laws.reference, 0.0, 1.0)
    low = np.array([BAND[0]])
    bare, loaded = (twin.frf(laws, low, values, point) for values in ({}, {"point_mass": {"mass": 0.002}}))
    assert bare.shape == (1, 1)
    assert abs(loaded[0, 0] / bare[0, 0] - 1.0) > 1e-3
