"""The table of a trial from outcomes made by hand, each figure counted on fingers."""

from typing import Any

import numpy as np
import pytest

from app.blind_trial.outcome import Named, TrialOutcome, outcome
from app.blind_trial.proof import claims, figures, likeliest_confidence, reliability, share
from app.blind_trial.proof_figure import confusion, proof_figure
from app.commands.blind_trial import confusion_table, figures_table


def named(name: str, *alike: str, p: float = 0.99, value: float = 1.0, sigma: float = 0.1) -> Named:
    return Named(name, alike, p, {"nothing": -50.0, "unknown": -50.0}, {"a": (value, sigma)})


def campaign(kind: str, hidden: tuple[str, ...] = (), size: float = 20.0, **what: Any) -> TrialOutcome:
    told: dict[str, Any] = {
        "number": 0,
        "kind": kind,
        "effects": {name: {"a": 1.0} for name in hidden},
        "scale": {name: {"a": 0.5} for name in hidden},
        "size": dict.fromkeys(hidden, size),
        "cosine": None,
        "imitations": {},
        "verdict": "explained" if what.get("named") else "none",
    }
    return TrialOutcome(**{**told, **what})


def table(*outcomes: TrialOutcome) -> dict[str, Any]:
    return {figure.name: figure for figure in figures(outcomes)}


def value(rows: dict[str, Any], start: str) -> tuple[float | None, int]:
    row = next(figure for name, figure in rows.items() if name.startswith(start))
    return row.value, row.count


def test_nulls_are_false_by_a_name_and_without_nuisances_by_a_gap():
    rows = table(
        campaign("null"), campaign("null", verdict="unknown"), campaign("null", named=(named("x"),)),
        campaign("null", verdict="refused"), campaign("null", verdict="unknown", scatter=0.003),
    )  # fmt: skip
    assert value(rows, "nulls: an effect claimed") == (0.4, 5)
    assert value(rows, "nulls without nuisances") == (0.75, 4)
    assert next(iter(rows.values())).met is False


def test_the_laws_bands_count_once_for_each_campaign():
    held, missed = (0.5, -1.6, 1.2, 0.1), (2.0, -1.7, 0.3, 1.8)
    laws = [{"youngs_modulus": held, "poisson_ratio": one, "loss_factor": held} for one in (held, missed)]
    rows = table(*(campaign("null", law_errors=one) for one in laws), campaign("null", verdict="refused"))
    assert value(rows, "true youngs_modulus") == (1.0, 2)
    assert value(rows, "true poisson_ratio") == (0.625, 2)


def test_a_name_and_a_class_are_two_things():
    rows = table(
        campaign("single", ("x",), named=(named("x"),)),
        campaign("single", ("x",), named=(named("y", "x"),)),
        campaign("single", ("x",), named=(named("y"),)),
        campaign("single", ("x",), named=(named("x"), named("y"))),
        campaign("single", ("x",)),
        campaign("single", ("x",), size=6.0),
        campaign("single", ("x",), size=6.0, named=(named("x"),)),
    )
    assert value(rows, "single, 15 sigma and more: right name") == (0.2, 5)
    assert value(rows, "single, 15 sigma and more: right class") == (0.4, 5)
    assert value(rows, "single, 6 sigma: an effect claimed") == (0.5, 2)
    assert value(rows, "single, 6 sigma, claimed: right name") == (1.0, 1)


def test_pairs_need_both_and_one_class_holds_one_effect():
    both = (named("x"), named("y"))
    rows = table(
        campaign("pair", ("x", "y"), cosine=-0.3, named=both),
        campaign("pair", ("x", "y"), cosine=0.1, named=(named("x", "y"),)),
        campaign("pair", ("x", "y"), cosine=-0.9, named=(named("z", "y"), named("x", "y"))),
        campaign("pair", ("x", "y"), cosine=0.9, named=(named("y", "x"), named("z", "x"))),
    )
    assert value(rows, "pair, |cos| < 0.8") == (0.5, 2)
    assert value(rows, "pair, |cos| >= 0.8") == (1.0, 2)


