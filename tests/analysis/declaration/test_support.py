from typing import Any

import pytest
from pydantic import ValidationError

from analysis.declaration.outline import SupportedEdge
from analysis.declaration.plate import Plate

RECTANGLE: dict[str, Any] = {"length_x": 0.4, "length_y": 0.2, "thickness": 0.002, "mass": 0.16}
DISC = {"outline": {"kind": "circle", "center": (0.0, 0.0), "radius": 0.2}, "thickness": 0.002, "mass": 0.2}


def edges(declared: dict[str, Any], *supports: dict[str, Any]) -> list[SupportedEdge]:
    return Plate.model_validate({**declared, "support": supports}).supported_edges()


def length(declared: dict[str, Any], found: SupportedEdge) -> float:
    """Length held, m."""
    plate = Plate.model_validate(declared)
    loop = (plate.loop, *plate.hole_loops)[found.loop]
    return sum(_length(loop.curves[k], first, last) for k, first, last in found.pieces)


def _length(curve: Any, first: float, last: float) -> float:
    from numpy import hypot, linspace, trapezoid

    t = linspace(first, last, 401)
    return float(trapezoid(hypot(*curve.derivative(t).T), t))


@pytest.mark.parametrize(("name", "curve"), [("bottom", 0), ("right", 1), ("top", 2), ("left", 3)])
def test_sides_of_a_rectangle_by_name(name: str, curve: int) -> None:
    (found,) = edges(RECTANGLE, {"kind": "clamped", "edge": name})
    assert found.pieces == ((curve, 0.0, 1.0),)
    assert found.loop == 0


def test_edges_by_number_count_as_declared_even_where_the_outline_runs_clockwise() -> None:
    points = [(0.0, 0.0), (0.0, 0.2), (0.4, 0.2), (0.4, 0.0)]
    for order in (points, points[::-1]):
        declared = {"outline": {"kind": "polygon", "points": order}, "thickness": 0.002, "mass": 0.16}
        (found,) = edges(declared, {"kind": "clamped", "edge": 2})
        (start, end) = order[1], order[2]
        curve = Plate.model_validate(declared).loop.curves[found.pieces[0][0]]
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        assert curve.at(0.5) == pytest.approx(middle)


def test_a_part_runs_counter_clockwise_over_corners_and_the_seam() -> None:
    part = {"kind": "clamped", "from": (0.4, 0.1), "to": (0.3, 0.2)}
    (found,) = edges(RECTANGLE, part)
    assert length(RECTANGLE, found) == pytest.approx(0.2)
    (rest,) = edges(RECTANGLE, {"kind": "clamped", "from": (0.3, 0.2), "to": (0.4, 0.1)})
    assert length(RECTANGLE, rest) == pytest.approx(1.2 - 0.2)
    (arc,) = edges(DISC, {"kind": "clamped", "from": (0.0, -0.2), "to": (0.0, 0.2)})
    assert length(DISC, arc) == pytest.approx(0.2 * 3.141592653589793, rel=1e-4)
    (back,) = edges(RECTANGLE, {"kind": "clamped", "from": (0.3, 0.0), "to": (0.1, 0.0)})
    assert length(RECTANGLE, back) == pytest.approx(1.0)


def test_the_later_support_counts_and_free_takes_back() -> None:
    found = edges(
        RECTANGLE,
        {"kind": "soft-simple", "edge": "all"},
        {"kind": "elastic", "edge": "left", "translation": 1e5, "rotation": 10.0, "damping": 3.0},
        {"kind": "free", "from": (0.1, 0.0), "to": (0.3, 0.0)},
    )
    assert [one.support.kind for one in found] == ["soft-simple", "elastic"]
    assert length(RECTANGLE, found[0]) == pytest.approx(1.2 - 0.2 - 0.2)
    assert length(RECTANGLE, found[1]) == pytest.approx(0.2)


