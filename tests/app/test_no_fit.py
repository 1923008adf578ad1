"""A sensor declared where it is not: update, gap and report say that this is no fit, and why."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from threadpoolctl import threadpool_limits

from app.main import flexura

pytestmark = pytest.mark.slow
SAID = "this is no fit: at "
REASON = "S1 stands at 0.0"


def typed(*words: object) -> Result:
    with threadpool_limits(1):
        result = CliRunner().invoke(flexura, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def wrong(
    tmp_path_factory: pytest.TempPathFactory, cut_recording: Callable[[Path, tuple[int, ...]], None]
) -> Path:
    """Sweeps of the shipped recording, the sensor's y that of the actuator."""
    folder = tmp_path_factory.mktemp("no-fit") / "plate"
    cut_recording(folder, (0, 20, 60))
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert "center = [0.04, 0.035]" in text
    text = text.replace("center = [0.04, 0.035]", "center = [0.04, 0.155]")
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def compared(wrong: Path) -> tuple[Result, Path]:
    run = wrong.with_name("gap-run")
    return typed("gap", wrong, "--out", run), run


def test_update_says_so_and_looks_for_the_reason(wrong: Path) -> None:
    result = typed("update", wrong, "--out", wrong.with_name("run"), "--json")
    assert result.exit_code == 1
    assert SAID in result.stderr
    assert REASON in result.stderr
    assert "To find it: flexura gap" not in result.stderr
    pairing = json.loads(result.stdout)["pairing"]
    assert not pairing["fit"]
    assert REASON in pairing["likely_reason"]
    shown = pairing["sweeps"][pairing["shown"]]
    assert shown["matched"] < 0.6 * shown["strong"]
    assert shown["misfit"] > 0.5


def test_gap_says_so_and_names_nothing(compared: tuple[Result, Path]) -> None:
    result, run = compared
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1].startswith("unknown: this is no fit")
    assert SAID in result.stderr
    assert REASON in result.stderr
    assert "Modes at" in result.stdout
    for table in ("Hints", "What is left", "Not observable"):
        assert table not in result.stdout
    record = json.loads((run / "gap.json").read_text(encoding="utf-8"))
    assert (record["verdict"], record["effects"], record["candidates"]) == ("unknown", [], [])
    assert record["pairing"]["fit"] is False
    assert record["pairing"]["sweeps_after"] is None


def test_the_report_says_so_and_shows_no_candidates(compared: tuple[Result, Path]) -> None:
    _, run = compared
    result = typed("report", run, "--json")
    assert result.exit_code == 0
    figures = json.loads(result.stdout)["figures"]
    assert "gap-pairing" in figures
    assert "gap-candidates" not in figures
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "This is no fit" in page
    assert "Unknown: this is no fit" in page
