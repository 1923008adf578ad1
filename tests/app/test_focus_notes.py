"""Notes on filters: what is advised can still be done."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.files.results.panel_files import load_compensation, load_focusing
from app.stages.panel.laws import said_of_range
from app.summaries.compensation import _percent, tables
from app.summaries.focusing import correction, notes, table
from app.terminal.tables import show


def lossy(design: str) -> tuple[Any, Any]:
    """Return filters whose taps lose 0.3 of contrast on the worst line."""
    panel = SimpleNamespace(
        filters=SimpleNamespace(reference_temperature=20.0, design=design, aim="field"), limits=np.array([np.inf])
    )
    focusing = SimpleNamespace(
        reference_temperature=20.0,
        rank_changes=np.zeros(0),
        regularisation="tikhonov",
        temperature=np.array([20.0]),
        uncut=SimpleNamespace(contrast=np.array([[0.8, 0.7]])),
        direct=SimpleNamespace(contrast=np.array([[0.8, 0.4]])),
        bank=SimpleNamespace(taps=np.zeros((1, 1, 8))),
    )
    return panel, focusing


@pytest.mark.parametrize(
    ("design", "advice"),
    [("field", "; more taps or another delay keep more"), ("inverse-fft", ", or --design field keep more")],
)
def test_taps_that_lose_contrast(design: str, advice: str) -> None:
    (said,) = notes(*lossy(design))
    assert said.startswith("the taps lose 0.30 of contrast on the worst line at 20 °C")
    assert said.endswith(advice)


def compared(own: list[float], without: list[float]) -> list[str]:
    focusing: Any = SimpleNamespace(
        temperature=np.arange(20.0, 20.0 + 5 * len(own), 5.0),
        direct=SimpleNamespace(contrast=np.array(own)[:, None]),
    )
    return correction(focusing, SimpleNamespace(contrast=np.array(without)[:, None]))  # type: ignore[arg-type]


def test_what_a_correction_is_worth_is_nothing_where_filters_gain_nothing() -> None:
    (said,) = compared([0.5, 0.6], [0.5, 0.61])
    assert said.endswith("reach contrast 0.500 to 0.610 here; the correction is worth nothing for them")
    (said,) = compared([0.5, 0.6], [0.5, 0.58])
    assert said.endswith("the correction is worth up to 0.020, at 25 °C")
    (said,) = compared([0.57], [0.57])
    assert "reach contrast 0.570 here" in said


def unfocused(method: str, contrast: float) -> list[str]:
    panel, focusing = lossy("field")
    focusing.method = method
    focusing.uncut.contrast = np.array([[contrast]])
    focusing.direct = SimpleNamespace(contrast=np.array([[contrast]]), spot_error=np.array([[0.35]]))
    return notes(panel, focusing)


def test_filters_that_do_not_focus() -> None:
    (said,) = unfocused("stif", 0.17)
    assert said.startswith("at 20 °C the filters do not focus: mean contrast 0.17")
    assert "35% of the plate's length" in said
    assert "place_actuators.py" in said
    (said,) = unfocused("none", 0.17)
    assert said.endswith("take --method stif")
    assert unfocused("stif", 0.55) == []


@pytest.mark.parametrize(("covered", "count"), [((-20.0, 80.0), 0), ((0.0, 60.0), 1), ((-20.0, 60.0), 1)])
def test_laws_that_do_not_cover_the_operating_range(covered: tuple[float, float], count: int) -> None:
    panel: Any = SimpleNamespace(filters=SimpleNamespace(operating_range=(-20.0, 80.0)))
    said = said_of_range(panel, covered)
    assert len(said) == count
    for one in said:
        assert one.startswith(f"the laws cover {covered[0]:g} to 60 °C only")
        assert "operating_range, -20 to 80 °C" in one


def test_errors_of_filters_are_written_without_exponent() -> None:
    assert [_percent(x) for x in (0.0141, 0.235, 2.117, 15.52, 231.0)] == ["0.014", "0.23", "2.1", "16", "231"]


def test_the_table_of_methods_has_whole_words_in_80_columns(
    small_run: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A pipe counts as 80 columns; the heading was "reduce… freque…"."""
    monkeypatch.setenv("COLUMNS", "80")
    found = load_compensation(small_run.folder / "compensation.h5")[1]
    show(tables(replace(found, relative_error=100.0 * np.ones_like(found.relative_error))))
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert "reduced-" in printed
    assert max(len(line) for line in printed.splitlines()) <= 80


def test_focus_says_where_the_laws_end(small_run: Any, tmp_path: Any, run_flexura: Any) -> None:
    panel = tmp_path / "panel.toml"
    text = small_run.panel.read_text()
    panel.write_text(text.replace("[filters]\n", "[filters]\noperating_range = [-20.0, 80.0]\n"))
    _, _, said = run_flexura("focus", small_run.folder, "--panel", panel, "--out", tmp_path / "run")
    assert "note: the laws cover 0 to 60 °C only" in said


def test_the_table_of_temperatures_has_whole_words_in_80_columns(
    small_run: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Filters far below the displacement asked for, up to the odd temperature at which laws end."""
    monkeypatch.setenv("COLUMNS", "80")
    panel, found, _ = load_focusing(small_run.folder / "filters.h5")
    own = found.direct
    weak: Any = SimpleNamespace(
        contrast=own.contrast,
        level=np.full_like(own.contrast, -26.4),
        level_ripple=np.full(len(own.contrast), 19.5),
        phase_error=np.full(len(own.contrast), 30.8),
    )
    show([table(panel, replace(found, temperature=found.temperature + 0.025, direct=weak))])
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert "ripple" in printed
    assert max(len(line) for line in printed.splitlines()) <= 80
