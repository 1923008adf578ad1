"""Eliminating laws and readings is solving the whole."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.fitting.normal_equations import GLOBAL, linearise_all
from analysis.gap.fitting.schur_complement import schur_complement

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
    # all sweeps of a group at one temperature: there errors of the slopes are the same about any of them
    readings = np.array([point.temperature for point in sweeps.points])
    state = replace(state, away=sweeps.groups.reference[sweeps.groups.of_sweep] - readings)
    tangents = [("mass", "grams", {"grams": 0.0}), ("lag", "tau", {"tau": 0.0})]
    return sweeps, state, linearise_all(toy.Plate(), sweeps, state, tangents, pool)


def whole(sweeps, state, equations):
    """Dense normal equations: laws with their derivatives and errors of all readings, then gain and effects."""
    groups, count = len(sweeps.groups.reference), sweeps.count
    common = len(equations[0].gradient) - GLOBAL
    size = 9 * groups + count + common
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    for s, e in enumerate(equations):
        group = sweeps.groups.of_sweep[s]
        places = [*range(9 * group, 9 * group + 9), 9 * groups + s, *range(9 * groups + count, size)]
        matrix[np.ix_(places, places)] += e.matrix
        gradient[places] += e.gradient
    gradient[9 * groups : 9 * groups + count] -= state.away / sweeps.reading_sigma**2
    rows = np.arange(9 * groups).reshape(groups, 3, 3)
    for law in range(3):
        # errors of the derivatives: what they are beyond what the values say
        root, by_values = sweeps.smoothness.root[law], sweeps.smoothness.by_values[law]
        places = [*rows[:, 0, law], *rows[:, 1, law], *rows[:, 2, law]]
        scale = np.sqrt((root**2).sum(1))
        beyond = np.hstack([-by_values, np.eye(2 * groups)]) / scale[:, None]
        spread = root @ root.T / np.outer(scale, scale) + 1e-10 * np.eye(2 * groups)
        matrix[np.ix_(places, places)] += beyond.T @ np.linalg.solve(spread, beyond)
    readings = np.arange(9 * groups, 9 * groups + count)
    matrix[readings, readings] += sweeps.reading_sigma**-2
    # a shift common to a group's readings is another law: hold it
    for g in range(groups):
        members = 9 * groups + np.flatnonzero(sweeps.groups.of_sweep == g)
        matrix[np.ix_(members, members)] += 1e14
    return matrix, gradient


def test_elimination_equals_the_dense_solution(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    step = np.linalg.solve(head.matrix, head.gradient)
    local = head.parts(head.follow(step))
    matrix, gradient = whole(sweeps, state, equations)
    scale = 1.0 / np.sqrt(np.diag(matrix))
    dense = scale * np.linalg.solve(matrix * scale[:, None] * scale, scale * gradient)
    groups = len(sweeps.groups.reference)
    assert step == pytest.approx(dense[-len(step) :], rel=1e-3)
    own = dense[: 9 * groups].reshape(groups, 3, 3)
    assert local.laws == pytest.approx(own[:, 0], rel=1e-3, abs=1e-8)
    derivatives = sweeps.smoothness.derivatives(local.laws), sweeps.smoothness.deviations(local.errors)
    slope, curvature = map(np.add, *derivatives)
    assert slope == pytest.approx(own[:, 1], rel=1e-2, abs=1e-6)
    assert curvature == pytest.approx(own[:, 2], rel=1e-2, abs=1e-6)
    assert local.away == pytest.approx(dense[9 * groups : -len(step)], rel=1e-3, abs=1e-7)
    assert head.predicted_decrease + head.gradient @ step == pytest.approx(gradient @ dense, rel=1e-6)


def test_variances_of_laws_are_those_of_the_whole(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    matrix, _ = whole(sweeps, state, equations)
    scale = 1.0 / np.sqrt(np.diag(matrix))
    covariance = scale[:, None] * np.linalg.inv(matrix * scale[:, None] * scale) * scale
    groups = len(sweeps.groups.reference)
    laws = [9 * group + law for group in range(groups) for law in range(3)]
    sigma = np.sqrt(np.diag(covariance)[laws]).reshape(groups, 3)
    assert head.law_sigma(np.linalg.inv(head.matrix)) == pytest.approx(sigma, rel=1e-2)


def test_readings_of_a_group_move_against_each_other_only(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state)
    away = head.parts(head.follow(np.zeros(len(head.gradient)))).away
    assert np.abs(away).max() > 0.0
    assert np.bincount(sweeps.groups.of_sweep, away) == pytest.approx(0.0, abs=1e-12)


def test_frozen_laws_stay(problem):
    sweeps, state, equations = problem
    head = schur_complement(sweeps, equations, state, frozen=True)
    local = head.parts(head.follow(np.ones(len(head.gradient))))
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
