"""The linearised misfit of one sweep, compared with the misfit itself."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.updating.normal_equations import (
    LONGEST,
    NormalEquations,
    SweepData,
    best_gain,
    moved,
    normal_equations,
)

TRUTH, GAIN = np.array([2.1e9, 0.38, 0.06]), 14.3
OFF = np.array([4e-3, -2e-3, 0.02, 0.01])
"""Step of log E, nu, log eta and log gain away from the truth."""


def data_of(twin, noise: float, stated: float = 1.0) -> SweepData:
    """Return a sweep of the twin; its variance stated too small by a factor `stated`."""
    frf = twin.measured(np.array([20.0]), [TRUTH], GAIN, np.random.default_rng(4), max(noise, 0.01))
    data = SweepData.of(frf, 0, 4)
    h = data.h if noise else GAIN * data.answer(twin, TRUTH)
    return SweepData(data.frequency, h, stated * data.weight, data.temperature, data.source)


def equations_at(twin, data: SweepData) -> Callable[[np.ndarray], NormalEquations]:
    """Equations at a step away from the truth."""
    return lambda step: normal_equations(twin, data, moved(TRUTH, step[:3]), GAIN * float(np.exp(step[3])))


def test_the_gradient_is_that_of_chi2(twin) -> None:
    at = equations_at(twin, data_of(twin, 0.01))
    slopes = [(at(OFF + step).chi2 - at(OFF - step).chi2) / 2e-6 for step in 1e-6 * np.eye(4)]
    np.testing.assert_allclose(at(OFF).gradient, -0.5 * np.array(slopes), rtol=1e-5)


def test_without_noise_chi2_is_the_quadratic_form_of_the_matrix(twin) -> None:
    at, step = equations_at(twin, data_of(twin, 0.0)), 1e-3 * OFF
    there = at(np.zeros(4))
    assert at(step).chi2 == pytest.approx(step @ there.matrix @ step, rel=1e-3)
    assert at(step).decrease == pytest.approx(at(step).chi2, rel=1e-3)
    np.testing.assert_allclose(at(step).full_step, -step, rtol=1e-2)
    np.testing.assert_allclose(at(step).ahead, TRUTH, rtol=1e-6)


def test_a_known_step_of_the_gain_leaves_the_others_at_their_best(twin) -> None:
    """Given log gain, the quadratic model is lowest where its gradient by the other three vanishes."""
    found = equations_at(twin, data_of(twin, 0.01))(1e-2 * OFF)
    for gain_step in (0.0, 0.01):
        step = np.append(found.following(gain_step), gain_step)
        np.testing.assert_allclose((found.gradient - found.matrix @ step)[:3] / found.gradient[:3], 0.0, atol=1e-8)
    np.testing.assert_allclose(found.following(float(found.full_step[3])), found.full_step[:3], rtol=1e-8)


def test_chi2_of_white_noise_is_its_degrees_of_freedom_and_a_model_error_raises_the_variance(twin) -> None:
    data = data_of(twin, 0.01)
    assert data.h.shape == (1, 350)
    found = equations_at(twin, data)(np.zeros(4))
    assert found.dof == 2 * 350 - 4
    assert found.chi2 == pytest.approx(found.dof, abs=5.0 * np.sqrt(2 * found.dof))
    left = found.chi2 - found.decrease
    assert 0.0 < found.decrease < 30.0  # of four parameters fitted to noise
    assert found.excess == max(left / found.dof, 1.0)
    too_sure = equations_at(twin, data_of(twin, 0.01, stated=9.0))(np.zeros(4))
    assert too_sure.excess == pytest.approx(9.0 * left / found.dof, rel=1e-9)


def test_the_misfit_is_unweighted_and_falls_with_the_weighted_residual(twin) -> None:
    data = data_of(twin, 0.01)
    found = equations_at(twin, data)(OFF)
    model = GAIN * np.exp(OFF[3]) * data.answer(twin, moved(TRUTH, OFF[:3]))
    assert found.misfit == pytest.approx(np.linalg.norm(data.h - model) / np.linalg.norm(data.h), rel=1e-12)
    assert found.misfit_ahead == pytest.approx(
        found.misfit * np.sqrt(1.0 - found.decrease / found.chi2), rel=1e-12
    )
    reached = normal_equations(twin, data, found.ahead, found.gain * float(np.exp(found.full_step[3])))
    assert found.misfit_ahead == pytest.approx(reached.misfit, rel=0.05)


def test_widths_are_steps_over_the_half_width_of_a_resonance(twin) -> None:
    """A resonance at f has half-power half-width eta f / 2, and moves by f / 2 per unit of log E."""
    at = equations_at(twin, data_of(twin, 0.0))
    assert at(np.array([1e-4, 0.0, 0.0, 0.0])).widths == pytest.approx(1e-4 / TRUTH[2], rel=0.05)
    assert at(np.array([0.0, 1e-4, 0.0, 0.0])).widths == pytest.approx(1e-4 / TRUTH[2], rel=0.05)
    assert at(np.array([0.0, 0.0, 1e-4, 0.0])).widths == pytest.approx(1e-4, rel=0.05)
    assert at(np.array([0.0, 0.0, 0.0, 1e-4])).widths == pytest.approx(1e-4, rel=0.05)
    far = at(np.array([2e-3, 0.0, 0.0, 0.0]))
    assert far.remainder == pytest.approx(far.decrease * far.widths**2, rel=1e-12)


def test_damping_shortens_the_step_and_no_step_is_longer_than_the_linearisation_holds(twin) -> None:
    found = equations_at(twin, data_of(twin, 0.0))(np.array([1e-4, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(
        found.step(1e6), found.gradient / np.diag(found.matrix) / 1e6, rtol=1e-4
    )  # steepest descent, scaled by the diagonal
    one = np.eye(4)
    far = NormalEquations(TRUTH, GAIN, 1.0, 10, 1.0, one, 3.0 * one[0] - 3.0 * one[2])
    np.testing.assert_array_equal(far.full_step, [LONGEST, 0.0, -LONGEST, 0.0])
    np.testing.assert_array_equal(far.following(0.0), [LONGEST, 0.0, -LONGEST])


def test_the_best_gain_is_where_chi2_is_lowest_and_stays_positive(twin) -> None:
    data = data_of(twin, 0.01)
    transfer = data.answer(twin, TRUTH)
    gain, chi2 = best_gain(transfer, data)
    assert chi2 == pytest.approx(2.0 * float((data.weight * np.abs(data.h - gain * transfer) ** 2).sum()))
    for other in (0.999 * gain, 1.001 * gain):
        assert normal_equations(twin, data, TRUTH, other).chi2 > chi2
    assert gain == pytest.approx(GAIN, rel=3e-3)
    assert best_gain(-transfer, data)[0] == pytest.approx(0.05 * GAIN, rel=1e-2)  # out of phase


def test_lines_left_out_take_no_part(twin) -> None:
    frf = twin.measured(np.array([20.0, 30.0]), [TRUTH, TRUTH], GAIN, np.random.default_rng(4), 0.01)
    frf.excluded[:7] = True
    data = SweepData.of(frf, 1, 3)
    np.testing.assert_array_equal(data.frequency, frf.frequency[7::3])
    np.testing.assert_array_equal(data.h, frf.h[1][:, 7::3])
    np.testing.assert_array_equal(data.weight, 1.0 / frf.variance[1][:, 7::3])
    assert data.point.temperature == data.temperature == 30.0
    assert (data.point.rate, data.point.level, data.point.source) == (0.0, 1.0, 0)