def test_what_the_library_has_not_must_be_unknown_or_a_look_alike():
    like = {"air": 0.97, "mass": 0.6}
    rows = table(
        campaign("outside", ("cavity",), verdict="unknown"),
        campaign("ablated", ("x",), imitations=like, named=(named("air"),)),
        campaign("ablated", ("x",), imitations=like, named=(named("mass"),)),
        campaign("outside", ("cavity",), imitations=like, named=(named("mass"),)),
        campaign("outside", ("cavity",), imitations=like),
    )
    assert value(rows, "outside or ablated: unknown, or") == (0.4, 5)
    assert value(rows, "outside: any name") == (pytest.approx(1 / 3), 3)


def test_parameters_are_held_against_the_truth():
    rows = table(
        campaign("single", ("x",), 40.0, named=(named("x", value=1.02, sigma=0.02),)),
        campaign("single", ("x",), 40.0, named=(named("x", value=0.90, sigma=0.02),)),
        campaign("single", ("x",), 20.0, named=(named("x", value=1.50, sigma=0.4),)),
    )
    assert value(rows, "parameter error from 30 sigma") == (pytest.approx(0.06), 2)
    assert value(rows, "true parameters within") == (pytest.approx(2 / 3), 3)


def test_closure_counts_where_the_truth_was_found():
    right = [campaign("single", ("x",), named=(named("x"),), closure=c) for c in (0.9, 0.96, 1.0)]
    rows = table(*right, campaign("single", ("x",), named=(named("y"),), closure=0.1))
    assert value(rows, "gap closed on held-out temperatures, median") == (pytest.approx(0.96), 3)


def test_a_lag_on_one_ramp_must_be_called_not_observable():
    seen = frozenset({"thermal_lag"})
    rows = table(campaign("null", one_ramp=True, not_observable=seen), campaign("null"))
    assert value(rows, "thermal lag") == (1.0, 1)
    assert table(campaign("null", one_ramp=True))["thermal lag not observable on one ramp"].met is False


def test_calibration_error_of_claims_that_come_true_half_as_often():
    stated, right = np.full(40, 0.9), np.arange(40) % 2 == 0
    assert reliability(stated, right, bins=4).error == pytest.approx(0.4)
    assert reliability(np.full(40, 0.5), right, bins=4).error == pytest.approx(0.0)


def test_claims_of_one_probability_share_a_bin_in_whatever_order_they_come():
    """Nineteen of twenty at 0.95 come true, all wrong ones among the first; bins of ten would each be off."""
    stated = np.concatenate([np.full(60, 0.95), [0.55, 0.6, 0.65, 0.7]])
    right = np.concatenate([np.arange(60) >= 3, [True, False, True, False]])
    found = reliability(stated, right)
    assert found.count[-1] == 60
    assert found.count.sum() == 64
    assert abs(found.stated[-1] - found.true[-1]) == pytest.approx(0.0)
    assert (np.diff(found.stated) > 0.0).all()


def test_distinct_probabilities_fill_bins_equally():
    found = reliability(np.linspace(0.1, 0.9, 50), np.ones(50, dtype=bool))
    assert found.count.min() >= 9
    assert len(found.count) == 5


def test_the_temperature_makes_claims_as_sure_as_they_are_true():
    """Three of four come true: nats of 4 over the temperature must leave odds of three."""
    against = {"nothing": -4.0}
    found = [
        campaign("single", ("x",), named=(Named("x" if k % 4 else "y", (), 1.0, against, {}),)) for k in range(100)
    ]
    best = likeliest_confidence(claims(found))
    assert best is not None
    odds = np.exp(4.0 / best["temperature"])
    assert (1.0 - best["unlisted"]) * odds / (1.0 + odds) == pytest.approx(0.75, rel=0.02)
    assert likeliest_confidence([]) is None


