"""The smaller model of one campaign answers as the plate's does, and changes with every effect as it does."""

import numpy as np
import pytest

from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox
from simulation.reduction.campaign_basis import for_materials
from simulation.reduction.effect_certification import solved
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.state.extreme_states import STEEPEST, extreme_states
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import PlateState

BAND = (100.0, 500.0)
BOX = MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1))
LAWS = LocalLaws.of_material(2.2e9, 0.37, 0.05, slope=STEEPEST)
LINES = np.linspace(*BAND, 120)


@pytest.fixture(scope="module")
def operators(declare, patches, coarse_mesh):
    return reduce_with_effects(
        declare(patches, BAND), BOX, fineness=Fineness(coarse_mesh, degree=4, tolerance=1e-6)
    )[0]


def rms(values):
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def test_a_small_change_of_every_kind_is_that_of_the_plate(operators):
    """An offset of the sensor too, whose energies over the elements around it nearly cancel."""
    small = for_materials(operators, [LAWS])
    assert small.size < operators.size
    basis = field_basis(BENDING_DEGREE)
    plain = PlateState.baseline(basis.xi, basis.zeta, LAWS, LAWS.reference, np.array([500.0]))
    assert operators.offset_range > 0.0
    for state in extreme_states(basis.xi, basis.zeta, LAWS, operators.offset_range, 0.05):
        whole, few = (
            solved(ops, state, LINES, 0).compliance() - solved(ops, plain, LINES, 0).compliance()
            for ops in (operators, small)
        )
        assert rms(few - whole) < 0.02 * rms(whole)
