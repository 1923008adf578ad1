import numpy as np
import pytest

from simulation.meshing.recipe import MeshRecipe, mesh_lines


def test_lines_follow_edges_strips_and_spacing():
    lines = mesh_lines(0.24, [(0.03, 0.05)], MeshRecipe())
    for wanted in (0.0, 0.003, 0.0275, 0.03, 0.0325, 0.0475, 0.05, 0.0525, 0.237, 0.24):
        assert np.abs(lines.position - wanted).min() < 1e-12
    assert np.diff(lines.position).max() <= 0.040 + 1e-12


def test_kinds_name_the_strips():
    lines = mesh_lines(0.24, [(0.03, 0.05)], MeshRecipe())
    width = np.diff(lines.position)
    assert (lines.kind == "strip").sum() == 4
    assert (lines.kind == "edge").sum() == 2
    assert np.allclose(width[lines.kind == "strip"], 0.0025)
    assert np.allclose(width[lines.kind == "edge"], 0.003)


def test_strip_lines_give_way_to_edges_but_edges_stay():
    close = mesh_lines(0.24, [(0.03, 0.05), (0.0507, 0.07)], MeshRecipe())
    assert np.abs(close.position - 0.05).min() < 1e-12
    assert np.abs(close.position - 0.0507).min() < 1e-12
    inner = np.diff(close.position)
    assert np.sort(inner)[1] > 0.5 * 0.0025 - 1e-12  # only the gap between the patches is thinner


def test_patch_flush_with_the_plate_edge():
    lines = mesh_lines(0.1, [(0.0, 0.02)], MeshRecipe())
    assert lines.position[0] == 0.0
    assert np.all(np.diff(lines.position) > 1e-3)


@pytest.mark.parametrize(("key", "value"), [("degree", 2), ("spacing", 0.0), ("strip", -1.0)])
def test_nonsense_is_refused(key, value):
    with pytest.raises(ValueError, match=key):
        MeshRecipe(**{key: value})
