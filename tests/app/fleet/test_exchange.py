"""Filters of one panel on another: nothing is lost by a twin's, more the further the laws are apart."""

import dataclasses
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from app.files.provenance import provenance
from app.files.results.laws_file import load_laws, load_updated, save_laws
from app.fleet.laws_beside import USABLE_LOSS, exchanged
from tests.app.chain.conftest import RunOnce, campaign_of_four, typed, whole

pytestmark = pytest.mark.slow
__all__ = ["campaign_of_four", "whole"]  # fixtures of a run that is made once


def silent(stage: str, share: float) -> None:
    """Exchanged filters."""


@pytest.fixture
def panels(whole: RunOnce, tmp_path: Path) -> Callable[[float], Path]:
    """Return the run of a panel whose E is a factor times that of the run, with filters of its own."""

    def panel(factor: float) -> Path:
        run = shutil.copytree(whole.run, tmp_path / f"{factor}")
        if factor != 1.0:
            laws, (updated, twin) = load_laws(run / "laws.h5"), load_updated(run / "laws.h5")
            coefficients = laws.coefficients + np.array([[np.log(factor)], [0.0], [0.0]])
            softer = dataclasses.replace(laws, coefficients=coefficients)
            save_laws(run / "laws.h5", updated, softer, twin, provenance({}))
            assert typed("focus", run, "--panel", whole.panel, "--quiet") == 0
        return run

    return panel


def test_what_filters_lose_on_other_panels(panels: Callable[[float], Path]) -> None:
    runs = {str(factor): panels(factor) for factor in (1.0, 0.98, 0.8)}
    runs["its twin"] = shutil.copytree(runs["1.0"], runs["1.0"].with_name("twin"))
    runs["without filters"] = runs["1.0"].with_name("empty")
    with ThreadPoolExecutor(1) as executor:
        found = exchanged(runs, executor, silent)
    assert found is not None
    assert found.names == ("1.0", "0.98", "0.8", "its twin")
    np.testing.assert_array_equal(np.diag(found.loss), 0.0)
    assert found.loss[0, 3] == found.loss[3, 0] == 0.0
    for row, near, far in ((0, 1, 2), (2, 1, 0)):
        assert found.loss[row, far] > USABLE_LOSS
        assert found.loss[row, near] < found.loss[row, far]
    assert "its twin" in found.users_of(0)
    assert "0.8" not in found.users_of(0)


def test_one_panel_has_nobody_to_exchange_with(tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as executor:
        assert exchanged({"a": tmp_path}, executor, silent) is None
