"""Vectors carried to a finer mesh answer as well as the finer mesh itself."""

import numpy as np
import pytest

from analysis.material import MaterialBox
from simulation.meshing.recipe import MeshRecipe
from simulation.mesh_refinement import refined
from simulation.shell.assembly import assemble
from simulation.reduction import reduction

BAND = (100.0, 700.0)
MATERIAL = (1.8e9, 0.38, 0.05)
LINES = np.array([150.0, 290.0, 420.0, 610.0])


@pytest.fixture(scope="module")
def coarse_vectors(coarse_model):
    return reduction(coarse_model, MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1)), BAND)[1]


def transfers(model, vectors):
    stiffness = vectors.T @ (model.stiffness(*MATERIAL) @ vectors)
    mass, force = vectors.T @ (model.mass @ vectors), vectors.T @ model.coupling
    z = stiffness - (2 * np.pi * LINES[:, None, None]) ** 2 * mass
    return np.array([force.T @ np.linalg.lstsq(row, force.astype(complex), rcond=1e-14)[0] for row in z])


def test_carried_vectors_are_the_same_motion(coarse_model, coarse_vectors, plate, three_patches):
    fine, vectors = refined(
        coarse_model, coarse_vectors, plate, tuple(three_patches), coarse_model.coupling, BAND, 5
    )
    carried = vectors[:, : coarse_vectors.shape[1]]
    places = np.array([(0.013, 0.02), (0.11, 0.07), (0.2, 0.155), (0.231, 0.18)])
    there, here = fine.deflection(places) @ carried, coarse_model.deflection(places) @ coarse_vectors
    assert there == pytest.approx(here, abs=1e-10 * np.abs(here).max())
    mass = coarse_vectors.T @ (coarse_model.mass @ coarse_vectors)
    assert carried.T @ (fine.mass @ carried) == pytest.approx(mass, abs=1e-10 * np.abs(mass).max())


def test_one_step_on_the_finer_mesh_leaves_a_thirtieth_of_the_error(
    coarse_model, coarse_vectors, plate, three_patches
):
    fine, vectors = refined(
        coarse_model, coarse_vectors, plate, tuple(three_patches), coarse_model.coupling, BAND, 5
    )
    vectors = vectors / np.sqrt(
        np.einsum("ni,ni->i", vectors, fine.stiffness(1.8e9, 0.38) @ vectors + 1e6 * (fine.mass @ vectors))
    )
    exact = fine.compliance(*MATERIAL, LINES).transpose(2, 0, 1)
    scale = np.sqrt(np.mean(np.abs(exact) ** 2))
    before = np.abs(coarse_model.compliance(*MATERIAL, LINES).transpose(2, 0, 1) - exact).max() / scale
    after = np.abs(transfers(fine, vectors) - exact).max() / scale
    assert before > 1e-3
    assert after < before / 30.0


def test_a_finer_mesh_of_the_same_degree_adds_what_was_thinned_out(plate, three_patches):
    thin = assemble(plate, three_patches, recipe=MeshRecipe(degree=4, spacing=0.06))
    vectors = np.eye(thin.size, 1)
    fine, _ = refined(thin, vectors, plate, tuple(three_patches), thin.coupling, BAND, 4)
    assert fine.size > thin.size
