"""A drive that is declared where it did not stand is told: numbered nodes make a drive point of the first."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from analysis.estimation.transfer import MeasuredTransfer
from app.modal_test.frf_set import FrfSet, with_said_of_ends
from tests.app.modal_test.conftest import Beam, hammer_files

F = np.linspace(20.0, 800.0, 1500)


def said(beam: Beam, ends: Sequence[tuple[int, int]], *, driven: int, factor: float = 1.0) -> tuple[str, ...]:
    """Return notes on accelerances between declared nodes, from 1; in truth node `driven` was driven."""
    made = []
    for response, reference in ends:
        h = beam.frf(F, response - 1, driven - 1 if reference == 1 else reference - 1, order=2)
        h = h * (factor if (response, reference) == ends[-1] else 1.0)
        names = f"{response}:+3", f"{reference}:+3"
        made.append(MeasuredTransfer(f"H {names[0]} / {names[1]}", *names, "acceleration", F, h))
    return with_said_of_ends(FrfSet("beam", tuple(made))).notes


def test_a_drive_elsewhere_is_told_with_the_node_where_it_probably_stood(beam: Beam) -> None:
    column = [(node, 1) for node in range(1, 6)]
    assert said(beam, column, driven=1) == ()
    (note,) = said(beam, column, driven=3)
    assert note.startswith("H 1:+3 / 1:+3: no drive point (wrong sign: ")
    assert "; H 3:+3 / 1:+3 looks like one" in note
    assert "Say under at where" in note


def test_a_row_and_no_drive_point_at_all(beam: Beam) -> None:
    assert said(beam, [(2, 1), (3, 1)], driven=1) == ()  # nothing was declared at the drive
    assert said(beam, [(1, 1)], driven=4) == ()  # an FRF alone has no shapes
    (note,) = said(beam, [(1, 1), (2, 1)], driven=4)
    assert "looks like" not in note


def test_reciprocal_frfs_that_differ_are_told_once(beam: Beam) -> None:
    matrix = [(1, 1), (1, 2), (2, 2), (2, 1)]
    assert said(beam, matrix, driven=1) == ()
    (note,) = said(beam, matrix, driven=1, factor=1.4)
    assert "reciprocity with" in note
    assert "apart: a hit or a sensor is beside its point" in note


def test_a_sensor_at_another_node_is_told_by_identify(
    tmp_path: Path, beam: Beam, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    """The hammer goes from node 1 to node 5; the sensor stands at node 1, and is declared at 3."""
    declaration = hammer_files(tmp_path, beam, seconds=4.0, count=2)
    text = declaration.read_text(encoding="utf-8")
    declaration.write_text(text.replace('at = "1:+z"', 'at = "3:+z"'), encoding="utf-8")
    status, _, err = run_flexura("identify", declaration, "--quiet")
    assert status == 0
    assert "accelerance Acc 3:+3 / Hammer 3:+3: no drive point" in err
    assert "accelerance Acc 3:+3 / Hammer 1:+3 looks like one" in err
