"""The report of a campaign whose plate is not the paper's."""

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.files.results.modes_file import load_frf, load_modes
from app.report.measured import overlay
from app.report.page import PageTable, Paragraph, Picture, Section
from app.report.written import sections
from tests.app.modal_test.conftest import typed

HAMMER_PLATE = Path(__file__).resolve().parents[3] / "examples" / "hammer-plate"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plate")
    shutil.copytree(HAMMER_PLATE, folder / "plate")
    declared = folder / "plate" / "campaign.toml"
    text = declared.read_text(encoding="utf-8")
    named = 'operator = "A. Tester"\ndate = 2026-11-22\n'
    declared.write_text(text.replace("title =", f"{named}title =", 1), encoding="utf-8")
    typed("identify", folder / "plate", "--out", folder / "run", "--quiet")
    return folder / "run"


@pytest.fixture(scope="module")
def parts(run: Path) -> dict[str, Section]:
    return {part.title: part for part in sections(run, lambda *_: None).sections}


def pictures(parts: dict[str, Section]) -> list[Picture]:
    return [item for part in parts.values() for item in part.items if isinstance(item, Picture)]


def tables(part: Section) -> list[PageTable]:
    return [item for item in part.items if isinstance(item, PageTable)]


def test_it_tells_who_measured_and_when(parts: dict[str, Section]) -> None:
    (facts,) = tables(parts["Measurement"])
    assert list(facts.rows[:2]) == [("date", "2026-11-22"), ("operator", "A. Tester")]


def test_it_lists_the_modes_of_the_sweep_that_is_drawn(run: Path, parts: dict[str, Section]) -> None:
    (modes,) = tables(parts["Identification"])
    tracked = load_modes(run / "modes.h5")
    drawn = tracked.modes[int(np.abs(tracked.temperature - 25.4).argmin())]
    assert [row[1] for row in modes.rows] == [f"{f:.3f}" for f in drawn.reading().frequency_hz[drawn.real]]
    assert {row[6] for row in modes.rows} == {"kept, confirmed"}
    assert all(float(row[2]) > 0.0 for row in modes.rows)


def test_the_report_reads_poles_as_modes_csv_does(tmp_path: Path) -> None:
    typed("identify", HAMMER_PLATE, "--out", tmp_path, "--damping", "viscous", "--quiet")
    tracked = load_modes(tmp_path / "modes.h5")
    assert tracked.damping == "viscous"
    parts = {part.title: part for part in sections(tmp_path, lambda *_: None).sections}
    (modes,) = tables(parts["Identification"])
    drawn = f"{tracked.temperature[np.abs(tracked.temperature - 25.4).argmin()]:.4f}"
    with (tmp_path / "modes.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["temperature_c"] == drawn]
    written = {row["mode"]: row for row in rows}
    for row in modes.rows:
        assert row[1] == f"{float(written[row[0]]['frequency_hz']):.3f}"
        assert row[5] == f"{100 * float(written[row[0]]['loss_factor']):#.4g}"
    words = [item.text for item in parts["Identification"].items if isinstance(item, Paragraph)]
    assert "viscous" in words[0]


def test_the_synthesis_is_drawn_in_the_band_that_was_identified(run: Path) -> None:
    _, frf = load_frf(run / "frf.h5")
    found = load_modes(run / "modes.h5")
    low, high = float(frf.frequency[5]), float(frf.frequency[-40])
    cut = replace(found, modes=tuple(replace(modes, band=(low, high)) for modes in found.modes))
    above, below = overlay(frf, cut).axes
    measured, rebuilt, *_ = above.lines
    assert measured.get_xdata()[-1] == frf.frequency[-1]
    assert (rebuilt.get_xdata()[0], rebuilt.get_xdata()[-1]) == (low, high)
    assert below.lines[1].get_xdata()[-1] == high
    assert f"{low:.0f} to {high:.0f} Hz: " in above.get_title()


def test_the_paper_is_not_mentioned(parts: dict[str, Section]) -> None:
    assert "Beside the paper" not in parts
    assert not [picture.caption for picture in pictures(parts) if "paper" in picture.caption]


def test_legends_stand_outside_the_axes(parts: dict[str, Section]) -> None:
    drawn = [picture.figure for picture in pictures(parts)]
    assert sum(bool(figure.legends) for figure in drawn) >= 3
    assert not [axes for figure in drawn for axes in figure.axes if axes.get_legend() is not None]
