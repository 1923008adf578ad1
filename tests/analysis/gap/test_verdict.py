"""Which verdict follows from what a search leaves, rule by rule."""

from types import SimpleNamespace
from typing import Any

import pytest

from analysis.gap.gap import judge
from analysis.gap.imperfect.naming import Surety, doubted
from analysis.gap.search.held_out import HeldOut

GAP, NOISE = 1000.0, 10.0
"""Excess chi2 of the plain twin, and up to which a twin agrees with the data."""
OF_NOISE = 6.0
"""Evidence for a nameless discrepancy that noise alone stays below, nats."""


def fit(excess: float, evidence: float) -> Any:
    return SimpleNamespace(total=excess, log_evidence=evidence, residual=None, state=None)


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch):
    """Judge effects that leave an excess, and a nameless discrepancy behind the rest, nats."""

    def answer(
        effects: int,
        left: float,
        *,
        gap: float = GAP,
        holds: bool = True,
        rest: float = 0.0,
        allowed: float = 0.0,
    ) -> str:
        before, after = fit(gap, 0.0), fit(left, 0.5 * (gap - left))
        monkeypatch.setattr(
            "analysis.gap.gap.unknown_evidence",
            lambda sweeps, residual, state: rest if residual == "rest" else 0.0,
        )
        monkeypatch.setattr("analysis.gap.gap.noise_evidence", lambda sweeps: OF_NOISE)
        after.residual = "rest"
        bench: Any = SimpleNamespace(
            sweeps=SimpleNamespace(),
            allowed=lambda f: allowed,
            overstated=lambda f: 2.0,
            excess=lambda f: f.total,
            agrees=lambda f: f.total <= NOISE,
        )
        found: Any = SimpleNamespace(
            baseline=before, fit=after if effects else before, effects=tuple("abc"[:effects])
        )
        tried = HeldOut("every second temperature", 2.0, 1.0 if holds else 3.0, 1.0, 0.1, 0.01, 1.0, 0.0)
        return judge(bench, found, tried if effects else None).verdict

    return answer


def test_without_effects_it_is_none_or_unknown(judged):
    assert judged(0, 0.0, gap=NOISE) == "none"
    assert judged(0, 0.0) == "unknown"


def test_names_that_leave_noise_explain(judged):
    assert judged(1, 5.0) == judged(3, 5.0) == "explained"


def test_what_does_not_hold_on_other_data_is_not_claimed(judged):
    assert judged(1, 5.0, holds=False) == "unknown"
    assert judged(1, 5.0, gap=NOISE, holds=False) == "none"


def test_beside_noise_alone_nothing_may_be_left(judged):
    assert judged(1, 50.0) == judged(2, 50.0) == "unknown"


def test_a_rest_with_a_shape_is_not_noise_however_small(judged):
    at_the_limit = 2.0 * OF_NOISE
    assert judged(2, 5.0, rest=0.9 * at_the_limit) == "explained"
    assert judged(2, 5.0, rest=at_the_limit) == "unknown"
    assert judged(1, 5.0, rest=at_the_limit) == "unknown"


def test_the_twins_own_error_may_have_any_shape(judged):
    assert judged(1, 5.0, rest=100.0, allowed=4.0) == "unknown"
    assert judged(1, 5.0, rest=100.0, allowed=6.0) == "explained"


def test_an_effect_that_may_be_nothing_or_unknown_is_a_hint_and_no_name():
    """Two springs in place of a soft foundation that the library lacked brought a twin down to the noise."""
    sure = Surety(20.0, {"nothing": -20.0, "unknown": -12.0, "damage": -1.0}, (), 0.57)
    unsure, less = (Surety(6.6, {"nothing": -6.6, "unknown": other}, (), 0.7) for other in (-4.0, -3.0))
    assert doubted({"mass": sure}) == doubted({}) == ""
    assert "below 0.8 (spring 0.75, second 0.69)" in doubted({"second": less, "mass": sure, "spring": unsure})
