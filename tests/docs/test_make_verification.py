"""The script behind docs/verification.md: its solver, its pictures, and that the page knows every case."""

import importlib
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from tests.simulation.verification.case import compare
from tests.simulation.verification.cases import CASES

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module("make_verification")


@pytest.fixture
def drawing(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module("verification_pictures")


def named(name):
    (case,) = (case for case in CASES if case.name == name)
    return case


@pytest.mark.parametrize(
    ("name", "refinement"),
    [
        ("disc-free-0.2", 1),
        ("disc-clamped-0.01", 1),
        ("disc-soft-0.1", 1),
        ("disc-hard-0.1", 1),
        ("annulus-soft-clamped-0.1", 1),
        ("annulus-clamped-free-0.01", 2),
        ("rectangle-soft-soft-0.1", 1),
        ("rectangle-hard-hard-0.01", 1),
        ("rectangle-clamped-free-0.1", 1),
    ],
)
def test_plates_meet_their_exact_frequencies(script, name, refinement):
    done = compare(named(name), script.frequencies, (refinement,))
    assert done.worst < 1e-4


def test_what_the_solver_draws_is_its_mode(script):
    """Under hard supports the first mode is a half wave along both sides."""
    solved = script.solve_with_the_finite_element_plate(named("rectangle-hard-hard-0.1"), 1)
    x, y = solved.points.T
    wanted = np.sin(np.pi * x) * np.sin(np.pi * y / 0.8)
    first = solved.deflection[0] / solved.deflection[0][np.abs(solved.deflection[0]).argmax()]
    assert first == pytest.approx(wanted, abs=1e-4)
    corners = solved.points[solved.triangles]
    (a, b), (c, d) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    assert 0.5 * (a * d - b * c).sum() == pytest.approx(0.8)
    assert len(np.unique(solved.points.round(9), axis=0)) == len(solved.points)
    areas = [0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) for x, y in (cell.T for cell in solved.cells)]
    assert min(areas) > 0.0
    assert sum(areas) == pytest.approx(0.8)


@pytest.mark.parametrize(("name", "refinement"), [("l-shape-clamped", 2), ("fv15", 2), ("ellipse-free", 1)])
def test_plates_with_singular_corners_meet_converged_frequencies(script, name, refinement):
    done = compare(named(name), script.frequencies, (refinement,))
    assert done.worst < done.case.tolerance


def test_smaller_cells_bring_a_disc_to_its_exact_frequencies(script):
    done = compare(named("disc-clamped-0.1"), script.frequencies, (0, 1))
    errors = np.abs(done.frequency / done.case.reference - 1.0).max(axis=1)
    assert errors[1] < 2.0**-6 * errors[0]


def test_graded_corners_can_be_drawn(script, drawing, tmp_path):
    """Points of the smallest cells stay apart: triangles without area would stop the drawing."""
    solved = script.solve_with_the_finite_element_plate(named("fv12"), 2)
    corners = solved.points[solved.triangles]
    (a, b), (c, d) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    assert (a * d - b * c).min() > 0.0
    drawing.draw_modes(solved.points, solved.triangles, solved.deflection[3:5], ["", ""], tmp_path / "modes.png")
    assert imread(tmp_path / "modes.png")[..., :3].min() < 0.2


def test_meshes_and_modes_are_drawn(drawing, tmp_path):
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    drawing.draw_mesh([square, square + np.array([1.0, 0.0])], tmp_path / "new" / "mesh.png")
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    values = np.array([[1.0, 1.0, -1.0, -1.0], [-1.0, 1.0, 1.0, -1.0]])
    drawing.draw_modes(square, triangles, values, ["up below", "up right"], tmp_path / "modes.png")
    mesh = imread(tmp_path / "new" / "mesh.png")[..., :3]
    assert mesh.shape[1] > 1.6 * mesh.shape[0]
    assert mesh.min() < 0.5
    modes = imread(tmp_path / "modes.png")
    redness = modes[..., 0] - modes[..., 2]
    left, right = np.array_split(redness, 2, axis=1)
    # Red below and blue above on the left; red on the right side of the right one.
    below, above = np.array_split(left, 2, axis=0)[::-1]
    assert below.mean() > 0 > above.mean()
    west, east = np.array_split(right, 2, axis=1)
    assert east.mean() > 0 > west.mean()


def test_modes_without_titles_are_refused(drawing, tmp_path):
    with pytest.raises(ValueError, match="1 modes with 2 titles"):
        drawing.draw_modes(
            np.eye(3)[:, :2], np.array([[0, 1, 2]]), np.ones((1, 3)), ["a", "b"], tmp_path / "x.png"
        )


def test_the_page_has_every_case_and_every_picture_it_shows():
    page = (DOCS / "verification.md").read_text(encoding="utf-8")
    assert [case.title for case in CASES if case.title not in page] == []
    shown = {part.split(")")[0] for part in page.split("](images/verification/")[1:]}
    assert shown
    assert {path.name for path in (DOCS / "images" / "verification").iterdir()} == shown
