"""Unknowns of a shell: their numbers, their order, and matrices over them."""

import numpy as np
import pytest

from analysis.experiment import Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import Block
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import Unknowns, elimination_order, factorize


def test_every_function_stands_in_the_order_once(coarse_model: ShellModel) -> None:
    order = elimination_order(coarse_model.space)
    assert np.array_equal(np.sort(order), np.arange(coarse_model.space.size))


def test_insides_of_cells_come_first(coarse_model: ShellModel) -> None:
    space = coarse_model.space
    shared = len(space.mesh.points) + len(space.mesh.edges) * (space.degree - 1)
    inside = elimination_order(space) >= shared
    assert inside[: inside.sum()].all()


def test_numbers_undo_the_choice(coarse_model: ShellModel) -> None:
    rng = np.random.default_rng(0)
    space = coarse_model.space
    kept = rng.random((5, space.size)) < 0.3
    over = Unknowns.of(space, kept)
    assert over.size == kept.sum()
    assert np.array_equal(over.number >= 0, kept)
    assert np.array_equal(over.number.ravel()[over.chosen], np.arange(over.size))


def test_vectors_and_rows_are_two_sides_of_one_product(coarse_model: ShellModel) -> None:
    rng = np.random.default_rng(1)
    space, over = coarse_model.space, coarse_model.unknowns
    field = rng.standard_normal(space.size)
    points = np.array([(0.03, 0.05), (0.2, 0.1)])
    wanted = space.values(points) @ field
    assert over.rows(space.values(points), 3) @ over.vector({3: field}) == pytest.approx(wanted)
    assert not (over.rows(space.values(points), 2) @ over.vector({3: field})).any()


def test_blocks_of_two_fields_are_taken_both_ways(coarse_model: ShellModel) -> None:
    space, over = coarse_model.space, coarse_model.unknowns
    rng = np.random.default_rng(2)
    part = space.product("x", "0")
    u, w = rng.standard_normal((2, space.size))
    halves = [
        (group, np.arange(half, len(space.groups[group].functions), 2)) for group in (0, 1) for half in (0, 1)
    ]
    blocks = [Block(0, 2, group, cells, space.blocks("x", "0", group, cells=cells)) for group, cells in halves]
    matrix = over.matrix(blocks)
    assert over.vector({0: u}) @ (matrix @ over.vector({2: w})) == pytest.approx(u @ (part @ w))
    assert over.vector({2: w}) @ (matrix @ over.vector({0: u})) == pytest.approx(u @ (part @ w))
    assert not (matrix @ over.vector({4: u})).any()


def test_factors_in_this_order_solve_and_stay_sparse(plate: Plate) -> None:
    """Against the same matrix with its unknowns in the order of their functions: a multiple of the entries."""
    mesh = MeshRecipe(spacing=0.15, edge_strip=3.0, growth=2.0, grading=0.0)
    model = assemble(plate, recipe=mesh, degree=3)
    matrix = model.stiffness(2e9, 0.38) + 1e6 * model.mass
    factors = factorize(matrix)
    right = np.random.default_rng(3).standard_normal(matrix.shape[0])
    assert np.abs(matrix @ factors.solve(right) - right).max() < 1e-6 * np.abs(right).max()
    by_function = np.argsort(model.unknowns.chosen % model.space.size, kind="stable")
    plain = factorize(matrix[by_function][:, by_function])
    assert factors.L.nnz < 0.7 * plain.L.nnz
