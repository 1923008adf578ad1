"""Eliminating group by group is solving the whole."""

import numpy as np
import pytest

from analysis.gap.fitting.normal_equations import GLOBAL, TEMPERATURE, linearise_all
from analysis.gap.fitting.schur_complement import OWN, schur_complement

DENSE = tuple(np.arange(0.0, 13.0, 2.0))


@pytest.fixture(
    scope="module",
    params=[((10.0, 26.0), (0,)), (DENSE, (0,)), ((10.0, 26.0), (0, 1))],
    ids=["sparse", "dense", "two inputs"],
)
def problem(request, toy, pool):
    temperatures, sources = request.param
    sweeps, _ = toy.prepared(temperatures=temperatures, sources=sources, effects={"mass": {"grams": 0.5}})
    state = toy.start(sweeps.groups, inputs=len(sources))
    tangents = [("mass", "grams", {"grams": 0.0}), ("lag", "tau", {"tau": 0.0})]
    return sweeps, state, linearise_all(toy.Plate(), sweeps, state, tangents, pool)


def whole(sweeps, equations):
    """Dense normal equations: laws, slopes and errors of all readings, then gain and effects."""
    groups, count = len(sweeps.groups.reference), sweeps.count
    common = len(equations[0].gradient) - GLOBAL
    size = OWN * groups + count + common
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    for s, e in enumerate(equations):
        group = sweeps.groups.of_sweep[s]
        places = [*range(OWN * group, OWN * group + OWN), OWN * groups + s, *range(OWN * groups + count, size)]
        columns = [*range(TEMPERATURE), TEMPERATURE, *range(GLOBAL, GLOBAL + common)]
        matrix[np.ix_(places, places)] += e.matrix[np.ix_(columns, columns)]
        gradient[places] += e.gradient[columns]
    slopes = [OWN * g + 3 + i for g in range(groups) for i in range(3)]
    matrix[slopes, slopes] += 1.0
    readings = np.arange(OWN * groups, OWN * groups + count)
    matrix[readings, readings] += sweeps.reading_sigma**-2
    # a shift common to a group's readings is another law: hold it
    for g in range(groups):
        members = OWN * groups + np.flatnonzero(sweeps.groups.of_sweep == g)
        matrix[np.ix_(members, members)] += 1e14
    return matrix, gradient


def test_elimination_equals_the_dense_solution(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    step = np.linalg.solve(head.matrix, head.gradient)
    local = head.follow(step, sweeps.count)
    matrix, gradient = whole(sweeps, equations)
    scale = 1.0 / np.sqrt(np.diag(matrix))
    dense = scale * np.linalg.solve(matrix * scale[:, None] * scale, scale * gradient)
    groups = len(sweeps.groups.reference)
    assert step == pytest.approx(dense[-len(step) :], rel=1e-4)
    own = dense[: OWN * groups].reshape(groups, OWN)
    assert local.laws == pytest.approx(own[:, :3], rel=1e-4, abs=1e-9)
    assert local.tilt == pytest.approx(own[:, 3:], rel=1e-3, abs=1e-6)
    assert local.away == pytest.approx(dense[OWN * groups : -len(step)], rel=1e-4, abs=1e-8)
    assert head.predicted_decrease + head.gradient @ step == pytest.approx(gradient @ dense, rel=1e-6)


def test_variances_of_laws_are_those_of_the_whole(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    matrix, _ = whole(sweeps, equations)
    scale = 1.0 / np.sqrt(np.diag(matrix))
    covariance = scale[:, None] * np.linalg.inv(matrix * scale[:, None] * scale) * scale
    groups = len(sweeps.groups.reference)
    laws = [OWN * group + law for group in range(groups) for law in range(3)]
    sigma = np.sqrt(np.diag(covariance)[laws]).reshape(groups, 3)
    assert head.law_sigma(np.linalg.inv(head.matrix)) == pytest.approx(sigma, rel=1e-3)


def test_readings_of_a_group_move_against_each_other_only(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    away = head.follow(np.zeros(len(head.gradient)), sweeps.count).away
    assert np.abs(away).max() > 0.0
    assert np.bincount(sweeps.groups.of_sweep, away) == pytest.approx(0.0, abs=1e-12)


def test_frozen_laws_stay(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state, frozen=True)
    local = head.follow(np.ones(len(head.gradient)), sweeps.count)
    assert not local.laws.any()
    assert not local.away.any()
    assert head.matrix == pytest.approx(head.raw)


def test_known_temperatures_leave_a_lag_more_to_say(problem):
    sweeps, state, equations = problem
    unread, read = (
        schur_complement(sweeps, equations, state),
        schur_complement(sweeps, equations, state, readings=False),
    )
    assert read.matrix[-1, -1] > 100.0 * unread.matrix[-1, -1]
    assert read.matrix[-1, -1] < 1.0001 * read.raw[-1, -1]


def test_eliminating_the_gains_too_is_solving_the_whole(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    left = head.without_gains()
    step = np.linalg.solve(head.matrix, head.gradient)
    assert np.linalg.solve(left.matrix, left.gradient) == pytest.approx(step[head.gains :], rel=1e-6)
    gains = left.covariance @ head.gradient[: head.gains] - left.lever @ step[head.gains :]
    assert gains == pytest.approx(step[: head.gains], rel=1e-6)
    covariance = np.linalg.inv(head.matrix)
    assert np.linalg.inv(left.matrix) == pytest.approx(covariance[head.gains :, head.gains :], rel=1e-6)
