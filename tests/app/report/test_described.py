"""The report on an unknown cause and on the next experiment: what its artists hold, what its words say."""

from typing import Any

import numpy as np
import pytest

from app.report.gap_section import curve, description_items, maps
from app.report.page import PageTable, Paragraph, Picture
from app.report.style import drawing
from app.summaries.gap import answer_words, plan_rows, plan_table, plan_words

PLACES = [[0.03 * k, 0.04] for k in range(1, 6)]


def cell_map(top: float) -> dict[str, Any]:
    value = [0.0, top, 0.0, 0.0, 0.0]
    return {"value": value, "sigma": [0.1 * top] * 5, "resolution_m": 0.03, "unit": "", "log_evidence_gain": 9.0}


@pytest.fixture
def record() -> dict[str, Any]:
    shape = {
        "frequency_hz": [100.0, 400.0, 1500.0],
        "first": [1e-3, 2e-3, 0.0],
        "second": [0.0, 1e-3, 0.0],
        "sigma_first": [1e-4] * 3,
        "sigma_second": [1e-4] * 3,
    }
    metres = {"value": 0.06, "sigma": 0.001, "unit": "m"}
    best = {
        "name": "mass",
        "log_evidence_gain": 80.0,
        "share": 0.97,
        "parameters": {"mass": {"value": 2e-3, "sigma": 1e-4, "unit": "kg"}, "x": metres, "y": metres},
        "or_at_m": [],
        "curve": None,
    }
    maps_ = {kind: cell_map(top) for kind, top in (("mass", 1e-3), ("stiffness", 50.0), ("damping", 0.1))}
    description = {
        "best": best,
        "forms": [{"name": "mass", "curve": None}, {"name": "load", "curve": shape}],
        "dependence": [
            {"on": "ramp", "label": ["up", "down"], "factor": [1.0, 1.0], "sigma": [0.1, 0.1], "constant": True}
        ],
        "map": {"places_m": PLACES, **maps_},
        "effect_file": None,
    }
    questions = [
        {"kind": "look-alike", "effect": "draught_gradient", "rival": "thickness_taper", "separation_sigma": 1.2},
        {"kind": "blind spot", "effect": "thermal_lag", "rival": None, "separation_sigma": 0.0},
    ]
    both = {
        "key": "both_ramps",
        "words": "Record both ways.",
        "hours": 3.3,
        "gain_sigma": 8.8,
        "gain_per_hour": 2.7,
        "settles": [0, 1],
        "separation_sigma": [6.0, 40.0],
    }
    chosen = {"words": both["words"], "hours": 3.3, "experiment": "next-experiment.toml", "to_complete": ""}
    plan = {"questions": questions, "measurements": [both], "next": chosen}
    return {"description": description, "plan": plan, "effects": [], "titles": {"thermal_lag": "lag of the plate"}}


def test_maps_show_what_stands_out_and_where_the_cause_is(record: dict[str, Any]) -> None:
    with drawing():
        axes = maps(record["description"]).axes[:3]
    for each in axes:
        out, cause = each.lines
        np.testing.assert_allclose(out.get_xydata(), [[60.0, 40.0]])
        np.testing.assert_allclose(cause.get_xydata(), [[60.0, 60.0]])
    assert "30 mm" in axes[0].get_xlabel()


def test_a_curve_is_drawn_in_units_that_people_use(record: dict[str, Any]) -> None:
    with drawing():
        figure = curve("load", record["description"]["forms"][1]["curve"])
    first = figure.axes[0]
    np.testing.assert_allclose(first.lines[0].get_ydata(), [1.0, 2.0, 0.0])
    assert first.get_ylabel() == "apparent mass [g]"


def test_the_part_says_shows_and_tells_the_strength(record: dict[str, Any]) -> None:
    with drawing():
        items = description_items(record)
    assert [type(item) for item in items] == [Paragraph, Picture, Picture, Paragraph, PageTable]
    assert description_items({"description": None}) == []


def test_a_plan_names_the_measurement_and_what_it_settles(record: dict[str, Any]) -> None:
    assert plan_rows(record) == [
        ("Record both ways.", "3.3", "draught gradient or thickness taper; lag of the plate: there or not", "2.7")
    ]
    words = plan_words(record)
    assert words[0] == "Record both ways. (3.3 h)"
    assert words[1] == "It would settle draught gradient or thickness taper: 6 sigma apart, 1.2 now."
    assert words[-1] == "Its experiment: next-experiment.toml."
    assert len(plan_table(record).rows) == 1
    assert plan_table({"plan": None}).rows == ()


def test_a_plan_without_questions_or_measurements_says_so() -> None:
    nothing: dict[str, Any] = {"plan": {"questions": [], "measurements": [], "next": None}, "effects": []}
    assert plan_words(nothing) == ["Nothing is open that another measurement could settle."]
    nothing["plan"]["questions"] = [{"effect": "a", "rival": None}]
    assert "None of the measurements" in plan_words(nothing)[0]
    assert plan_words({}) == []


def test_an_answer_names_what_is_settled_and_what_comes_next() -> None:
    nats = {"thickness_taper": 0.0, "draught_gradient": -12.3, "nothing": -200.0}
    record: dict[str, Any] = {"answer": {"settled": "thickness_taper", "relative_nats": nats}, "effects": []}
    assert answer_words(record) == [
        "Both campaigns together settle it: thickness taper; draught gradient is 12 nats behind."
    ]
    record["answer"] = {"settled": None, "relative_nats": {"nothing": 0.0, "thermal_lag": -2.0}}
    assert answer_words(record) == [
        "Both campaigns together do not settle it: none of them, and thermal lag is 2 nats behind."
    ]
    assert answer_words({}) == []
