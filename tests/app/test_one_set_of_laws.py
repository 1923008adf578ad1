"""After a comparison that named an effect, all places that print or use E, nu or eta take the corrected ones."""

import ast
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexura
from analysis.material import MaterialLaws
from app.commands.update import overtaken
from app.files.bad_file import ResultFileError
from app.files.results.best_twin import BY_UPDATE, best_twin
from app.report.page import PageTable, Paragraph, Picture, Section, Words
from app.report.style import drawing
from app.report.summary import summary
from app.report.written import Found, sections
from app.stages.panel.laws import laws_for
from app.summaries.numbers import FIXED
from tests.app.corrected_run import baseline, corrected, laws_of, record, write_run
from tests.app.view.conftest import updated
from tests.two_patch_panel import PANEL

Run = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).resolve().parents[2]
AT = 20.0
OURS, PLAIN, BEFORE = laws_of(corrected()), laws_of(updated()), laws_of(baseline())
MODULUS, LOSS = (float(getattr(OURS.at(AT), name)[0]) for name in ("youngs_modulus", "loss_factor"))
SAID = "corrected (added mass at the cable"


def same(one: MaterialLaws, other: MaterialLaws) -> bool:
    return bool(np.allclose(one.coefficients, other.coefficients))


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return write_run(tmp_path / "run")


@pytest.fixture
def found(run: Path) -> Found:
    with drawing():
        return sections(run, lambda *_: None)


def part(found: Found, title: str) -> Section:
    return next(section for section in found.sections if section.title == title)


def items(section: Section, kind: type) -> list[Any]:
    return [item for item in section.items if isinstance(item, kind)]


def test_the_report_begins_with_words_and_then_has_its_contents(found: Found) -> None:
    assert [section.title for section in found.sections[: found.lead]] == ["In short"]
    (words,) = items(found.sections[0], Words)
    assert words.headline.replace(FIXED, " ").startswith(
        "What the twin lacked: an added mass of 0.800 ± 0.002 g at the cable."
    )
    plate = dict(words.parts)["The plate"][0].replace(FIXED, " ")
    assert f"At 20 °C: E {MODULUS / 1e9:.2f}" in plate
    assert f"η {100 * LOSS:.1f}" in plate


def test_the_report_s_line_of_the_stage_names_both(found: Found, run: Path) -> None:
    (table,) = items(found.sections[0], PageTable)
    line = dict(table.rows)["update"]
    assert line == summary(run)["update"]
    first, _, after = line.partition(BY_UPDATE)
    largest = corrected().material.youngs_modulus.max() / 1e9
    assert f"E {largest:.2f} to" in first
    assert SAID in first
    assert f"E {updated().material.youngs_modulus.max() / 1e9:.2f} to" in after


def test_the_report_s_table_and_figure_of_the_laws(found: Found) -> None:
    section = part(found, "Updated twin and material laws")
    assert SAID in items(section, Paragraph)[0].text
    table = next(one for one in items(section, PageTable) if one.headings[0] == "T [°C]")
    assert table.headings[4:] == ["before: E", "ν", "η"]
    row = next(row for row in table.rows if row[0] == "20")
    assert float(row[1].split()[0]) == pytest.approx(MODULUS / 1e9, abs=0.02)
    assert float(row[4]) == pytest.approx(float(BEFORE.at(AT).youngs_modulus[0]) / 1e9, abs=2e-3)
    picture = next(one for one in items(section, Picture) if one.name == "laws")
    assert "Dashed: before" in picture.caption
    lines = picture.figure.axes[0].lines
    curves = {line.get_linestyle(): line for line in lines if len(line.get_xdata()) == 241}
    assert curves["--"].get_label() == "before"
    for style, laws in (("-", OURS), ("--", BEFORE)):
        x, y = curves[style].get_data()
        np.testing.assert_allclose(y, laws.at(np.asarray(x)).youngs_modulus / 1e9, rtol=1e-3)


def test_the_laws_before_are_the_same_on_the_whole_page(found: Found) -> None:
    """Those of update differ from the comparison's by more than the effect: η changed in two directions."""
    (words,) = items(found.sections[0], Words)
    (change, *_) = dict(words.parts)["What it is worth"]
    section = part(found, "What the twin lacks")
    figure = next(one.figure for one in items(section, Picture) if one.name == "gap-laws")
    moved = next(line for line in figure.axes[3].lines if len(line.get_xdata()) == len(updated().temperature))
    low, high = moved.get_ydata().min(), moved.get_ydata().max()
    assert low == pytest.approx(high)
    assert change.replace(FIXED, " ").startswith(f"E changes by {high:+.1f} % of itself (")


def test_where_only_the_laws_of_update_are_there_it_is_said(run: Path) -> None:
    (run / "gap.h5").unlink()
    with drawing():
        section = part(sections(run, lambda *_: None), "Updated twin and material laws")
    table = next(one for one in items(section, PageTable) if one.headings[0] == "T [°C]")
    assert table.headings[4] == f"{BY_UPDATE}: E"
    assert f"Dashed: {BY_UPDATE}." in next(one for one in items(section, Picture) if one.name == "laws").caption


def test_the_paper_is_compared_with_them_in_standard_deviations(found: Found) -> None:
    (table,) = items(part(found, "Beside the paper"), PageTable)
    row = next(row for row in table.rows if row[0] == "E at 20 °C [GPa]")
    assert float(row[2].split()[0]) == pytest.approx(MODULUS / 1e9, abs=0.02)
    sigma = float(OURS.sigma(AT).youngs_modulus[0]) / 1e9
    away = abs(MODULUS / 1e9 - 2.26) / np.hypot(sigma, 0.01 / np.sqrt(12.0))
    assert away > 2.0
    assert row[3].startswith(f"differs by {away:.0f} σ, ")


