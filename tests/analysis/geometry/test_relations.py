import numpy as np
import pytest

from analysis.geometry import loop
from analysis.geometry.loop import Arc, Loop, Segment
from analysis.geometry.relations import crossing, gap, leaves, overlap, self_crossing

SQUARE = loop.rectangle((0.0, 0.0), (0.2, 0.2))


def test_a_bow_tie_crosses_itself_where_its_diagonals_meet() -> None:
    place = self_crossing(loop.polygon([(0.0, 0.0), (0.4, 0.2), (0.4, 0.0), (0.0, 0.1)]))
    assert place == pytest.approx((0.4 / 3.0, 0.2 / 3.0))


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (0.2, 0), (0.1, 0.1), (0.2, 0.2), (0, 0.2), (0.1, 0.1)],  # two triangles that share a point
        [(0, 0), (0.2, 0), (0.2, 0.2), (0.1, 0.0), (0, 0.2)],  # a corner on another side
        [(0, 0), (0.2, 0), (0.3, 0), (0.2, 0), (0.2, 0.2), (0, 0.2)],  # there and back
    ],
)
def test_a_loop_that_touches_itself_is_found(points: list[tuple[float, float]]) -> None:
    assert self_crossing(loop.polygon(points)) is not None


@pytest.mark.parametrize(
    "loop",
    [SQUARE, loop.circle((0, 0), 0.1), loop.ellipse((0, 0), (0.5, 0.01)), loop.circle((0, 0), 0.0005)],
)
def test_a_simple_loop_does_not_cross_itself(loop: Loop) -> None:
    assert self_crossing(loop) is None


def test_loops_that_touch_do_not_overlap() -> None:
    beside = loop.rectangle((0.2, 0.05), (0.2, 0.2))
    assert overlap(SQUARE, beside) is None
    assert crossing(SQUARE, beside) is None
    assert overlap(SQUARE, loop.circle((0.15, 0.0), 0.05)) is None


def test_equal_crossing_and_nested_loops_overlap() -> None:
    cross = loop.rectangle((0.0, 0.0), (0.5, 0.05), 0.3)
    for other in (SQUARE, cross, loop.circle((0.0, 0.0), 0.02), loop.rectangle((0.1, 0.0), (0.2, 0.2))):
        place = overlap(SQUARE, other)
        assert place is not None
        assert SQUARE.contains(place[None], within=2e-6)[0]
        assert other.contains(place[None], within=2e-6)[0]


@pytest.mark.parametrize(("start", "sweep"), [(0.3, 2.2), (-1.0, 4.0), (0.0, np.pi)])
def test_a_part_of_a_disc_touches_its_edge_and_the_rest(start: float, sweep: float) -> None:
    """Its arc is cut into other chords than the disc's: these cross, and reach beyond each other by 1e-5 m."""
    disc = loop.ellipse((0.0, 0.0), (0.2, 0.1), 0.4)
    arc, rest = (
        Arc((0.0, 0.0), (0.2, 0.1), 0.4, *span) for span in ((start, sweep), (start, sweep - 2.0 * np.pi))
    )
    part = Loop((arc, Segment(tuple(arc.at(1.0)), tuple(arc.at(0.0)))))
    left = Loop((rest, Segment(tuple(rest.at(1.0)), tuple(rest.at(0.0)))))
    ring = loop.rectangle((0.0, 0.0), (1.0, 1.0))
    assert leaves(part, disc) is None
    assert leaves(left, disc) is None
    assert overlap(part, left) is None
    assert gap(part, disc)[0] == pytest.approx(0.0, abs=1e-9)
    assert leaves(disc, ring) is None
    assert leaves(part.moved(0.0, (1e-4, 0.0)), disc) is not None
    assert overlap(part.moved(0.01, (0.0, 0.0)), left) is not None


def test_a_loop_may_touch_what_it_lies_in_but_not_leave_it() -> None:
    assert leaves(loop.rectangle((0.05, 0.0), (0.1, 0.1)), SQUARE) is None
    assert leaves(loop.circle((0.0, 0.0), 0.1), SQUARE) is None
    assert leaves(SQUARE, SQUARE) is None
    place = leaves(loop.rectangle((0.08, 0.0), (0.1, 0.1)), SQUARE)
    assert place is not None
    assert place[0] == pytest.approx(0.13, abs=2e-6)


def test_a_notch_that_reaches_into_a_loop_is_found() -> None:
    notched = loop.polygon(
        [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (0.001, 0.1), (0.0, 0.0), (-0.001, 0.1), (-0.1, 0.1)]
    )
    assert leaves(loop.rectangle((0.0, 0.0), (0.1, 0.1)), notched) is not None


def test_the_gap_between_circles() -> None:
    distance, place = gap(loop.circle((0.0, 0.0), 0.1), loop.circle((0.3, 0.0), 0.1))
    assert distance == pytest.approx(0.1, rel=1e-3)
    assert np.hypot(*(np.abs(place - (0.15, 0.0)) - (0.05, 0.0))) == pytest.approx(0.0, abs=1e-9)
