import numpy as np
import pytest

from analysis.geometry.loop import Arc, Cubic, Curve, Segment, moved, turning

CURVES: list[Curve] = [
    Segment((0.1, 0.2), (0.4, -0.1)),
    Arc((0.1, 0.0), (0.3, 0.1), 0.4, 0.2, -2.5),
    Cubic(((0.0, 0.0), (0.1, 0.3), (0.4, -0.2), (0.3, 0.1))),
]
kinds = pytest.mark.parametrize("curve", CURVES, ids=["segment", "arc", "cubic"])


@kinds
def test_the_derivative_is_that_of_the_points(curve: Curve) -> None:
    t, step = np.linspace(0.1, 0.9, 7), 1e-5
    difference = (curve.at(t + step) - curve.at(t - step)) / (2.0 * step)
    np.testing.assert_allclose(curve.derivative(t), difference, atol=1e-8)


@kinds
def test_a_part_runs_along_the_whole_and_backwards_where_it_is_asked(curve: Curve) -> None:
    t = np.linspace(0.0, 1.0, 9)
    np.testing.assert_allclose(curve.part(0.3, 0.8).at(t), curve.at(0.3 + 0.5 * t), atol=1e-15)
    np.testing.assert_allclose(curve.part(1.0, 0.0).at(t), curve.at(1.0 - t), atol=1e-15)


@kinds
def test_moving_turns_enlarges_and_shifts_every_point(curve: Curve) -> None:
    t = np.linspace(0.0, 1.0, 9)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    wanted = 2.0 * curve.at(t) @ turn.T + (0.5, -0.25)
    np.testing.assert_allclose(moved(curve, 0.7, (0.5, -0.25), 2.0).at(t), wanted, atol=1e-15)


def test_turning() -> None:
    assert turning(CURVES[0]) == 0.0
    assert turning(Arc((0.0, 0.0), (0.2, 0.2), 0.3, 0.0, -1.5)) == pytest.approx(1.5)
    there_and_back = Cubic(((0.0, 0.0), (1.0, 1.0), (2.0, -1.0), (3.0, 0.0)))
    assert turning(there_and_back) == pytest.approx(2.0 * (np.pi / 4.0 + np.arctan(0.5)), rel=0.02)
