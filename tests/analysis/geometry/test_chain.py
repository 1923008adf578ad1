import numpy as np
import pytest

from analysis.geometry.loop import Arc, Cubic, Curve, GeometryError, Segment, closed_loops

SLOT: list[Curve] = [
    Segment((0.1, 0.05), (0.0, 0.05)),
    Arc((0.1, 0.0), (0.05, 0.05), 0.0, -0.5 * np.pi, np.pi),
    Segment((0.0, -0.05), (0.1, -0.05)),
    Arc((0.0, 0.0), (0.05, 0.05), 0.0, -0.5 * np.pi, -np.pi),
]


def test_curves_in_any_order_and_direction_make_one_loop() -> None:
    rng = np.random.default_rng(0)
    for _ in range(5):
        order = rng.permutation(4)
        mixed = [SLOT[k] if rng.random() < 0.5 else SLOT[k].part(1.0, 0.0) for k in order]
        (loop,) = closed_loops(mixed, 1e-6)
        assert loop.area == pytest.approx(0.01 + np.pi * 0.05**2, rel=1e-12)
        assert len(loop.curves) == 4


def test_small_gaps_are_closed_and_larger_ones_refused_with_the_place() -> None:
    shifted = [Segment((0.100004, 0.05), (-0.000003, 0.050002)), *SLOT[1:]]
    (loop,) = closed_loops(shifted, 1e-5)
    assert loop.area == pytest.approx(0.01 + np.pi * 0.05**2, rel=2e-4)
    with pytest.raises(GeometryError, match=r"open outline: nothing goes on at .*tolerance") as caught:
        closed_loops(shifted, 1e-6)
    ((x, y),) = caught.value.places
    assert min(abs(x), abs(x - 0.1)) < 1e-5
    assert y == pytest.approx(0.05, abs=1e-5)


def test_the_largest_loop_comes_first_and_what_comes_back_closes_by_itself() -> None:
    drop = Cubic(((0.02, 0.0), (0.06, 0.03), (-0.02, 0.03), (0.02, 0.0)))
    ring = Arc((0.08, 0.0), (0.01, 0.01), 0.0, 0.0, 2.0 * np.pi)
    dot = Segment((0.05, 0.0), (0.05, 1e-7))
    outer, *inner = closed_loops([drop, dot, *SLOT, ring], 1e-6)
    assert outer.area == pytest.approx(0.01 + np.pi * 0.05**2)
    areas = sorted(loop.area for loop in inner)
    assert areas == pytest.approx(sorted([np.pi * 1e-4, 0.6 * 0.04 * 0.03 * 0.5 * 0.75]), rel=0.3)
    assert areas == sorted(areas)
    assert np.pi * 1e-4 == pytest.approx(min(areas, key=lambda area: abs(area - np.pi * 1e-4)), rel=1e-12)


def test_three_ends_in_one_place_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"3 curves meet at \(0, 0\.05\) m"):
        closed_loops([*SLOT, Segment((0.0, 0.05), (0.0, 0.2))], 1e-6)


def test_no_curve_makes_no_loop() -> None:
    assert closed_loops([], 1e-6) == ()
