"""The page itself: contents that lead to every figure, text that stays text, nothing to be fetched."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from app.report.page import POLICY, Listing, PageTable, Paragraph, Picture, Section, page


@pytest.fixture
def html() -> str:
    picture = Picture("waterfall", "What <changes> with temperature?", Figure(figsize=(1, 1)), 'Levels, "dB".')
    sections = [
        Section("Updated twin, and laws", [Paragraph("a < b & c"), picture]),
        Section("Provenance", [Listing("<script>alert(1)</script>"), PageTable(("a",), [("<b>",)])]),
    ]
    return page("Plate & panel", "two sweeps", sections)


def test_the_contents_lead_to_every_section_and_figure(html: str) -> None:
    anchors = re.findall(r'id="([^"]+)"', html)
    assert anchors == ["updated-twin-and-laws", "waterfall", "provenance"]
    assert re.findall(r'href="#([^"]+)"', html) == anchors


def test_a_figure_stands_under_the_question_it_answers(html: str) -> None:
    found = re.search(r"<figure[^>]*><h3>(.*?)</h3><img[^>]*><figcaption>(.*?)</figcaption>", html)
    assert found is not None
    assert found.groups() == ("What &lt;changes&gt; with temperature?", "Levels, &quot;dB&quot;.")


def test_figures_are_drawn_as_lines_unless_these_are_too_many() -> None:
    def drawn(points: int) -> str:
        figure = Figure(figsize=(3, 2))
        x = np.linspace(0.0, 1.0, points)
        figure.add_subplot().scatter(x, np.sin(40 * x) * np.cos(7000 * x))
        return Picture("lines", "?", figure, "").html()

    few = drawn(50)
    assert "data:image/svg+xml;base64," in few
    assert few == drawn(50)
    assert "data:image/png;base64," in drawn(20000)


def test_text_stays_text(html: str) -> None:
    assert "<script" not in html
    assert "a &lt; b &amp; c" in html
    assert "<title>Plate &amp; panel</title>" in html


def test_browsers_are_told_that_it_fetches_and_runs_nothing(html: str) -> None:
    assert f'http-equiv="Content-Security-Policy" content="{POLICY}"' in html
    assert "default-src 'none'" in POLICY
    assert set(re.findall(r'(?:src|href)="(data:|#|[^"]*)', html)) == {"data:", "#"}


def test_a_file_in_the_place_of_the_folder_is_told_before_anything_is_drawn(
    tmp_path: Path, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    for name in ("frf.h5", "notes"):
        (tmp_path / name).write_text("")
    status, _, said = run_flexura("report", tmp_path, "--out", tmp_path / "notes")
    assert status == 2
    assert f"{tmp_path / 'notes'}: cannot be written" in said
