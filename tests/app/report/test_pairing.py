"""What the figure of paired modes holds, and the tables beside it."""

import numpy as np
import pytest

from analysis.pairing.assignment import pair_modes
from analysis.pairing.mode_list import ModeList
from analysis.pairing.paired_sweeps import PairedSweeps, Pairing
from app.files.pairing_json import pairing_record, shown
from app.report.page import PageTable, Picture, VerdictBox
from app.report.pairing import pairing_figure, pairing_items
from app.report.style import drawing
from app.summaries.pairing import likeness, pairing_tables, rows

F = np.array([100.0, 200.0, 330.0, 500.0])


def sweeps(factor: float, sign: float = 1.0, channels: int = 1, misfit: float = 0.9) -> PairedSweeps:
    """Four measured modes, the last without a partner; the twin has three of them, and one at 700 Hz."""
    ones = np.ones(4)
    residues = 80.0 * np.ones((channels, 4), dtype=complex)
    measured = ModeList(F, 1e-3 * F, 0.02 * ones, 1e-3 * ones, residues, ones > 0)
    computed = np.array([*(factor * F[:3]), 700.0])
    other = ModeList(computed, 0.0 * ones, 0.025 * ones, 0.0 * ones, sign * residues, ones > 0)
    pairs = pair_modes(21.5, (50.0, 1000.0), measured, other)
    return PairedSweeps((pairs,), np.array([misfit]), np.array([0.01]), "identified")


def test_rows_are_the_pairs_and_the_modes_left_alone_by_frequency() -> None:
    record = pairing_record(Pairing(sweeps(1.01)))
    assert record is not None
    sweep = shown(record)
    assert likeness(sweep) == "residues"
    assert rows(sweep) == [
        ("100.0", "101.0", "+1.00", "+10.0", "0.80", "1.00", "yes"),
        ("200.0", "202.0", "+1.00", "+10.0", "0.80", "1.00", "yes"),
        ("330.0", "333.3", "+1.00", "+10.0", "0.80", "1.00", "yes"),
        ("500.0", "none", "", "", "", "", "no"),
        ("none", "700.0", "", "", "", "", ""),
    ]
    assert likeness(shown(pairing_record(Pairing(sweeps(1.01, channels=2))) or {})) == "MAC"


def test_the_figure_draws_differences_damping_and_likeness_before_and_after() -> None:
    record = pairing_record(Pairing(sweeps(1.01), sweeps(1.001)))
    assert record is not None
    with drawing():
        figure = pairing_figure(shown(record), shown(record, "sweeps_after"))
    drawn = {line.get_label(): line.get_ydata() for line in figure.axes[0].lines}
    np.testing.assert_allclose(np.asarray(drawn["before"], float), 1.0)
    np.testing.assert_allclose(np.asarray(drawn["with the effects found"], float), 0.1)
    alone = {line.get_label(): np.asarray(line.get_xdata(), float).tolist() for line in figure.axes[0].lines}
    assert (alone["measured only"], alone["twin only"]) == ([500.0], [700.0])
    assert [axes.get_ylabel() for axes in figure.axes][2] == "residues"


def test_a_twin_that_is_no_fit_has_its_verdict_above_the_figure() -> None:
    bad = Pairing(sweeps(1.0, sign=-1.0), likely="likely reason: the sensor")
    with drawing():
        box, picture, table = pairing_items(pairing_record(bad), "pairing")
        good = pairing_items(pairing_record(Pairing(sweeps(1.0))), "pairing")
    assert isinstance(box, VerdictBox)
    assert (box.headline, box.settled) == ("This is no fit", False)
    assert box.sentences[1] == "likely reason: the sensor"
    assert isinstance(picture, Picture)
    assert isinstance(table, PageTable)
    assert [type(item) for item in good] == [Picture, PageTable]
    assert pairing_items(None, "pairing") == []


@pytest.mark.parametrize(("after", "count"), [(None, 1), (sweeps(1.001), 2)])
def test_the_terminal_has_a_table_before_and_one_after(after: PairedSweeps | None, count: int) -> None:
    record = pairing_record(Pairing(sweeps(1.01), after))
    assert record is not None
    tables = pairing_tables(record)
    assert len(tables) == count
    assert len(tables[0].rows) == 5
