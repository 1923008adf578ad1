from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.declaration.plate import Plate
from analysis.declaration.transducers import Patch
from analysis.experiment import check_patches, check_point
from analysis.geometry.loop import GeometryError

PLATE = Plate.model_validate(
    {
        "outline": {"kind": "polygon", "points": [(0, 0), (0.4, 0), (0.4, 0.3), (0.2, 0.3), (0.2, 0.2), (0, 0.2)]},
        "hole": [{"kind": "circle", "center": (0.1, 0.1), "radius": 0.02}],
        "zone": [{"kind": "rectangle", "center": (0.3, 0.1), "size": (0.1, 0.1), "thickness": 0.004}],
        "thickness": 0.003,
        "mass": 0.3,
    }
)


def patch(center: tuple[float, float], **changes: Any) -> Patch:
    declared = {"id": "P", "role": "sensor", "center": center, "size": (0.02, 0.02), "thickness": 5e-4}
    return Patch.model_validate(declared | changes)


def disc(center: tuple[float, float], diameter: float, **changes: Any) -> Patch:
    declared = {"id": "D", "role": "sensor", "center": center, "diameter": diameter, "thickness": 5e-4}
    return Patch.model_validate(declared | changes)


def test_areas_and_borders() -> None:
    assert patch((0.3, 0.2), angle=30.0).area == pytest.approx(4e-4)
    assert disc((0.3, 0.2), 0.02).area == pytest.approx(np.pi * 1e-4, rel=1e-12)
    half = 0.01 * (np.cos(np.pi / 6) + np.sin(np.pi / 6))
    assert patch((0.3, 0.2), angle=30.0).span(0) == pytest.approx((0.3 - half, 0.3 + half))
    assert disc((0.3, 0.2), 0.03).span(1) == pytest.approx((0.185, 0.215))
    assert disc((0.3, 0.2), 0.03).size == (0.03, 0.03)


@pytest.mark.parametrize("one", [patch((0.3, 0.2)), patch((0.3, 0.2), angle=10.0), disc((0.3, 0.2), 0.02)])
def test_round_trip(one: Patch) -> None:
    assert Patch.model_validate_json(one.model_dump_json(), strict=True) == one
    assert Patch.model_validate(one.model_dump()) == one


def test_a_moved_copy_has_a_border_of_its_own() -> None:
    first = patch((0.3, 0.2))
    assert first.loop.centroid == pytest.approx((0.3, 0.2))
    assert first.model_copy(update={"center": (0.1, 0.05)}).loop.centroid == pytest.approx((0.1, 0.05))


def test_a_rectangular_patch_is_dumped_as_it_always_was() -> None:
    assert list(patch((0.3, 0.2)).model_dump()) == [
        "id",
        "role",
        "center",
        "size",
        "thickness",
        "side",
        "material",
    ]


def test_what_lies_right_is_taken() -> None:
    check_patches(
        PLATE,
        [
            patch((0.3, 0.1), angle=30.0),
            disc((0.3, 0.1), 0.05, side="bottom"),
            patch((0.21, 0.29), id="in the corner"),
            patch((0.1, 0.135), id="beside the hole"),
        ],
    )


@pytest.mark.parametrize(
    ("patches", "words", "place"),
    [
        ([patch((0.2, 0.205))], "'P' reaches over the plate's edge", (0.19, 0.215)),
        ([disc((0.2, 0.2), 0.01)], "'D' reaches over the plate's edge", (0.197, 0.203)),
        ([patch((0.012, 0.1), angle=45.0)], "spans -0.00214.* along x; the plate allows 0 to 0.4", (-0.002, 0.1)),
        ([patch((0.13, 0.1), angle=45.0)], "'P' reaches into hole 1", (0.118, 0.1)),
        ([patch((0.1, 0.1), size=(0.005, 0.005))], "'P' reaches into hole 1", (0.1, 0.1)),
        ([patch((0.1, 0.1), size=(0.06, 0.06))], "'P' reaches into hole 1", (0.1, 0.1)),
        ([patch((0.25, 0.1))], "'P' lies partly on zone 1", (0.24, 0.1)),
        ([patch((0.3, 0.1), size=(0.14, 0.14))], "'P' lies partly on zone 1", (0.3, 0.1)),
        ([patch((0.3, 0.2)), disc((0.315, 0.2), 0.02)], "'P' and 'D' overlap on the top face", (0.307, 0.2)),
        ([patch((0.3, 0.2)), disc((0.3, 0.2), 0.005)], "'P' and 'D' overlap on the top face", (0.3, 0.2)),
        ([patch((0.3, 0.2)), patch((0.3, 0.2), id="Q")], "'P' and 'Q' overlap on the top face", (0.3, 0.2)),
    ],
)
def test_a_patch_in_a_wrong_place_is_refused_with_the_place(
    patches: list[Patch], words: str, place: tuple[float, float]
) -> None:
    with pytest.raises(GeometryError, match=words) as caught:
        check_patches(PLATE, patches)
    assert np.hypot(*np.subtract(caught.value.places[0], place)) < 0.11
    ((x, y),) = caught.value.places
    assert patches[0].span(0)[0] - 1e-5 < x < patches[0].span(0)[1] + 1e-5
    assert patches[0].span(1)[0] - 1e-5 < y < patches[0].span(1)[1] + 1e-5


def test_two_patches_need_two_names() -> None:
    with pytest.raises(ValueError, match="'P' is used 2 times"):
        check_patches(PLATE, [patch((0.3, 0.2)), patch((0.35, 0.25))])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"size": None}, "size"),
        ({"diameter": 0.01}, "a size and a diameter"),
        ({"diameter": 0.0}, "diameter"),
    ],
)
def test_patches_of_no_or_two_shapes_are_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        patch((0.3, 0.2), **changes)


def test_no_extent_and_a_turned_disc_are_refused() -> None:
    with pytest.raises(ValidationError, match="has no extent; give size"):
        Patch.model_validate({"id": "P", "role": "sensor", "center": (0, 0), "thickness": 5e-4})
    with pytest.raises(ValidationError, match="is round; remove angle"):
        disc((0.3, 0.2), 0.02, angle=10.0)


def test_no_extent_is_told_together_with_other_keys_that_are_missing() -> None:
    """Else a person completes what the first message named and gets a second one."""
    with pytest.raises(ValidationError) as refused:
        Patch.model_validate({"id": "P", "role": "sensor"})
    assert {error["loc"][0] for error in refused.value.errors()} == {"center", "thickness", "diameter"}
    with pytest.raises(ValidationError) as refused:
        Patch.model_validate({"id": "P", "role": "sensor", "center": (0, 0), "thickness": 5e-4, "size": 0.02})
    assert [error["loc"][0] for error in refused.value.errors()] == ["size"]


def test_points_off_the_plate_and_in_a_hole_are_refused() -> None:
    check_point(PLATE, "string[0].point", (0.0, 0.2))
    with pytest.raises(GeometryError, match=r"string\[0\]\.point \[0\.1, 0\.25\] m is off the plate") as caught:
        check_point(PLATE, "string[0].point", (0.1, 0.25))
    assert caught.value.places == ((0.1, 0.25),)
    with pytest.raises(GeometryError, match=r"cable\[1\]\.point \[0\.1, 0\.11\] m is in hole 1"):
        check_point(PLATE, "cable[1].point", (0.1, 0.11))
