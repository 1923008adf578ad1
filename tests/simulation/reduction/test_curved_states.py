"""A curved plate with patches in a state of effects: reduced energies against the full matrices."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.declaration.plate import Curvature
from analysis.experiment import Experiment, Patch
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.composition import Coefficients, composed
from simulation.reduction.effect_certification import combined_state, laws_within
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.state.field_basis import field_basis

BOX, BAND = MaterialBox((2.0e9, 3.0e9), (0.34, 0.4), (0.04, 0.1)), (100.0, 500.0)


@pytest.mark.slow
def test_energies_on_a_bumpy_plate_are_those_of_its_full_matrices(
    declare: Callable[..., Experiment], patches: list[Patch], coarse_mesh: MeshRecipe
) -> None:
    """With slopes up to 0.2, as declared and with all effects but the sensor's offset at half of their ranges."""
    flat = declare(patches, BAND)
    curvature = Curvature(height=((0.0, 0.004, 0.006), (0.003, 0.0, 0.0), (0.01, 0.0, 0.0)))
    experiment = flat.model_copy(update={"plate": flat.plate.model_copy(update={"curvature": curvature})})
    fineness = Fineness(coarse_mesh, degree=4, tolerance=1e-5)
    ops, full, vectors = reduce_with_effects(experiment, BOX, fineness=fineness)
    basis, laws = field_basis(BENDING_DEGREE), laws_within(BOX, (0.4, 0.6), 0.04)
    for size, share in ((0.0, 1e-11), (-0.5, 5e-4)):
        whole = composed(ops, Coefficients.of(combined_state(basis.xi, basis.zeta, laws, 0.0, size), ops))
        exact = full.matrices(combined_state(*full.sampling, laws, 0.0, size))
        for found, wanted in (
            (whole.plate, vectors.T @ (exact.plate @ vectors)),
            (whole.mass, vectors.T @ (exact.mass @ vectors)),
            (whole.fixed, vectors.T @ (exact.patches @ vectors)),
            (whole.coupling, vectors.T @ exact.coupling),
        ):
            assert np.abs(found - wanted).max() < share * np.abs(wanted).max()