def test_holes_have_edges_of_their_own() -> None:
    hole = {"kind": "rectangle", "center": (0.0, 0.0), "size": (0.1, 0.04)}
    found = edges(
        DISC | {"hole": [hole]}, {"kind": "clamped", "hole": 1}, {"kind": "free", "hole": 1, "edge": "top"}
    )
    assert [one.loop for one in found] == [1]
    assert length(DISC | {"hole": [hole]}, found[0]) == pytest.approx(0.28 - 0.1)


def test_a_clamped_boundary_is_a_clamped_outline() -> None:
    (found,) = Plate.model_validate(RECTANGLE | {"boundary": "clamped"}).supported_edges()
    assert (found.support.kind, found.loop, len(found.pieces)) == ("clamped", 0, 4)


def test_points_are_kept_apart_and_survive_a_dump() -> None:
    spring = {"kind": "elastic", "point": (0.1, 0.1), "radius": 0.004, "stiffness": 1e4, "damping": 2.0}
    found = Plate.model_validate(RECTANGLE | {"support": [spring, {"kind": "clamped", "edge": "left"}]})
    ((point, _),) = found.supported_discs().values()
    assert (point.radius, point.stiffness) == (0.004, 1e4)
    assert len(found.supported_edges()) == 1
    assert Plate.model_validate(found.model_dump()) == found
    assert Plate.model_validate_json(found.model_dump_json(), strict=True) == found


@pytest.mark.parametrize(
    ("support", "words"),
    [
        (
            {"kind": "clamped", "from": (0.1, 0.01), "to": (0.2, 0.0)},
            r"support\[0\]: from \(0.1, 0.01\) m lies 10 mm off the edge",
        ),
        ({"kind": "clamped", "from": (0.1, 0.0), "to": (0.1, 0.0)}, "the part has no length"),
        ({"kind": "clamped", "from": (0.1, 0.0)}, "one of them is missing"),
        (
            {"kind": "clamped", "edge": 5},
            r"support\[0\]: edge 5 does not exist; this outline has the edges 1 to 4",
        ),
        ({"kind": "clamped", "hole": 1}, "hole 1 does not exist"),
        ({"kind": "clamped"}, "names no place"),
        ({"kind": "clamped", "edge": "left", "point": (0.1, 0.1)}, "different places"),
        ({"kind": "clamped", "hole": 1, "point": (0.1, 0.1)}, "different places"),
        ({"kind": "clamped", "edge": "left", "radius": 0.004}, "radius belongs"),
        ({"kind": "elastic", "edge": "left"}, "nothing holds"),
        ({"kind": "elastic", "edge": "left", "stiffness": 1e3}, "no meaning along an edge"),
        ({"kind": "elastic", "point": (0.1, 0.1), "rotation": 1e3}, "no meaning at a point"),
        ({"kind": "clamped", "edge": "left", "translation": 1e3}, "belongs to kind elastic"),
        ({"kind": "free", "point": (0.1, 0.1)}, "no meaning at a point"),
        ({"kind": "clamped", "point": (0.5, 0.1)}, r"point \(0.5, 0.1\) m is off the plate"),
        (
            {"kind": "elastic", "point": (0.001, 0.1), "stiffness": 1e3},
            "radius 0.002 m, reaches over the edge at .* m; move it, choose a smaller radius, or hold a part",
        ),
        ({"kind": "clamped", "point": (0.0, 0.1)}, "reaches over the edge"),
    ],
)
def test_a_support_on_nothing_is_refused(support: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        edges(RECTANGLE, support)


def test_names_belong_to_rectangles_only_and_a_clamped_boundary_needs_no_support() -> None:
    with pytest.raises(ValidationError, match="this outline has the edges 1 to 4 and all"):
        edges(DISC, {"kind": "clamped", "edge": "left"})
    with pytest.raises(ValidationError, match="holds every edge already"):
        edges(RECTANGLE | {"boundary": "clamped"}, {"kind": "clamped", "edge": "left"})
