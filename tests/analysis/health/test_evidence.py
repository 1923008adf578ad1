"""Weeks added up: variance, limits and rates against closed forms and drawn numbers."""

import numpy as np
import pytest
from scipy.stats import norm

from analysis.health.baseline import checked
from analysis.health.evidence import (
    MISFIT_MARGIN,
    SHARE_OF_UNKNOWN,
    SPANS,
    limit,
    misfit_limit,
    span_estimate,
    spans,
)
from analysis.health.recording import DateEquations


def date(information: float, pull: float) -> DateEquations:
    return DateEquations(np.array([[information]]), np.array([pull]), 10.0, 10, 20.0, 0.1, np.zeros(1))


def test_dates_add_up_and_the_baselines_error_stays() -> None:
    found = span_estimate([date(4.0, 8.0), date(12.0, 8.0)], np.array([0.5]), np.ones(1))
    assert found.amplitude == pytest.approx([1.0])
    assert found.sigma**2 == pytest.approx([1.0 / 16.0 + 0.5])
    assert found.z == pytest.approx(found.amplitude / found.sigma)


def test_what_is_not_seen_gives_no_evidence() -> None:
    found = span_estimate([date(1e-9, 1.0)], np.zeros(1), np.ones(1))
    assert np.isinf(found.sigma[0])
    assert found.z[0] == 0.0


def test_the_limit_is_that_of_all_tests_together() -> None:
    sided = np.array([False, False, True])
    tests = len(SPANS) * 4
    assert limit(1e-3, sided) == pytest.approx(norm.isf((1.0 - SHARE_OF_UNKNOWN) * 1e-3 / tests))


def test_noise_alone_gives_fewer_alarms_than_stated() -> None:
    """A rate that is high enough to be counted; spans overlap, so that the bound is not reached."""
    rng, rate, candidates, weeks = np.random.default_rng(1), 0.05, 6, 4000
    bound = limit(rate, np.zeros(candidates, dtype=bool))
    information = rng.uniform(0.5, 2.0, (weeks, candidates))
    pulls = rng.standard_normal((weeks, candidates)) * np.sqrt(information)
    alarms = 0
    for week in range(16, weeks):
        z = [
            pulls[week - span + 1 : week + 1].sum(0) / np.sqrt(information[week - span + 1 : week + 1].sum(0))
            for span in spans(week)
        ]
        alarms += float(np.max(z)) > bound
    share = alarms / (weeks - 16)
    assert 0.002 < share < (1.0 - SHARE_OF_UNKNOWN) * rate * 1.3


def test_the_misfit_limit_is_a_quantile() -> None:
    rng = np.random.default_rng(2)
    drawn = 3.0 * rng.chisquare(200, 200_000) / 200
    assert (MISFIT_MARGIN * drawn > misfit_limit(0.02, 3.0, 200)).mean() == pytest.approx(
        SHARE_OF_UNKNOWN * 0.02, rel=0.1
    )


def test_the_self_check_finds_the_excess_of_the_errors() -> None:
    """Amplitudes that scatter with variance 1/A + v: v is found."""
    rng, excess = np.random.default_rng(3), 0.3
    information = np.full(40, 5.0)
    said = []
    for _ in range(60):
        amplitude = rng.normal(0.0, np.sqrt(1.0 / information + excess))
        pull = information * amplitude
        said.append(DateEquations(np.diag(information), pull, 100.0, 100, 20.0, 0.1, np.zeros(40)))
    found = checked(said, ["damage"] * 40)
    assert found.variance.mean() == pytest.approx(excess, rel=0.25)  # the largest of three estimates
    assert found.variance.min() > 0.25


def test_a_healthy_check_leaves_nothing() -> None:
    said = [DateEquations(np.eye(2), np.zeros(2), 90.0, 100, 20.0, 0.1, np.zeros(2)) for _ in range(5)]
    found = checked(said, ["mass", "damage"])
    assert found.variance == pytest.approx([0.0, 0.0])
    assert (found.misfit, found.usual) == (0.9, 0.9)
