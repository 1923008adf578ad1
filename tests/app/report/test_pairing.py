"""What the figure of paired modes holds, and the tables beside it."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.experiment import Plate
from analysis.pairing.assignment import ModeList, PairedSweeps, Pairing, pair_modes
from analysis.pairing.points import compare_points
from app.files.results.best_twin import BY_UPDATE
from app.files.results.pairing_json import pairing_record, shown
from app.report.page import PageTable, Picture, VerdictBox
from app.report.pairing import pairing_figure, pairing_items, points_figure
from app.report.style import drawing
from app.summaries.modes import likeness, pairing_tables, rows

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


def test_modes_before_the_effects_say_of_which_twin_they_are() -> None:
    """Their misfit, by update, stood without a word beside that of the comparison's own twin, a third of it."""
    record = pairing_record(Pairing(sweeps(1.01), sweeps(1.001)))
    with drawing():
        picture, first, second = pairing_items(record, "pairing", of=BY_UPDATE)
    assert isinstance(picture, Picture)
    assert picture.caption.partition(". Filled")[0].endswith(f"misfit 90.0 %, {BY_UPDATE}")
    assert picture.figure.axes[0].lines[0].get_label() == BY_UPDATE
    assert isinstance(first, PageTable)
    assert isinstance(second, PageTable)
    assert (first.headings[0], second.headings[0]) == (
        f"measured [Hz], {BY_UPDATE}",
        "measured [Hz], with the effects found",
    )
    titles = [table.title for table in pairing_tables(record, BY_UPDATE)]
    assert [title.rpartition(" %, ")[2] for title in titles] == [BY_UPDATE, "with the effects found"]


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


@pytest.fixture
def turned() -> PairedSweeps:
    """Six points of a free beam on a plate, the third with the wrong sign."""
    along = np.linspace(0.0, 1.0, 6)
    shapes = np.array([np.cos(k * np.pi * along) for k in (1, 2, 3)]).T.astype(complex)
    wrong = shapes * np.where(np.arange(6) == 2, -1.0, 1.0)[:, None]
    names, kinds = [f"acc{k}" for k in range(1, 7)], ["acceleration"] * 6
    points = compare_points(names, kinds, F[:3], wrong, shapes)
    return replace(sweeps(1.01, channels=6), points=points)


def test_wrong_points_stand_in_table_notes_and_figure(turned: PairedSweeps) -> None:
    record = pairing_record(Pairing(turned))
    assert record is not None
    assert record["points"]["said"] == [turned.points.said[0]] if turned.points else False
    assert record["points"]["said"][0].startswith("point acc3 moves like its mirror: sign")
    assert Pairing(turned).wrong_points == tuple(record["points"]["said"])
    table = pairing_tables(record)[-1]
    assert table.rows[0][0] == "acc3"
    assert table.rows[0][2] == "not as declared"
    places = {f"acc{k}": (0.02 + 0.04 * k, 0.1) for k in range(1, 7)}
    plate = Plate(length_x=0.3, length_y=0.2, thickness=0.003, mass=0.486)
    with drawing():
        figure = points_figure(record["points"], plate, places)
    first = figure.axes[0]
    drawn = np.asarray(first.collections[0].get_array(), float)
    computed, measured = (np.array(record["points"][name][0]) for name in ("computed", "measured"))
    np.testing.assert_allclose(drawn, measured - computed)
    assert np.abs(drawn).argmax() == 2
    ring = next(line for line in first.lines if line.get_label() == "not as declared")
    np.testing.assert_allclose(np.asarray(ring.get_xydata(), float), [places["acc3"]])
    outline = np.asarray(first.patches[0].get_xy(), float)  # type: ignore[attr-defined]
    np.testing.assert_allclose(outline.max(axis=0), [0.3, 0.2])
