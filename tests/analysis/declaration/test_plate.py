import json
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.declaration.plate import Plate
from analysis.geometry.loop import GeometryError

ELL = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.2, 0.3), (0.2, 0.2), (0.0, 0.2)]
Changes = dict[str, Any]


def plate(**changes: Any) -> Plate:
    declared: Changes = {
        "outline": {"kind": "polygon", "points": ELL},
        "hole": [{"kind": "circle", "center": [0.1, 0.1], "radius": 0.02}],
        "thickness": 0.003,
        "mass": 0.3,
    }
    return Plate.model_validate_json(json.dumps(declared | changes), strict=True)


def fault_of(**changes: Any) -> GeometryError:
    """Return what the check of a plate says, with its places."""
    with pytest.raises(ValidationError) as caught:
        plate(**changes)
    (detail,) = caught.value.errors()
    error = detail["ctx"]["error"]
    assert isinstance(error, GeometryError), error
    return error


def test_a_rectangle_is_declared_and_dumped_as_it_always_was() -> None:
    declared = {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.13, "boundary": "free"}
    found = Plate(**declared)  # type: ignore[arg-type]
    assert found.model_dump() == declared
    assert list(found.model_dump()) == list(declared)
    assert found.loop.area == found.area == pytest.approx(0.24 * 0.19)
    assert found.density == pytest.approx(0.13 / (0.24 * 0.19 * 0.003))
    assert found.bounds == ((0.0, 0.0), (0.24, 0.19))


OUTLINES: list[tuple[Changes, float, tuple[float, float]]] = [
    ({"kind": "rectangle", "center": [0.1, 0.2], "size": [0.3, 0.2], "angle": 90.0}, 0.06, (0.2, 0.3)),
    ({"kind": "polygon", "points": ELL}, 0.1, (0.4, 0.3)),
    ({"kind": "circle", "center": [0.0, 0.0], "radius": 0.15}, np.pi * 0.15**2, (0.3, 0.3)),
    ({"kind": "ellipse", "center": [0.0, 0.0], "radii": [0.2, 0.1], "angle": 90.0}, np.pi * 0.02, (0.2, 0.4)),
    ({"kind": "curves", "curves": [[0, 0, 0.1, 0.1, 0, 0, np.pi], [-0.1, 0, 0.1, 0]]}, np.pi * 0.005, (0.2, 0.1)),
]


@pytest.mark.parametrize(("outline", "area", "extent"), OUTLINES, ids=lambda value: "")
def test_area_extent_density_and_round_trip_of_every_kind(
    outline: Changes, area: float, extent: tuple[float, float]
) -> None:
    found = plate(outline=outline, hole=[])
    assert found.area == pytest.approx(area, rel=1e-10)
    assert (found.length_x, found.length_y) == pytest.approx(extent, rel=1e-9)
    assert found.density == pytest.approx(0.3 / (area * 0.003))
    again = Plate.model_validate_json(found.model_dump_json(), strict=True)
    assert again == found
    assert hash(again) == hash(found)
    assert "length_x" not in found.model_dump()


def test_a_spline_goes_through_its_points() -> None:
    points = [[0.0, 0.0], [0.3, 0.0], [0.35, 0.2], [0.1, 0.25]]
    found = plate(outline={"kind": "spline", "points": points}, hole=[])
    assert found.loop.distance(np.array(points)).max() < 1e-15
    assert found.contains(np.array([[0.2, 0.1]])).all()


def test_the_area_leaves_out_holes_and_the_volume_counts_zones_without_them() -> None:
    pad = {"kind": "rectangle", "center": [0.1, 0.1], "size": [0.1, 0.1], "thickness": 0.005}
    rib = {"kind": "rectangle", "center": [0.3, 0.1], "size": [0.05, 0.1], "thickness": 0.002}
    hole = np.pi * 0.02**2
    assert plate().area == pytest.approx(0.1 - hole, rel=1e-12)
    volume = (0.1 - hole) * 0.003 + 0.002 * (0.01 - hole) - 0.001 * 0.005
    assert plate(zone=[pad, rib]).volume == pytest.approx(volume, rel=1e-12)
    assert len(plate(zone=[pad, rib]).zone_loops) == 2


