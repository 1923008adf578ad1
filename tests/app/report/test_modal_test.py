"""Shapes in the report of a test."""

from pathlib import Path

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import NONE
from analysis.shapes.participation import mode_shapes
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import MODE_HEADINGS, mode_rows
from app.report.modal_test import drawn_shapes, in_short


def test_a_point_read_from_behind_is_drawn_like_the_others() -> None:
    """A rigid motion, read along +z, -z and +z."""
    line = np.arange(1.0, 9.0)
    places = ("1:+3", "2:-3", "3:+3")
    frfs = FrfSet("plate", tuple(MeasuredTransfer(p, p, "1:+3", "displacement", line, line + 0j) for p in places))
    poles, residues = np.array([-1.0 + 30j]), np.array([[-1j], [1j], [-1j]])
    nothing = np.zeros((3, 0), complex)
    covariance = 1e-6 * np.eye(2)[None]
    modes = Modes(poles, residues, covariance, NONE, nothing, ("kept",), ("",), (1.0, 8.0), 0.1, 8)
    shapes = mode_shapes(frfs.transfers, poles, residues, modes.real)
    axes = drawn_shapes(frfs, modes, shapes).axes[0]
    np.testing.assert_allclose(np.asarray(axes.lines[0].get_ydata(), dtype=float), [1.0, 1.0, 1.0])
    assert ([one.get_text() for one in axes.get_xticklabels()], axes.get_xlabel()) == (["1", "2", "3"], "node")


@pytest.mark.parametrize(("places", "wanted"), [(("1:+3", "2:+3"), "1.000"), (("1:+3",), "–")])
def test_one_place_alone_has_no_phase_collinearity(places: tuple[str, ...], wanted: str) -> None:
    line, count = np.arange(1.0, 9.0), len(places)
    frfs = [MeasuredTransfer(p, p, "1:+3", "displacement", line, line + 0j) for p in places]
    poles, residues, nothing = np.array([-1.0 + 30j]), np.full((count, 1), -1j), np.zeros((count, 0), complex)
    covariance = 1e-6 * np.eye(2)[None]
    modes = Modes(poles, residues, covariance, NONE, nothing, ("kept",), ("BIC",), (1.0, 8.0), 0.1, 8)
    (row,) = mode_rows(modes, mode_shapes(frfs, poles, residues, modes.real))
    assert dict(zip(MODE_HEADINGS, row, strict=True))["MPC"] == wanted


def test_the_first_screen_says_what_cannot_be_trusted_and_what_to_do() -> None:
    """Two modes that three points do not tell apart, one of them weak; averages of one FRF do not agree."""
    line, places = np.arange(1.0, 9.0), ("1:+3", "2:+3", "3:+3")
    frfs = FrfSet(
        "plate",
        tuple(
            MeasuredTransfer(
                p, p, "1:+3", "displacement", line, line + 0j, coherence=np.full(8, 0.14 if n == 1 else 0.99)
            )
            for n, p in enumerate(places)
        ),
    )
    poles, residues = np.array([-0.1 + 20j, -0.1 + 40j]), -1j * np.array([[1.0, 1.0], [1.0, 1.1], [-1.0, -1.0]])
    covariance, nothing = 1e-6 * np.eye(2)[None].repeat(2, axis=0), np.zeros((3, 0), complex)
    status, why = ("kept", "weak"), ("", "BIC")
    modes = Modes(poles, residues, covariance, NONE, nothing, status, why, (1.0, 8.0), 0.1, 8)
    said = in_short(Path("my run"), frfs, modes, mode_shapes(frfs.transfers, poles, residues, modes.real))
    assert said.headline == "2 modes, 3.183 to 6.366 Hz; 1 not confirmed"
    assert (said.settled, said.first) == (False, ["Median coherence below 0.9: 2:+3 (0.14)."])
    parts = dict(said.parts)
    assert parts["modes"][1] == "Weak, or not confirmed by refits: 6.366 Hz."
    assert parts["shapes"][0].startswith("Shapes 1: 3 and 2: 6 Hz look alike at these places (MAC 1.0")
    assert [one.split()[0] for one in parts["next"]] == ["Measure", "Measure", "See"]
    assert parts["next"][-1] == "See the shapes move: flexura view 'my run'"
