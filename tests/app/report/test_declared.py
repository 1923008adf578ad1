from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from analysis.declaration.plate import Plate
from analysis.declaration.transducers import Drive, Patch, Sensor
from app.files.bad_file import Misplaced
from app.report.declared import picture, pieces_declared, pieces_of, pieces_of_experiment, plate_words

DECLARED: dict[str, Any] = {
    "plate": {
        "outline": {"kind": "polygon", "points": [[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.0, 0.2]]},
        "hole": [{"kind": "circle", "center": [0.1, 0.1], "radius": 0.02}],
        "zone": [{"kind": "ellipse", "center": [0.3, 0.1], "radii": [0.04, 0.02], "thickness": 0.004}],
        "support": [
            {"kind": "clamped", "edge": 2},
            {"kind": "elastic", "point": [0.2, 0.2], "stiffness": 1e4},
        ],
        "thickness": 0.003,
        "mass": 0.3,
    },
    "patch": [{"id": "A1", "role": "actuator", "center": [0.2, 0.1], "diameter": 0.02, "thickness": 5e-4}],
}


def test_a_declaration_and_what_can_be_drawn_of_it_unchecked_are_the_same() -> None:
    plate = Plate.model_validate(DECLARED["plate"])
    checked = pieces_of(plate, [Patch.model_validate(item) for item in DECLARED["patch"]])
    unchecked = pieces_declared(Misplaced(Path("a.toml"), DECLARED, ()))
    assert unchecked == checked
    assert [len(part) for part in (checked.outline, checked.holes, checked.zones)] == [4, 4, 4]
    assert [kind for kind, _ in checked.held] == ["clamped"]


def test_the_picture_shows_every_piece_and_rings_the_fault() -> None:
    pieces = pieces_declared(Misplaced(Path("a.toml"), DECLARED, ()))
    (axes,) = picture(pieces, [(0.35, 0.02)]).axes
    labels = {artist.get_label() for artist in (*axes.lines, *axes.patches)}
    assert {"plate", "holes", "zones", "patches", "clamped", "elastic", "wrong here"} <= labels
    (ring,) = [line for line in axes.lines if line.get_label() == "wrong here"]
    assert ring.get_xydata().tolist() == [[0.35, 0.02]]
    low, high = axes.get_xlim()
    assert low < 0.0
    assert high > 0.4


def test_points_driven_and_measured_differ_and_have_the_names_of_their_channels() -> None:
    pieces = pieces_of(Plate.model_validate(DECLARED["plate"]), [])
    grid = Sensor(id="L", kind="velocity", grid=(5, 4), margin=0.02)
    channels = grid.channels(Plate.model_validate(DECLARED["plate"]))
    experiment = SimpleNamespace(
        plate=Plate.model_validate(DECLARED["plate"]),
        patch=(),
        string=(),
        cable=(),
        drive=(Drive(id="shaker", kind="force", point=(0.25, 0.15)),),
        sensor=(grid,),
    )
    drawn = pieces_of_experiment(experiment)  # type: ignore[arg-type]
    assert (drawn.outline, drawn.points) == (pieces.outline, pieces.points)
    (axes,) = picture(drawn).axes
    lines = {line.get_label(): line for line in axes.lines}
    driven, measured = lines["driven"], lines["measured"]
    assert driven.get_marker() != measured.get_marker()
    assert driven.get_color() != measured.get_color()
    assert measured.get_xydata().tolist() == [list(c.footprint.point) for c in channels if c.footprint]
    named = {text.get_text(): text.xy for text in axes.texts}
    assert len(channels) > 10
    assert named["L10"] == channels[9].footprint.point  # type: ignore[union-attr]
    assert named["shaker"] == (0.25, 0.15)


@pytest.mark.parametrize(
    "plate",
    [
        {"outline": {"kind": "polygon", "points": [[0, 0], [0.3, 0.3], [0.3, 0], [0, 0.3]]}},
        {"outline": {"kind": "polygon", "points": "none"}},
        {"outline": {"kind": "oval"}},
        {"outline": 3},
        {"length_x": 0.2, "length_y": 0.1, "hole": [{"kind": "circle"}], "support": [{"kind": "clamped"}]},
        {"length_x": "a", "length_y": 0.1, "zone": 3},
        7,
    ],
)
def test_a_picture_is_made_of_anything(plate: Any) -> None:
    declared = {"plate": plate, "patch": [{"id": 3}, 4], "string": [{"point": [0.1]}, {"point": [0.1, 0.1]}]}
    pieces = pieces_declared(Misplaced(Path("a.toml"), declared, ()))
    assert pieces.points == (("string", (0.1, 0.1)),)
    picture(pieces, [(0.1, 0.1)])


def test_a_plate_in_a_line() -> None:
    rectangle = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.13)
    assert plate_words(rectangle) == "240 × 190 × 3 mm, free"
    words = "400 × 300 × 3 mm over all (polygon), 1 hole, 1 thickness zone, 2 supports"
    assert plate_words(Plate.model_validate(DECLARED["plate"])) == words
