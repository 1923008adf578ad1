"""``flexura health``: what is refused, what is said, and a changed panel from its recordings to the sentence."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexura
from analysis.health.candidates import ChangeCandidate, change_candidates
from analysis.health.refined import RefinedChange
from analysis.health.watch import HealthDate, HealthReport, NamedChange
from analysis.recordings.frf import Frf
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance
from app.files.results.modes_file import save_frf
from app.report.health import trend
from app.report.style import drawing
from app.stages.health import LaterDate, played_signals, same_sweeps
from app.summaries.health import change_words, headline, health_record, tables
from simulation.effects.library import library
from tests.app.corrected_run import write_run
from tests.app.view.conftest import experiment, frf

Flexura = Callable[..., tuple[int, str, str]]


def candidate(x: float = 0.06) -> ChangeCandidate:
    cards = {name: effect.card(experiment()) for name, effect in library(experiment()).items()}
    found = next(c for c in change_candidates(cards, {}, ("A1", "S1")) if c.effect == "mass_at_place")
    return replace(found, shapes={"x": x, "y": 0.11})


def report(*, changed: bool) -> HealthReport:
    dates = [HealthDate(f"week {n}", 20.0 + n, 20.1 + n, 0.1, 1.0, 1.0 + n, "added mass", 1) for n in range(3)]
    change = RefinedChange(
        candidate(), {"mass": 2.01e-3, "x": 0.06, "y": 0.11}, {"mass": 4e-5, "x": 1e-3, "y": 2e-3}, 50.0, 1.1
    )
    if not changed:
        return HealthReport(1e-3, 4.8, 1.4, tuple(dates), None, 1.2, 1)
    dates[2] = replace(dates[2], z=20.0, alarm=True)
    skipped = HealthDate("week 3", 80.0, skipped="its temperature is outside the baseline's 0.0 to 60.0 °C")
    named = NamedChange(
        "mass", 0.98, (("mass", 0.98), ("damage", 0.02)), change, "week 2", 1, ((0.0, 1e-4),) * 2 + ((2e-3, 1e-4),)
    )
    return HealthReport(1e-3, 4.8, 1.4, (*dates, skipped), named, 1.2, 1)


def test_a_folder_that_is_no_date_is_refused(run_flexura: Flexura, tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    status, out, err = run_flexura("health", tmp_path / "thesis", "--baseline", write_run(tmp_path / "run"))
    assert (status, out) == (2, "")
    assert "thesis: no date of a panel; allowed: a run folder with frf.h5" in err


def test_sound_of_another_panel_is_refused(run_flexura: Flexura, tmp_path: Path) -> None:
    soundfile = pytest.importorskip("soundfile")
    played, run = tmp_path / "music", write_run(tmp_path / "run")
    played.mkdir()
    soundfile.write(played / "drive.wav", np.zeros((4_000, 1)), 4_000)
    status, out, err = run_flexura("health", played, "--baseline", run)
    assert (status, out) == (2, "")
    assert "music: holds drive.wav and no response.wav; record what the panel answered, too" in err
    inputs, outputs = ("A1",), ("S1", "S2")
    for channels, rate, said in (
        (3, 4_000, "response.wav: 3 channels; the baseline has 2 outputs: S1, S2, a channel each"),
        (2, 8_000, "response.wav: 4000 samples at 8000 Hz; those of drive.wav are 4000 at 4000 Hz: record both"),
        (2, 4_000, "drive.wav: sampled at 4000 Hz; allowed: from 6000 Hz"),
    ):
        soundfile.write(played / "response.wav", np.zeros((4_000, channels)), rate)
        with pytest.raises(ResultFileError, match=re.escape(said)):
            played_signals(played / "drive.wav", played / "response.wav", inputs, outputs, 3_000.0)


def test_a_folder_that_is_no_baseline_is_refused(run_flexura: Flexura, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    status, _, err = run_flexura("health", write_run(tmp_path / "week"), "--baseline", tmp_path / "empty")
    assert status == 2
    assert "empty: holds no laws.h5; make it with: flexura update" in err


def test_a_date_that_is_the_baseline_or_comes_twice_is_told() -> None:
    measured, new = frf(), replace(frf(), h=2.0 * frf().h)

    def date(name: str, of: Frf) -> LaterDate:
        return LaterDate(name, Path(name), experiment(), of, "plate.toml", {})

    said = same_sweeps([date("run", measured), date("week 1", new), date("week 2", new)], measured)
    assert said == [
        "run: has sweeps of the baseline: no change of these says nothing",
        "week 2: has sweeps of week 1: no change of these says nothing",
    ]


def test_one_date_of_the_library_need_not_be_in_a_list(monkeypatch: pytest.MonkeyPatch) -> None:
    """The letters of its name were taken for folders."""
    asked = []
    monkeypatch.setattr("app.stages.health.compute", lambda request, report: asked.append(request.dates))
    for dates in ("week", Path("week"), ["week"]):
        flexura.health(dates, "healthy", progress=False)
    assert asked == 3 * [(Path("week"),)]


def test_the_baseline_of_another_plate_is_refused(run_flexura: Flexura, tmp_path: Path) -> None:
    week, other = tmp_path / "week", experiment()
    patches = (other.patch[0], other.patch[1].model_copy(update={"center": (0.05, 0.035)}), other.patch[2])
    plate = other.plate.model_copy(update={"thickness": 0.004})
    week.mkdir()
    save_frf(week / "frf.h5", other.model_copy(update={"plate": plate, "patch": patches}), frf(), provenance({}))
    status, _, err = run_flexura("health", week, "--baseline", write_run(tmp_path / "run"))
    assert status == 2
    assert "frf.h5: plate.thickness = 0.004; allowed: 0.003" in err
    assert "patch[1].center = (0.05, 0.035); allowed: (0.04, 0.035)" in err
    assert "name its own baseline" in err
    assert not (tmp_path / "run" / "health.json").exists()


def test_other_frequency_lines_are_refused(run_flexura: Flexura, tmp_path: Path) -> None:
    week, measured = tmp_path / "week", frf()
    week.mkdir()
    short = replace(
        measured,
        frequency=measured.frequency[:-10],
        h=measured.h[..., :-10],
        variance=measured.variance[..., :-10],
        coherence=measured.coherence[..., :-10],
        excluded=measured.excluded[:-10],
    )
    save_frf(week / "frf.h5", experiment(), short, provenance({}))
    status, _, err = run_flexura("health", week, "--baseline", write_run(tmp_path / "run"))
    assert status == 2
    assert "week: 390 lines from 100 to 878 Hz; allowed: those of the baseline, 400 from 100 to 898 Hz" in err


def test_the_result_is_said_in_words() -> None:
    said = headline(report(changed=True)).replace("\u00a0", " ")
    what = "added mass 2.01 ± 0.04 g at x 60.0 ± 1.0 mm, y 110 ± 2 mm"
    assert said == f"changed: {what}, probability 0.980; first alarm on week 2"
    assert headline(report(changed=False)) == "no change on the last of 3 dates (largest 3.0 of 4.8 σ)"


def test_places_that_cannot_be_told_apart_are_both_said() -> None:
    found = report(changed=True).found
    assert found is not None
    assert found.change is not None
    other = replace(found.change, values={"mass": 2e-3, "x": 0.18, "y": 0.08})
    said = change_words(replace(found, also=(other,))).replace("\u00a0", " ")
    assert said.endswith("y 110 ± 2 mm, or at x 180.0 ± 1.0 mm, y 80 ± 2 mm")
    assert change_words(replace(found, family="unknown")) == "a change that no effect explains"


def test_record_and_tables_hold_every_date() -> None:
    found = report(changed=True)
    record = health_record(found)
    json.dumps(record, allow_nan=False)
    assert record["verdict"] == "changed"
    assert record["first_alarm"] == "week 2"
    assert record["change"]["parameters"]["x"] == {"value": 0.06, "sigma": 1e-3, "unit": "m"}
    assert [one.get("skipped", "") != "" for one in record["dates"]] == [False, False, False, True]
    first, shares = tables(found)
    assert [row[-1] for row in first.rows] == ["", "", "alarm", "skipped"]
    assert shares.rows[0] == ("added mass", "0.980")


@pytest.mark.parametrize("changed", [False, True])
def test_the_trend_shows_limit_and_amplitude(changed: bool) -> None:
    with drawing():
        figure = trend(report(changed=changed))
    assert len(figure.axes) == (3 if changed else 2)
    assert any(line.get_ydata()[0] == 4.8 for line in figure.axes[1].lines if len(line.get_ydata()))
    if changed:
        assert figure.axes[2].get_ylabel() == "mass [g]"
        assert figure.axes[2].lines[0].get_ydata()[-1] == pytest.approx(2.0)
