"""The window after a comparison that named an effect: its values are the corrected ones, and it says so."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtWidgets import QLabel

from app.files.results.best_twin import BY_UPDATE
from app.view.application import application
from app.view.folder import viewed
from app.view.recorded.laws_page import LawsPage
from app.view.recorded.window import RecordedWindow
from app.view.theme import LIGHT
from tests.app.corrected_run import BEFORE, corrected, laws_of, write_run
from tests.app.view.conftest import updated


def laws_page(window: RecordedWindow) -> LawsPage:
    page = window.page([window.tabs.tabText(n) for n in range(window.tabs.count())].index("Laws"))
    assert isinstance(page, LawsPage)
    return page


def titled(window: RecordedWindow) -> tuple[float, float]:
    """E, GPa, and the temperature in the title of its chart."""
    text = laws_page(window)._charts[0].plotItem.titleLabel.text
    found = re.search(r"E = ([\d.]+) ± .*GPa at ([\d.]+) °C", text)
    assert found is not None, text
    return float(found[1]), float(found[2])


@pytest.mark.parametrize("stale", [False, True])
def test_the_titles_give_the_laws_of_the_best_twin(
    shown: Callable[[Any], Any], tmp_path: Path, stale: bool
) -> None:
    run = write_run(tmp_path / "run")
    if stale:
        (run / "gap.h5").unlink()
        (run / "gap.json").unlink()
    application()
    window = shown(RecordedWindow(viewed(run), LIGHT))
    value, at = titled(window)
    laws = laws_of(updated() if stale else corrected())
    assert value == pytest.approx(float(laws.at(at).youngs_modulus[0]) / 1e9, abs=0.02)
    said = window.centralWidget().findChild(QLabel, "origin")
    assert (said is None) is stale
    trouble = window.centralWidget().findChild(QLabel, "trouble")
    assert ("laws-corrected.h5 is not used" in trouble.text()) is stale
    if said is not None:
        assert "corrected (added mass at the cable; flexura gap)" in said.text()


@pytest.mark.parametrize("whole", [True, False])
def test_laws_before_are_those_of_the_report_and_the_misfit_before_says_whose_it_is(
    shown: Callable[[Any], Any], tmp_path: Path, whole: bool
) -> None:
    run = write_run(tmp_path / "run")
    if not whole:
        (run / "gap.h5").unlink()
    application()
    page = laws_page(shown(RecordedWindow(viewed(run), LIGHT)))
    curves = {label: (x, y) for label, x, y in page._charts[0].curves}
    name, factor = ("before", BEFORE) if whole else (BY_UPDATE, 1.0)
    x, y = curves[name]
    plain = factor * laws_of(updated()).at(x).youngs_modulus / 1e9
    np.testing.assert_allclose(y, plain, rtol=1e-3)
    x, y = curves[f"{name}, estimates"]
    np.testing.assert_allclose(y, factor * (3.0 - 0.03 * x), rtol=1e-9)
    assert "updated twin" not in curves
    x, y = curves[f"{name}, low"]
    assert (y < factor * (3.0 - 0.03 * x) - 0.005).all()  # two standard deviations of an estimate are 0.02 GPa
    assert [label for label, _, _ in page._last.curves] == [
        BY_UPDATE,
        "corrected twin",
        "noise of the measurement",
    ]
