"""Normal equations of a sweep: some channels at a time, and a step along a curve."""

import numpy as np
import pytest

from analysis.gap.fitting import normal_equations
from analysis.gap.fitting.linearised_sweeps import LinearisedSweeps
from analysis.gap.fitting.normal_equations import WhitenedSweep, channel_blocks, linearise_all, whiten_all

TANGENTS = [("mass", "grams", {"grams": 0.0}), ("lag", "tau", {"tau": 0.0})]


@pytest.mark.parametrize("block", [1, 3_000, 10**9])
def test_channels_in_turn_are_each_taken_once(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(normal_equations, "BLOCK", block)
    parts = list(channel_blocks(12, 7, 100))
    assert [k for part in parts for k in range(7)[part]] == list(range(7))
    assert len(parts) == {1: 7, 3_000: 4, 10**9: 1}[block]


@pytest.fixture(scope="module")
def problem(toy):
    sweeps, _ = toy.prepared(temperatures=(10.0, 26.0), effects={"mass": {"grams": 0.5}})
    return toy.Plate(), sweeps, toy.start(sweeps.groups)


def test_in_blocks_they_are_those_of_all_channels(problem, pool, monkeypatch: pytest.MonkeyPatch) -> None:
    model, sweeps, state = problem
    assert len(sweeps.channels) > 1
    weights = np.random.default_rng(0).random(sweeps.rows.shape) > 0.3
    sweeps = sweeps.masked(weights)
    whole = linearise_all(model, sweeps, state, TANGENTS, pool)
    white = whiten_all(model, sweeps, state, TANGENTS, pool)
    linear = LinearisedSweeps.of(model, sweeps, state, pool)
    from_linear = linear.equations(sweeps, state, TANGENTS)
    monkeypatch.setattr(normal_equations, "BLOCK", 1)
    for wanted, found in (
        (whole, linearise_all(model, sweeps, state, TANGENTS, pool)),
        (from_linear, linear.equations(sweeps, state, TANGENTS)),
        (white, whiten_all(model, sweeps, state, TANGENTS, pool)),
    ):
        for one, other in zip(wanted, found, strict=True):
            for name in set(vars(one)) - {"columns"}:
                size = np.abs(getattr(one, name)).max()
                np.testing.assert_allclose(getattr(other, name), getattr(one, name), atol=1e-12 * size)


def test_a_step_of_collinear_unknowns_is_taken_along_its_curve():
    """The model is H exp(a) / (1 + b): only the sum of logarithms is told, and a little more by a second line.

    A Gauss-Newton step along a = b is far too long for first order; the residual at its end tells the curve.
    """
    lines = np.linspace(0.0, 1.0, 40)[None]
    response, little = 1000.0 * np.exp(1j * lines), 1.0 + 0.02 * lines

    def model(a, b):
        return response * np.exp(a) / (1.0 + b * little)

    def at(a, b):
        here = model(a, b)
        columns = np.array([here, -here * little / (1.0 + b * little), model(0.25, 0.28) - here])
        return WhitenedSweep(columns, here).equations(keep=True)

    begun = at(0.0, 0.0)
    step = np.linalg.solve(begun.matrix, begun.gradient)
    ended = at(*step)
    assert ended.chi2 > 0.5 * begun.chi2
    bent = begun.bent(step, ended.residual)
    assert at(*np.linalg.solve(bent.matrix, bent.gradient)).chi2 < 0.1 * ended.chi2


def test_known_derivatives_do_not_tell_apart_what_acts_alike():
    """Modulus and thickness act as E h^3, alike at every state, whose derivatives change by 4 % between two.

    Joined as they stood, the thickness seemed to be told apart by these 4 %: with thousands of lines, E had a
    standard deviation fourteen times too small.
    """
    lines = np.linspace(0.5, 1.5, 200)[None]

    def at(stiffness, *, thickness):
        response = 100.0 / (1.0 - lines**2 / stiffness + 0.05j)
        modulus = -(response**2) / 100.0 * lines**2 / stiffness
        loss = -(response**2) / 100.0 * 0.05j
        laws = [modulus, lines * modulus, loss, *np.zeros((7, *lines.shape))]
        columns = np.array([*laws, response, *([3.0 * modulus] if thickness else []), 0.1 * response])
        return WhitenedSweep(columns, response).equations(keep=True)

    def told(equations):
        """Share of the thickness's own information that laws and gain leave."""
        used = [0, 1, 2, 10]
        lever = np.linalg.solve(equations.matrix[np.ix_(used, used)], equations.matrix[used, -1])
        return 1.0 - equations.matrix[used, -1] @ lever / equations.matrix[-1, -1]

    known, now = at(1.0, thickness=True), at(1.001, thickness=False)
    assert 0.02 < now.changed_from(known) < 0.06
    joined, anew = now.with_last(known, 1, shared=11), at(1.001, thickness=True)
    np.testing.assert_allclose(joined.matrix, anew.matrix, rtol=1e-6, atol=1e-6 * anew.matrix.max())
    assert told(joined) < 1e-9
