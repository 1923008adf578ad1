"""Shapes in the report of a test."""

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.modes import Modes
from analysis.identification.residual_terms import NONE
from analysis.shapes.participation import mode_shapes
from app.modal_test.frf_set import FrfSet
from app.modal_test.records import MODE_HEADINGS, mode_rows
from app.report.modal_test import drawn_shapes


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
