"""Reports in Chromium: nothing overflows or is too small to read on a telephone, a tablet and a screen."""

import base64
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from app.files.uff.frfs import write_frfs
from tests.app.corrected_run import write_run
from tests.app.modal_test.conftest import Beam
from tests.browser import Browser, opened_browser

pytestmark = pytest.mark.slow
Run = Callable[..., tuple[int, str, str]]
LEAST = 11.0
"""Pixels of the smallest letters."""
DOTS_PER_POINT = 96.0 / 72.0
OVERFLOWING = """
const wide = document.documentElement.clientWidth;
const scrolls = (one) => {
  for (let up = one.parentElement; up; up = up.parentElement)
    if (['auto', 'scroll'].includes(getComputedStyle(up).overflowX)) return true;
  return false;
};
return [...document.querySelectorAll('body *')].filter((one) => {
  const box = one.getBoundingClientRect();
  return box.width > 0 && (box.right > wide + 1 || box.left < -1) && !scrolls(one);
}).map((one) => one.outerHTML.slice(0, 100));
"""
SMALLEST = """
const sizes = [...document.querySelectorAll('body *')]
  .filter((one) => [...one.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))
  .filter((one) => one.getClientRects().length)
  .map((one) => parseFloat(getComputedStyle(one).fontSize));
return Math.min(...sizes);
"""
TALLEST = """
return Math.max(0, ...[...document.querySelectorAll('tbody tr')].filter((row) => row.cells.length >= 4)
  .map((row) => row.getBoundingClientRect().height));
"""
"""Height of the tallest row of a table that is wider than a telephone and scrolls, px."""
FIGURES = "return [...document.querySelectorAll('figure img')].map((i) => [i.src, i.width / i.naturalWidth])"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with opened_browser() as found:
        yield found


def after_a_gap(folder: Path, run_flexura: Run) -> Path:
    return write_run(folder / "run")


def of_a_modal_test(folder: Path, run_flexura: Run) -> Path:
    frequency, rng, frfs = np.arange(40.0, 700.0, 0.5), np.random.default_rng(0), []
    for i in range(4):
        h = Beam().frf(frequency, i, 0, 2)
        h = h + 1e-3 * np.abs(h).max() * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
        frfs.append(MeasuredTransfer(f"point {i + 1}", f"{i + 1}:+3", "1:+3", "acceleration", frequency, h))
    write_frfs(folder / "beam.uff", frfs)
    words = ("identify", folder / "beam.uff", "--shared-poles", "--out", folder / "run", "--quiet")
    status, _, said = run_flexura(*words)
    assert status == 0, said
    return folder / "run"


def smallest_letters(source: str) -> float:
    """Height of the smallest letters of an SVG figure at its own size, px; matplotlib writes points over 100."""
    svg = base64.b64decode(source.partition("base64,")[2]).decode()
    found = re.findall(r"scale\((0\.\d+) -0\.\d+\)", svg)
    assert found, "no letters"
    return 100.0 * min(map(float, found)) * DOTS_PER_POINT


@pytest.mark.parametrize("made", [after_a_gap, of_a_modal_test])
def test_a_report_is_read_on_every_screen(
    made: Callable[[Path, Run], Path], tmp_path: Path, run_flexura: Run, browser: Browser
) -> None:
    run = made(tmp_path, run_flexura)
    status, _, said = run_flexura("report", run, "--quiet")
    assert status == 0, said
    for width in (360, 768, 1280):
        for dark in (False, True):
            browser.look((run / "report.html").as_uri(), width, dark=dark)
            assert browser.run("return document.documentElement.scrollWidth") <= width
            assert browser.run(OVERFLOWING) == []
            assert browser.run(SMALLEST) >= LEAST
            assert browser.run(TALLEST) <= 100.0  # three lines of a reason
            for source, share in browser.run(FIGURES):
                if source.startswith("data:image/svg"):
                    assert share * smallest_letters(source) >= LEAST - 0.1, width
        browser.look((run / "report.html").as_uri(), 680)  # A4 less its margins
        browser.cdp("Emulation.setEmulatedMedia", {"media": "print"})
        assert browser.run(TALLEST) <= 80.0
        browser.look((run / "report.html").as_uri(), width)
        first = browser.run("return document.querySelector('h2').getBoundingClientRect().top")
        assert first < 400
        assert browser.run("return document.querySelectorAll('details:not([open])').length") == 1
        assert browser.run("return document.documentElement.scrollHeight") < 30 * 900
    assert browser.complaints() == []