def test_a_number_agrees_with_the_paper_s_only_within_its_uncertainty(run: Path) -> None:
    from app.report.paper import CLOSE, _beside

    assert _beside(2.27, 0.01, 2.26, 0.01) == CLOSE
    assert _beside(2.2777, 0.0016, 2.26, 0.01).startswith("differs by 5 σ, +0.8 %")
    assert _beside(2.30, 0.0016, 2.26, 1e-9).startswith("differs by 25 σ")


class LawsSeenError(ResultFileError):
    """Raised in place of the panel's twin."""


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> list[MaterialLaws]:
    """Laws that were asked for, once a panel's twin would be made from them."""
    taken: list[MaterialLaws] = []

    def take(_panel: object, laws: MaterialLaws, *_: object) -> None:
        taken.append(laws)
        raise LawsSeenError("seen")

    for place in ("app.stages.focus", "app.stages.compensate", "app.twins.panel_twin"):
        monkeypatch.setattr(f"{place}.panel_twin", take)
    return taken


@pytest.mark.parametrize("verb", [("focus",), ("compensate", "--spacing", 10), ("study", "13")])
def test_verbs_take_them(
    run: Path, tmp_path: Path, run_flexura: Run, seen: list[MaterialLaws], verb: tuple[str, ...]
) -> None:
    (tmp_path / "panel.toml").write_text(PANEL, encoding="utf-8")
    status, _, err = run_flexura(verb[0], *verb[1:], run, "--panel", tmp_path / "panel.toml")
    assert (status, "seen" in err) == (2, True), err
    (laws,) = seen
    assert same(laws, OURS)


@pytest.mark.parametrize("stage", [flexura.focus, flexura.compensate])
def test_the_library_takes_them(run: Path, seen: list[MaterialLaws], tmp_path: Path, stage: Any) -> None:
    (tmp_path / "panel.toml").write_text(PANEL, encoding="utf-8")
    with pytest.raises(LawsSeenError):
        stage(run, tmp_path / "panel.toml")
    assert same(seen[0], OURS)


def test_what_panels_are_made_from_says_so_and_keeps_the_plain_laws_beside(run: Path) -> None:
    read = laws_for(run, None, "test")
    assert same(read.laws, OURS)
    assert read.path.name == "laws-corrected.h5"
    assert any(SAID in note for note in read.notes)
    plain = read.without_effects(np.array([0.0, 40.0]))
    assert plain is not None
    assert same(plain, PLAIN)
    assert read.without_effects(np.array([0.0, 60.0])) is None


def test_a_file_of_laws_that_is_named_itself_is_taken_and_it_is_said(run: Path) -> None:
    read = laws_for(run / "laws.h5", None, "test")
    assert same(read.laws, PLAIN)
    assert "its laws are uncorrected" in read.notes[0]
    assert laws_for(run / "laws-corrected.h5", None, "test").notes == ()


def test_update_says_which_laws_are_used_from_here_on(run: Path) -> None:
    best = best_twin(run, "update")
    assert "report, focus and compensate use laws-corrected.h5" in overtaken(best)[0]
    assert best.record == {"laws": "laws-corrected.h5", "effects": ["point_mass"], "ignored": []}


def test_filters_from_the_plain_laws_are_said_to_be_overtaken(run: Path) -> None:
    from app.report.written import _overtaken

    stale = {"filters.h5": {"inputs": {"laws.h5": "0a"}}, "studies.h5": {"inputs": {"laws-corrected.h5": "0b"}}}
    (said,) = _overtaken(run, stale)
    assert said.startswith("filters.h5 was made with the uncorrected laws")


def test_without_a_comparison_all_is_as_it_was(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", record("none"))
    (run / "laws-corrected.h5").unlink()
    with drawing():
        found = sections(run, lambda *_: None)
    html = "".join(item.html() for section in found.sections for item in section.items)
    assert "uncorrected" not in html
    assert json.loads((run / "gap.json").read_text(encoding="utf-8"))["verdict"] == "none"


READERS = {"load_laws", "laws_if_any", "load_updated"}
ALLOWED = {
    "app/chain/made_by_verbs.py": "only whether an update settled: it prints no law",
    "app/files/results/best_twin.py": "decides",
    "app/files/results/laws_file.py": "defines them",
    "app/stages/panel/laws.py": "a file of laws that is named itself, and the uncorrected ones of a twin file",
    "app/twins/expected_modes.py": "modes of the plain twin, which need its own laws",
}


def test_no_other_module_reads_laws_from_a_run() -> None:
    """A place that prints E, nu or eta asks `best_twin`: a new one that reads a file itself fails here."""
    readers = set()
    for path in [*(ROOT / "app").rglob("*.py"), *(ROOT / "flexura").rglob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = {alias.name for alias in node.names} if isinstance(node, ast.ImportFrom) else set()
            if isinstance(node, ast.FunctionDef):
                names = {node.name}
            if names & READERS:
                readers.add(str(path.relative_to(ROOT)))
    assert readers == set(ALLOWED)


def test_the_words_for_people_use_their_units() -> None:
    html = Words("a", True, (), [("b", ("0.80 g",))]).html()
    assert re.findall(r"<d[td]>", html) == ["<dt>", "<dd>"]