def test_zones_may_reach_to_the_outline_and_to_each_other() -> None:
    declared = {"kind": "rectangle", "size": [0.1, 0.1], "thickness": 0.005}
    zones = [declared | {"center": [0.35, 0.05]}, declared | {"center": [0.25, 0.05]}]
    found = plate(zone=zones)
    assert found.volume == pytest.approx(0.003 * found.area + 0.002 * 0.02, rel=1e-12)
    sliver = declared | {"center": [0.24995, 0.05]}
    assert "zone 1 and zone 2 are 0.05 mm apart" in str(fault_of(zone=[zones[0], sliver]))


def test_edges_belong_to_the_plate_and_holes_do_not() -> None:
    edge = np.deg2rad(np.arange(0.0, 360.0, 7.0))
    rim = np.stack([0.1 + 0.02 * np.cos(edge), 0.1 + 0.02 * np.sin(edge)], axis=1)
    found = plate()
    assert found.contains(np.array(ELL)).all()
    assert found.contains(rim).all()
    assert not found.contains(np.array([[0.1, 0.1], [0.1, 0.25], [0.41, 0.1]])).any()
    assert not found.contains(0.999 * (rim - 0.1) + 0.1).any()


def test_normalised_runs_from_minus_one_to_one_over_the_bounding_box() -> None:
    found = plate(outline={"kind": "circle", "center": [0.1, -0.2], "radius": 0.15}, hole=[])
    xi, zeta = found.normalised(np.array([[0.1, -0.2], [0.25, -0.35], [-0.05, -0.05]]))
    np.testing.assert_allclose(xi, [0.0, 1.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(zeta, [0.0, -1.0, 1.0], atol=1e-12)


def test_curvature_of_one_radius_is_a_sphere_near_its_pole() -> None:
    found = plate(
        outline={"kind": "circle", "center": [0.1, -0.2], "radius": 0.15}, hole=[], curvature={"radius": 3.0}
    )
    points = np.array([[0.1, -0.2], [0.2, -0.2], [0.15, -0.1]])
    away = points - (0.1, -0.2)
    np.testing.assert_allclose(found.height(points), 3.0 - np.sqrt(9.0 - (away**2).sum(axis=1)), atol=1e-6)
    np.testing.assert_allclose(found.slope(points), away / 3.0, atol=1e-12)
    assert not plate().height(points).any()
    assert not plate().slope(points).any()


def test_a_cylinder_and_a_height_field() -> None:
    square = {"kind": "rectangle", "center": [0.0, 0.0], "size": [0.2, 0.4]}
    points = np.array([[0.1, 0.2], [0.05, -0.1], [-0.02, 0.03]])
    x, y = points.T
    cylinder = plate(outline=square, hole=[], curvature={"radius_y": -2.0})
    np.testing.assert_allclose(cylinder.height(points), -0.25 * y**2, atol=1e-15)
    saddle = plate(outline=square, hole=[], curvature={"height": [[0.001], [0.0, 0.002]]})
    np.testing.assert_allclose(saddle.height(points), 0.001 + 0.002 * (x / 0.1) * (y / 0.2), atol=1e-15)
    np.testing.assert_allclose(saddle.slope(points), 0.1 * np.stack([y, x], axis=1), atol=1e-15)


def test_temperature_of_the_dimensions_is_kept() -> None:
    found = plate(dimensions_at=23.0, expansion=1.5e-4)
    assert (found.dimensions_at, found.expansion) == (23.0, 1.5e-4)
    assert found.model_dump()["dimensions_at"] == 23.0


@pytest.mark.parametrize(
    ("changes", "words", "place"),
    [
        (
            {"outline": {"kind": "polygon", "points": [[0, 0], [0.3, 0.3], [0.3, 0], [0, 0.3]]}, "hole": []},
            "crosses or touches itself",
            (0.15, 0.15),
        ),
        (
            {"outline": {"kind": "spline", "points": [[0, 0], [0.3, 0.3], [0.3, 0], [0, 0.3]]}, "hole": []},
            "crosses or touches itself",
            (0.15, 0.15),
        ),
        (
            {"outline": {"kind": "curves", "curves": [[0, 0, 0.2, 0], [0.2, 0, 0.2, 0.2], [0.2, 0.2, 0, 0.1]]}},
            "open outline: curve 3",
            (0.0, 0.1),
        ),
        (
            {"outline": {"kind": "polygon", "points": [[0, 0], [0.2, 0], [0.2, 0], [0, 0.2]]}, "hole": []},
            "curve 2 of the outline has no length",
            (0.2, 0.0),
        ),
        ({"hole": [{"kind": "circle", "center": [0.1, 0.25], "radius": 0.02}]}, "hole 1 reaches out", (0.1, 0.27)),
        ({"hole": [{"kind": "circle", "center": [0.1, 0.2], "radius": 0.02}]}, "hole 1 reaches out", (0.1, 0.22)),
        ({"hole": [{"kind": "circle", "center": [0.1, 0.02], "radius": 0.02}]}, "0 mm apart", (0.1, 0.0)),
        (
            {
                "hole": [
                    {"kind": "circle", "center": [0.1, 0.1], "radius": 0.02},
                    {"kind": "rectangle", "center": [0.12, 0.1], "size": [0.02, 0.01]},
                ]
            },
            "hole 1 and hole 2 overlap",
            (0.115, 0.1),
        ),
        (
            {"zone": [{"kind": "circle", "center": [0.05, 0.1], "radius": 0.06, "thickness": 0.004}]},
            "zone 1 reaches out",
            (-0.01, 0.1),
        ),
        (
            {"zone": [{"kind": "circle", "center": [0.12, 0.1], "radius": 0.02, "thickness": 0.004}]},
            "hole 1 crosses the border of zone 1",
            (0.11, 0.1),
        ),
        ({"curvature": {"radius": 0.5}}, "allowed 0.3 in a shallow shell", (0.0, 0.0)),
        (
            {"outline": {"kind": "polygon", "points": [[0, 0], [240, 0], [240, 190]]}, "hole": []},
            r"spans 240 m along x; allowed 0.01 to 5 \(points in m\?\)",
            (0.0, 0.0),
        ),
    ],
)
def test_bad_geometry_is_refused_with_its_place(changes: Changes, words: str, place: tuple[float, float]) -> None:
    error = fault_of(**changes)
    with pytest.raises(GeometryError, match=words):
        raise error
    assert np.hypot(*np.subtract(error.places[0], place)) < 0.03


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"thickness": 0.0}, "greater than or equal to 0.0001"),
        ({"thickness": -0.003}, "greater than or equal to 0.0001"),
        (
            {"zone": [{"kind": "circle", "center": [0.3, 0.1], "radius": 0.02, "thickness": -1e-3}]},
            "greater than or equal",
        ),
        ({"mass": 0.0003}, "mass inconsistent with the area, 0.09874 m2"),
        ({"length_x": 0.3}, "length_x and .* both declare the outline; remove length_x"),
        ({"outline": None}, "plate.length_x and plate.length_y are missing; give them in m"),
        ({"outline": {"kind": "oval"}}, "'oval'"),
        ({"outline": {"kind": "polygon", "points": [[0, 0], [1, 1]]}}, "at least 3"),
        ({"outline": {"kind": "curves", "curves": [[0, 0, 1, 1, 2]]}}, "has 5 numbers; allowed 4"),
        ({"outline": {"kind": "curves", "curves": [[0, 0, -1, 1, 0, 0, 1]]}}, "must be above 0"),
        ({"curvature": {"radius": 3.0, "radius_x": 2.0}}, "one of the three"),
        ({"curvature": {"radius": 0.0}}, "leave it out"),
        (
            {"curvature": {"radius_x": 5000.0}},
            r"radius_x 5000 m: over this plate it rises by .* \(radius in m\?\)",
        ),
        (
            {
                "thickness": 0.05,
                "mass": 5.0,
                "outline": {"kind": "circle", "center": [0, 0], "radius": 0.1},
                "hole": [],
            },
            "not a plate",
        ),
    ],
)
def test_nonsense_is_refused(changes: Changes, words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        plate(**changes)


def test_no_extent_is_told_together_with_other_keys_that_are_missing() -> None:
    with pytest.raises(ValidationError) as refused:
        Plate.model_validate({"length_x": 0.3, "mass": 0.1})
    told = {error["loc"][0]: error["msg"] for error in refused.value.errors()}
    assert told.keys() == {"outline", "thickness"}
    assert "plate.length_y is missing; give it in m" in told["outline"]
