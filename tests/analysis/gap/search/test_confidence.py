"""A name is as sure as its rivals are far."""

import pytest

from analysis.gap.search.confidence import against, equivalents, probability


def test_near_rivals_and_look_alikes_make_a_class():
    rivals = {"near": -2.0, "far": -50.0, "twin": -40.0}
    assert equivalents(rivals, {"twin": 0.97, "far": 0.5}) == ("near", "twin")


def stated(gain, rivals, alike, unknown, chi2_per_dof, unlisted=0.0, **settings):
    return probability(against(gain, rivals, unknown, chi2_per_dof), alike, unlisted=unlisted, **settings)


def test_a_clear_winner_is_sure_and_a_tie_is_not():
    assert stated(500.0, {"other": -300.0}, (), 20.0, 1.0) > 0.999
    assert stated(500.0, {"other": 0.0}, (), 20.0, 1.0) == pytest.approx(0.5, abs=1e-3)
    assert stated(500.0, {"other": 0.0}, ("other",), 20.0, 1.0) > 0.999


def test_what_an_unknown_explains_better_is_no_name():
    assert stated(500.0, {}, (), 900.0, 1.0) < 0.001


def test_a_residual_takes_confidence_away():
    sure = stated(60.0, {"other": -12.0}, (), 0.0, 1.0)
    assert stated(60.0, {"other": -12.0}, (), 0.0, 30.0) < sure - 0.1


def test_no_evidence_speaks_against_a_cause_that_is_in_no_library():
    assert stated(5000.0, {}, (), 0.0, 1.0, unlisted=0.04) == pytest.approx(0.96, abs=1e-6)


def test_a_higher_temperature_is_less_sure():
    assert stated(20.0, {}, (), 0.0, 1.0, temperature=10.0) < stated(20.0, {}, (), 0.0, 1.0, temperature=2.0)


def test_what_stands_against_an_effect_is_relative_to_it():
    assert against(60.0, {"other": -12.0}, 40.0, 2.0) == {"nothing": -30.0, "unknown": -10.0, "other": -6.0}
