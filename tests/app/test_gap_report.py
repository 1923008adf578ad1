"""What the gap workflow found, as gap.json, gap.h5, words and a section of the report; no twin needed."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.estimates import Estimate, FittedLaws
from analysis.gap.data.noise import NoiseCheck
from analysis.gap.fitting.residual_map import Region, ResidualMap
from analysis.gap.fitting.state import GapState
from analysis.gap.report import Agreement, CandidateRow, GapReport, NamedEffect, PlainTwin
from analysis.gap.search.held_out import HeldOut
from analysis.gap.search.observability import Observability
from app.files.bad_file import ResultFileError
from app.files.results.gap_file import GapFigures, load_gap, save_gap
from app.files.results.gap_json import gap_record
from app.report.gap_section import gap_section, verdict
from app.report.page import PageTable, Paragraph, Picture, VerdictBox
from app.report.style import drawing
from app.report.summary import summary as of_run
from app.summaries.gap import estimate, summary
from app.summaries.numbers import FIXED

TEMPERATURE = np.array([10.0, 30.0, 30.05, 10.02])
CHANNELS = ("S1", "S2")


def residual(size: float) -> ResidualMap:
    """One loud cell on S1 at the second temperature, noise elsewhere."""
    sigma = np.ones((4, 2, 6))
    sigma[1:3, 0, 4] = size
    region = Region("S1", (900.0, 1100.0), (30.0, 30.0), 1.0, size)
    return ResidualMap(
        edges=np.linspace(100.0, 1300.0, 7),
        temperature=TEMPERATURE,
        direction=("up", "up", "down", "down"),
        level=np.ones(4),
        drives=("1 N",) * 4,
        channels=CHANNELS,
        sigma=sigma,
        excess=50.0 * (sigma**2 - 1.0),
        readings=np.zeros(4),
        regions=(region,) if size > 1.0 else (),
    )


def laws(shift: float) -> FittedLaws:
    value = np.array([[21.8, 0.35, -2.6], [21.2, 0.40, -2.9]])
    return FittedLaws(np.array([10.0, 30.0]), value + shift, np.full((2, 3), 1e-3))


@pytest.fixture
def explained() -> GapReport:
    mass = NamedEffect(
        name="point_mass",
        summary="a mass at the cable",
        equivalent=("suspension",),
        separated_by="weigh the cable",
        probability=0.98,
        against={"nothing": -512.5, "unknown": -300.0, "suspension": -1.5},
        log_evidence_gain=512.5,
        parameters=(Estimate("mass", 7.9e-4, 1e-5, "kg"),),
    )
    lag = Observability("thermal_lag", 0.0, 0.01, "an up and a down ramp")
    seen = (lag, Observability("point_mass", 0.7, 80.0, "a cable"))
    state = GapState(
        laws(0.0).value, *np.zeros((2, 2, 3)), np.zeros(4), np.array([2.8]), {"point_mass": {"mass": 7.9e-4}}
    )
    return GapReport(
        verdict="explained",
        effects=(mass,),
        not_observable=(lag,),
        seen=seen,
        baseline=Agreement(8.0, 0.05, 90.0, (20.0, 15.0)),
        final=Agreement(1.01, 0.008, 0.5, (0.3, -0.2)),
        held_out=(
            HeldOut("every second temperature", 8000.0, 1010.0, 1000.0, 0.05, 0.008, 0.9985, 0.0064),
            HeldOut("channel S2", 4500.0, 530.0, 500.0, 0.06, 0.009, 0.9925, None),
        ),
        unexplained=0.001,
        before=residual(9.0),
        after=residual(1.0),
        laws_before=laws(0.01),
        laws_after=laws(0.0),
        plain=PlainTwin(state.with_effects({}), laws(0.01), np.array([1e-3]), ()),
        state=state,
        sigma_gain=np.array([1e-3]),
        candidates=(
            CandidateRow("point_mass", 500.0, 512.5, 0.999, 0.7, 1.0),
            CandidateRow("suspension", 480.0, 490.0, 0.98, 0.6, 0.97),
            CandidateRow("orthotropy", 12.0, None, None, 0.9, 0.2),
            CandidateRow("thermal_lag", 0.0, None, None, 0.0, 0.0),
        ),
        signatures=(),
        steps=(),
        noise=NoiseCheck(np.array([1.02, 0.97]), np.ones((4, 2)), 5000, np.zeros((4, 2, 6)), ()),
        notes=("with the effects named, twin and data agree to the noise",),
        seconds=3.0,
    )


@pytest.fixture
def none(explained: GapReport) -> GapReport:
    quiet = Agreement(1.0, 0.008, 0.2, (0.1, 0.1))
    return replace(
        explained,
        verdict="none",
        effects=(),
        baseline=quiet,
        final=quiet,
        held_out=(),
        unexplained=None,
        before=residual(1.0),
        after=residual(1.0),
        laws_after=explained.laws_before,
    )


def numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        return [n for item in value.values() for n in numbers(item)]
    if isinstance(value, list):
        return [n for item in value for n in numbers(item)]
    return [value] if isinstance(value, float) else []


def test_gap_json_has_the_keys_of_its_contract(explained: GapReport) -> None:
    record = gap_record(explained, {}, {"flexura": "0"}, 41.2)
    text = json.dumps(record, allow_nan=False)
    assert json.loads(text) == record
    assert {"schema", "verdict", "effects", "not_observable", "gap", "unexplained", "seconds"} <= set(record)
    assert record["schema"] == "flexura-gap/1"
    (effect,) = record["effects"]
    assert effect["parameters"] == {"mass": {"value": 7.9e-4, "sigma": 1e-5, "unit": "kg"}}
    assert effect["equivalent"] == ["suspension"]
    assert (effect["probability"], effect["log_evidence_gain"]) == (0.98, 512.5)
    assert record["not_observable"] == ["thermal_lag"]
    assert record["gap"]["baseline"]["chi2_per_dof"] == 8.0
    held = record["gap"]["held_out"]
    assert held["what"] == "every second temperature"
    assert held["baseline"] == {"chi2_per_dof": 8.0, "relative_misfit": 0.05}
    assert held["final"]["chi2_per_dof"] == pytest.approx(1.01)
    assert (held["closure"], held["closure_sigma"]) == (0.9985, 0.0064)
    assert [also["what"] for also in record["gap"]["held_out_also"]] == ["channel S2"]
    assert record["gap"]["held_out_also"][0]["final"]["chi2_per_dof"] == pytest.approx(1.06)
    assert record["unexplained"] == {"share": 0.001, "where": []}
    assert record["where"]["regions"][0]["frequency_hz"] == [900.0, 1100.0]
    assert record["where"]["shares"]["channel"] == {"S1": 1.0, "S2": 0.0}
    assert all(math.isfinite(n) for n in numbers(record))


def test_without_a_gap_there_is_nothing_to_close(none: GapReport) -> None:
    record = gap_record(none, {}, {}, 1.0)
    assert (record["verdict"], record["effects"]) == ("none", [])
    assert record["unexplained"] == {"share": None, "where": []}
    assert record["gap"]["held_out"]["closure"] is None
    assert record["gap"]["held_out"]["final"] == record["gap"]["held_out"]["baseline"]
    json.dumps(record, allow_nan=False)


def test_an_unexplained_gap_closes_nothing_and_says_where_it_sits(explained: GapReport) -> None:
    report = replace(
        explained,
        verdict="unknown",
        effects=(),
        held_out=(),
        final=explained.baseline,
        after=explained.before,
        unexplained=1.0,
    )
    record = gap_record(report, {}, {}, 1.0)
    assert record["gap"]["held_out"]["closure"] == 0.0
    assert record["unexplained"]["where"][0]["channel"] == "S1"
    assert record["unexplained"]["where"][0]["temperature_c"] == [30.0, 30.0]


def test_gap_h5_is_read_back(explained: GapReport, tmp_path: Path) -> None:
    record = gap_record(explained, {}, {}, 1.0)
    save_gap(tmp_path / "gap.h5", GapFigures.of(explained, explained.laws_after), (), record, {"flexura": "0"})
    figures, again = load_gap(tmp_path / "gap.h5")
    assert again == record
    np.testing.assert_array_equal(figures.before.sigma, explained.before.sigma)
    np.testing.assert_array_equal(figures.laws_after.value, explained.laws_after.value)
    assert figures.before.channels == CHANNELS
    (tmp_path / "gap.h5").write_bytes(b"spoilt")
    with pytest.raises(ResultFileError, match="flexura gap"):
        load_gap(tmp_path / "gap.h5")


def test_sweeps_at_one_temperature_share_a_row_of_the_map(explained: GapReport) -> None:
    figures = GapFigures.of(explained, explained.laws_after)
    temperature, sigma = figures.before.by_temperature(0)
    np.testing.assert_allclose(temperature, [10.01, 30.025])
    np.testing.assert_allclose(sigma[1], [1, 1, 1, 1, 9, 1])
    np.testing.assert_allclose(figures.before.by_temperature(1)[1], 1.0)


def test_the_report_shows_verdict_maps_evidence_and_laws(explained: GapReport, tmp_path: Path) -> None:
    record = gap_record(explained, {}, {}, 1.0)
    save_gap(tmp_path / "gap.h5", GapFigures.of(explained, explained.laws_after), (), record, {})
    with drawing():
        items = gap_section(tmp_path / "gap.h5")
        names = [item.name for item in items if isinstance(item, Picture)]
        html = "".join(item.html() for item in items)
    assert names == ["gap-map", "gap-shares", "gap-candidates", "gap-laws"]
    assert isinstance(items[0], VerdictBox)
    assert any(isinstance(item, PageTable) for item in items)
    for wanted in (
        "point mass or suspension",
        "point_mass or suspension",
        "weigh the cable",
        "an up and a down ramp",
        "0.000790",
    ):
        assert wanted in html
    assert "99.85 ± 0.64 % of the gap closes" in html
    wanted = "gap explained: point mass: mass 0.790 ± 0.010 g (or, not to be told from it: suspension); chi2"
    assert of_run(tmp_path)["gap"].replace(FIXED, " ").startswith(wanted)


def test_no_gap_needs_no_table_of_effects(none: GapReport, tmp_path: Path) -> None:
    save_gap(tmp_path / "gap.h5", GapFigures.of(none, none.laws_after), (), gap_record(none, {}, {}, 1.0), {})
    with drawing():
        items = gap_section(tmp_path / "gap.h5")
    pictures = [item for item in items if isinstance(item, Picture)]
    assert [picture.name for picture in pictures] == ["gap-map", "gap-candidates"]
    titles = [axes.get_title() for axes in pictures[0].figure.axes]
    assert not any("before" in title or "after" in title for title in titles)  # which would be the same
    assert "(right)" not in pictures[0].caption


def test_modes_without_a_gap_stand_in_the_section_of_the_twin_only(
    none: GapReport, explained: GapReport, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same table of thirty rows stood twice in a report."""
    said = Paragraph("modes beside those of the twin")
    monkeypatch.setattr("app.report.gap_section.pairing_items", lambda *_: [said])
    for number, (found, there) in enumerate(((none, False), (explained, True))):
        path = tmp_path / str(number) / "gap.h5"
        path.parent.mkdir()
        save_gap(path, GapFigures.of(found, found.laws_after), (), gap_record(found, {}, {}, 1.0), {})
        with drawing():
            assert (said in gap_section(path)) is there


