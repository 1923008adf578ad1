"""Insides of cells eliminated cell by cell, against the whole matrix solved at once."""

import numpy as np
import pytest

from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import ResponseProblem, first_inside, without_insides
from simulation.shell.rigidity import moduli
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.unknowns import Unknowns, elimination_order, factorize

MESH = MeshRecipe(spacing=0.15, edge_strip=3.0, growth=2.0, grading=0.0)


@pytest.mark.parametrize("curvature", [None, {"radius_x": 3.0}])
def test_answers_are_those_of_the_whole_matrix(
    plate: Plate, three_patches: list[Patch], curvature: dict[str, float] | None
) -> None:
    """Membrane and bending are coupled under a patch and on a curved plate, and nowhere else."""
    bent = Plate.model_validate(
        {**plate.model_dump(exclude_none=True), "curvature": curvature} if curvature else plate
    )
    shell = ShellPlate.of(bent, three_patches[:1], recipe=MESH, degree=4)
    thickness, size = shell.thickness, shell.space.size
    stiffness = [
        *shell.cells.of(shell.plate_stiffness(moduli(shell.sheet, 2e9, 0.7e9), (0.7e9, 0.7e9, 0.0), thickness))
    ]
    stiffness += shell.cells.of(shell.patch_stiffness(thickness))
    terms = [(1.0, stiffness), (1e5, list(shell.inertia(thickness)))]
    loads = np.random.default_rng(0).standard_normal((5, size, 2))
    free = ~shell.held
    whole = Unknowns.of(shell.space, free)
    matrix = sum(factor * whole.matrix(blocks) for factor, blocks in terms)
    expected = np.zeros((5 * size, 2))
    expected[whole.chosen] = factorize(matrix.tocsr()).solve(loads.reshape(5 * size, 2)[whole.chosen])

    free[:, first_inside(shell.space) :] = False
    outer = Unknowns.ordered(shell.space, free, elimination_order(shell.space))
    smaller, load, parts = without_insides(
        shell.space, ResponseProblem(terms, [], loads, np.zeros((5, size))), outer
    )
    found = np.zeros_like(expected)
    found[outer.chosen] = factorize(smaller).solve(load)
    padded = np.vstack([found[outer.chosen], np.zeros((1, 2))])
    for part in parts:
        found[part.inner] = part.alone - part.followed @ padded[part.outer]
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert sum(part.inner.size for part in parts) + outer.size == whole.size