def test_names_of_all_evidence_that_are_wrong_are_unlisted_causes():
    """Nine of ten come true, none of them in doubt: no temperature tells which."""
    found = [
        campaign("single", ("x",), named=(Named("x" if k % 10 else "y", (), 1.0, {"nothing": -900.0}, {}),))
        for k in range(100)
    ]
    best = likeliest_confidence(claims(found))
    assert best is not None
    assert best["unlisted"] == pytest.approx(0.1, abs=0.01)


def test_a_look_alike_of_what_the_library_lacks_is_no_wrong_name():
    found = [campaign("ablated", ("x",), named=(named("y"),), imitations={"y": cosine}) for cosine in (0.97, 0.9)]
    assert [true for _, true in claims(found)] == [True, False]


def test_an_outcome_is_read_from_truth_and_verdict():
    truth = {
        "number": 3,
        "kind": "single",
        "effects": {"x": {"a": 1.0}},
        "prior_sigma": {"x": {"a": 1.0}},
        "size_sigma": {"x": 30.0},
        "cosine": None,
        "imitations": {},
        "legs": ["up"],
        "scatter": 0.0,
        "laws": {
            "temperature": [0.0, 20.0, 40.0, 60.0],
            "youngs_modulus": [3e9] * 4,
            "poisson_ratio": [0.4] * 4,
            "loss_factor": [0.05] * 4,
        },
    }
    effect = {"name": "x", "equivalent": ["y"], "probability": 0.9, "against": {"nothing": -9.0}}
    verdict = {
        "verdict": "unknown",
        "effects": [{**effect, "parameters": {"a": {"value": 1.1, "sigma": 0.1, "unit": "1"}}}],
        "gap": {"held_out": {"closure": 0.97}, "held_out_also": [{"closure": 0.92}, {"closure": None}]},
        "not_observable": ["thermal_lag"],
        "seconds": 4.0,
        "laws": {
            "final": {
                "temperature_c": [20.0],
                **{"youngs_modulus_pa": [3.1e9], "poisson_ratio": [0.4], "loss_factor": [0.05]},
                **{"sigma_youngs_modulus_pa": [1e8], "sigma_poisson_ratio": [0.1], "sigma_loss_factor": [0.1]},
            }
        },
    }
    assert outcome(truth, verdict).named == ()  # hints of an unknown gap claim nothing
    found = outcome(truth, {**verdict, "verdict": "partly_explained"})
    assert (found.right_names, found.one_ramp, found.closure) == (True, True, 0.97)
    assert found.named[0].parameters == {"a": (1.1, 0.1)}
    assert found.closure_also == (0.92,)
    rows = table(found)
    assert value(rows, "gap closed on a held-out channel or level") == (0.92, 1)
    assert outcome(truth, None).verdict == "refused"


def test_every_campaign_stands_once_in_picture_and_tables():
    outcomes = [
        campaign("null"),
        campaign("single", ("x",), named=(named("y"),)),
        campaign("single", ("x",), named=(named("x"), named("y"))),
        campaign("ablated", ("x",), verdict="unknown"),
        campaign("outside", ("cavity",), verdict="refused"),
        campaign("pair", ("x", "y"), cosine=0.2),
    ]
    rows, columns, counts = confusion(outcomes)
    assert counts.sum() == 5
    assert counts[rows.index("x"), columns.index("several")] == 1
    assert counts[rows.index("x, without it"), columns.index("unknown")] == 1
    assert len(proof_figure(outcomes).axes) == 3
    assert figures_table([figure.record() for figure in figures(outcomes)]).row_count == len(figures(outcomes))
    assert confusion_table([o.record() for o in outcomes]).row_count == 5


def test_a_share_of_few_campaigns_that_misses_is_told_from_one_of_many():
    few = figures_table([share("few", [campaign("single")] * 7, lambda o: True, 0.85, 0.95).record()])
    many = figures_table([share("many", [campaign("single")] * 200, lambda o: True, 0.85, 0.95).record()])
    assert list(few.columns[-1].cells) == ["missed, its interval reaches the target"]
    assert list(many.columns[-1].cells) == ["[bold red]missed[/]"]