def test_only_settled_verdicts_look_settled(explained: GapReport) -> None:
    looks = {}
    for name in ("explained", "partly_explained", "unknown"):
        looks[name] = verdict(gap_record(replace(explained, verdict=name), {}, {}, 1.0))  # type: ignore[arg-type]
    assert [looks[n].settled for n in looks] == [True, False, False]
    assert "hints" in looks["unknown"].headline
    assert "<script>" not in VerdictBox("<script>", ["<b>"], settled=True).html()


def test_one_line_says_what_was_found(explained: GapReport, none: GapReport) -> None:
    line = summary(gap_record(explained, {}, {}, 41.2), Path("run"))
    assert line == "gap explained: point mass or suspension; chi2 per dof 8 -> 1.01; 41.2 s; results in run"
    assert summary(gap_record(none, {}, {}, 1.0), Path("run")).startswith("no gap: twin and data agree")


@pytest.mark.parametrize(
    ("value", "sigma", "unit", "words"),
    [
        (7.9123e-4, 1.3e-5, "kg", "0.000791 ± 0.000013 kg"),
        (7.9123e-6, 1.3e-7, "m", "(7.91 ± 0.13)e-6 m"),
        (0.0, 0.11, "1", "0.00 ± 0.11"),
        (-0.0412345, 0.000123, "1", "-0.04123 ± 0.00012"),
        (270.123, 0.5, "s", "270.12 ± 0.50 s"),
        (123456.0, 3000.0, "N/m", "(1.235 ± 0.030)e5 N/m"),
        (2e-9, 4e-6, "1", "(0.0 ± 4.0)e-6"),
        (1.0, 0.0, "V/V", "1 V/V"),
    ],
)
def test_values_show_as_many_digits_as_they_are_worth(value: float, sigma: float, unit: str, words: str) -> None:
    assert estimate({"value": value, "sigma": sigma, "unit": unit}) == words
