"""Drawings of known area, written by the library that reads DXF, and by hand."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf.filemanagement
import numpy as np
import pytest

from analysis.declaration.plate import Plate
from analysis.geometry.loop import GeometryError
from app.files.drawings.drawing import DrawingError, with_drawings

SLOT_AREA = 0.1 * 0.05 + np.pi * 0.025**2
PAGE = '<svg xmlns="http://www.w3.org/2000/svg" {size}>{body}</svg>'


def dxf(path: Path, draw: Callable[[Any], object], unit: int = 4) -> None:
    document = ezdxf.filemanagement.new()
    document.units = unit
    draw(document.modelspace())
    document.saveas(path)


def slot(space: Any) -> None:
    """Draw 100 by 50 mm with round ends, a round hole and an elliptic one, and a text."""
    space.add_lwpolyline([(0, 0), (100, 0, 0, 0, 1.0), (100, 50), (0, 50, 0, 0, 1.0)], close=True)
    space.add_circle((20, 25), 5)
    space.add_ellipse((70, 25), (0, 8), 0.5)
    space.add_text("slot")


def plate(folder: Path, **changes: Any) -> Plate:
    outline = {"kind": "drawing"} | changes.pop("outline")
    declared = {"plate": {"outline": outline, "thickness": 0.001, "mass": 0.01, **changes}}
    return Plate.model_validate(with_drawings(folder, declared)["plate"])


def test_the_largest_loop_is_the_outline_and_the_others_are_holes(tmp_path: Path) -> None:
    dxf(tmp_path / "slot.dxf", slot)
    found = plate(tmp_path, outline={"file": "slot.dxf"})
    assert found.loop.area == pytest.approx(SLOT_AREA, rel=1e-12)
    assert sorted(hole.area for hole in found.hole_loops) == pytest.approx(
        [np.pi * 0.005**2, np.pi * 0.008 * 0.004], rel=1e-12
    )
    assert found.bounds[0] == pytest.approx((-0.025, 0.0), abs=1e-12)
    assert "slot.dxf" not in found.model_dump_json()
    assert Plate.model_validate_json(found.model_dump_json(), strict=True) == found


@pytest.mark.parametrize(
    ("unit", "code", "scale"), [(None, 6, 1.0), ("cm", 6, 0.01), (None, 0, 1e-3), ("in", 4, 0.0254)]
)
def test_units_are_those_declared_else_those_of_the_file_else_millimetres(
    tmp_path: Path, unit: str | None, code: int, scale: float
) -> None:
    side = 0.1 / scale
    dxf(tmp_path / "a.dxf", lambda space: space.add_lwpolyline([(0, 0), (side, 0), (0, side)], close=True), code)
    found = plate(tmp_path, outline={"file": "a.dxf", "unit": unit} if unit else {"file": "a.dxf"})
    assert found.area == pytest.approx(0.005, rel=1e-9)


def test_lines_and_arcs_chain_and_a_plane_seen_from_below_is_mirrored(tmp_path: Path) -> None:
    def draw(space: Any) -> None:
        below = {"extrusion": (0, 0, -1)}
        space.add_line((0, 0), (100, 0))
        space.add_arc((100, 25), 25, -90, 90)
        space.add_line((100, 50), (0, 50))
        space.add_arc((0, 25), 25, -90, 90, dxfattribs=below)  # as seen from above: the left half
        space.add_circle((-20, 20), 5, dxfattribs=below)

    dxf(tmp_path / "a.dxf", draw)
    found = plate(tmp_path, outline={"file": "a.dxf"})
    assert found.loop.area == pytest.approx(SLOT_AREA, rel=1e-9)
    assert found.hole_loops[0].centroid == pytest.approx((0.02, 0.02))


def test_a_cubic_spline_is_taken_exactly_and_a_rational_one_closely(tmp_path: Path) -> None:
    def parabola(space: Any) -> None:
        space.add_open_spline([(0, 0), (100, 0), (0, 100), (100, 100)])
        space.add_line((100, 100), (0, 200))
        space.add_line((0, 200), (0, 0))

    dxf(tmp_path / "a.dxf", parabola)
    # The curve's share is 3/20 of the cross products of its control points; the two lines close it.
    found = plate(tmp_path, outline={"file": "a.dxf"})
    control = np.array([(0, 0), (100, 0), (0, 100), (100, 100)], float)
    weights = {(0, 1): 0.3, (0, 2): 0.15, (0, 3): 0.05, (1, 2): 0.15, (1, 3): 0.15, (2, 3): 0.3}
    area = sum(
        w * float(control[i][0] * control[j][1] - control[i][1] * control[j][0]) for (i, j), w in weights.items()
    )
    area += 0.5 * (100 * 200 - 100 * 0)
    assert found.area == pytest.approx(1e-6 * area, rel=1e-7)

    def quarter(space: Any) -> None:
        weight = np.sqrt(0.5)
        space.add_rational_spline([(100, 0), (100, 100), (0, 100)], [1.0, weight, 1.0], degree=2)
        space.add_line((0, 100), (0, 0))
        space.add_line((0, 0), (100, 0))

    dxf(tmp_path / "b.dxf", quarter)
    assert plate(tmp_path, outline={"file": "b.dxf"}).area == pytest.approx(0.25 * np.pi * 0.01, rel=2e-5)


def test_only_the_layer_asked_for(tmp_path: Path) -> None:
    def draw(space: Any) -> None:
        slot(space)
        space.add_line((0, 0), (300, 0), dxfattribs={"layer": "axes"})
        space.add_lwpolyline([(0, 0), (30, 0), (0, 30)], close=True, dxfattribs={"layer": "trim"})

    dxf(tmp_path / "a.dxf", draw)
    found = plate(tmp_path, outline={"file": "a.dxf", "layer": "trim"})
    assert found.area == pytest.approx(0.5 * 0.03**2)


def test_layers_are_found_in_either_case_and_named_where_there_is_none(tmp_path: Path) -> None:
    dxf(tmp_path / "a.dxf", lambda space: space.add_circle((0, 0), 50, dxfattribs={"layer": "Plate"}))
    assert plate(tmp_path, outline={"file": "a.dxf", "layer": "PLATE"}).area == pytest.approx(np.pi * 0.05**2)
    with pytest.raises(DrawingError, match="nothing stands on layer 'outline'; the drawing has 'Plate'"):
        plate(tmp_path, outline={"file": "a.dxf", "layer": "outline"})


def test_what_a_drawing_hides_is_no_outline_unless_its_layer_is_named(tmp_path: Path) -> None:
    """A hidden circle of construction around the plate became the outline, and the plate its hole."""

    def draw(space: Any) -> None:
        space.doc.layers.add("construction").freeze()
        space.doc.layers.add("notes").off()
        space.add_circle((0, 0), 50)
        space.add_circle((0, 0), 70, dxfattribs={"layer": "construction"})
        space.add_circle((0, 0), 80, dxfattribs={"layer": "notes"})
        space.add_circle((0, 0), 90, dxfattribs={"invisible": 1})

    dxf(tmp_path / "a.dxf", draw)
    assert plate(tmp_path, outline={"file": "a.dxf"}).area == pytest.approx(np.pi * 0.05**2)
    named = plate(tmp_path, outline={"file": "a.dxf", "layer": "construction"}, mass=0.02)
    assert named.area == pytest.approx(np.pi * 0.07**2)


@pytest.mark.parametrize(
    "draw",
    [
        lambda space: space.add_circle((0, 0), 50, dxfattribs={"extrusion": (0, 0.6, 0.8)}),
        lambda space: space.add_lwpolyline(
            [(0, 0), (90, 0), (0, 90)], close=True, dxfattribs={"extrusion": (1, 0, 0)}
        ),
        lambda space: space.add_line((0, 0, 0), (90, 0, 5)),
        lambda space: space.add_open_spline([(0, 0, 0), (90, 0, 3), (0, 90, 9), (9, 9, 9)]),
    ],
)
def test_what_lies_on_another_plane_is_refused(tmp_path: Path, draw: Callable[[Any], object]) -> None:
    dxf(tmp_path / "a.dxf", draw)
    with pytest.raises(DrawingError, match="does not lie in the plane of x and y; flatten the drawing"):
        plate(tmp_path, outline={"file": "a.dxf"})


def test_units_of_maps_and_stars_are_refused(tmp_path: Path) -> None:
    for code, scale in ((14, 0.1), (10, 0.9144), (9, 2.54e-5)):
        side = 0.1 / scale
        dxf(
            tmp_path / "a.dxf",
            lambda space, side=side: space.add_lwpolyline([(0, 0), (side, 0), (0, side)], close=True),
            code,
        )
        assert plate(tmp_path, outline={"file": "a.dxf"}).area == pytest.approx(0.005, rel=1e-9)
    dxf(tmp_path / "a.dxf", slot, 7)
    with pytest.raises(DrawingError, match=r"its unit \(\$INSUNITS 7\) is not that of a plate"):
        plate(tmp_path, outline={"file": "a.dxf"})


def test_a_closed_spline_without_clamped_ends_is_read(tmp_path: Path) -> None:
    """Its knots begin before its first point. Area of a B-spline of a regular octagon by its Fourier series."""
    corners = [(50 * np.cos(a), 50 * np.sin(a), 0.0) for a in np.arange(8) * np.pi / 4]
    dxf(tmp_path / "a.dxf", lambda space: space.add_spline().set_closed(corners, degree=3))
    # harmonic k = 1 + 8 m of the curve is 50 sinc(k / 8)**4 exp(j k t); the area pi sum of k |c_k|**2
    k = 1.0 + 8.0 * np.arange(-40, 41)
    area = np.pi * (k * (0.05 * np.sinc(k / 8.0) ** 4) ** 2).sum()
    assert plate(tmp_path, outline={"file": "a.dxf"}).area == pytest.approx(area, rel=1e-6)


def test_a_hole_and_a_zone_of_their_own_drawings(tmp_path: Path) -> None:
    dxf(
        tmp_path / "slot.dxf",
        lambda space: space.add_lwpolyline([(0, 0), (100, 0), (100, 50), (0, 50)], close=True),
    )
    dxf(tmp_path / "hole.dxf", lambda space: space.add_circle((20, 25), 5))
    dxf(tmp_path / "zone.dxf", lambda space: space.add_circle((70, 25), 10))
    drawn = {"kind": "drawing"}
    found = plate(
        tmp_path,
        outline={"file": "slot.dxf"},
        hole=[drawn | {"file": "hole.dxf"}],
        zone=[drawn | {"file": "zone.dxf", "thickness": 0.002}],
    )
    volume = 0.001 * (0.005 - np.pi * 0.005**2) + 0.001 * np.pi * 0.01**2
    assert found.volume == pytest.approx(volume, rel=1e-12)


def test_svg_paths_and_shapes_in_the_size_of_the_page(tmp_path: Path) -> None:
    body = (
        '<g transform="translate(100 50)"><path d="M0,0 h1000 a250 250 0 0 1 0 500 H0 a250 250 0 0 1 0 -500 z"/>'
        '<circle cx="200" cy="100" r="50"/><path d="M 700 200 q 50 100 100 0 z"/></g>'
    )
    page = PAGE.format(size='width="200mm" height="100mm" viewBox="0 0 2000 1000"', body=body)
    (tmp_path / "slot.svg").write_text(page, encoding="utf-8")
    found = plate(tmp_path, outline={"file": "slot.svg"})
    assert found.loop.area == pytest.approx(SLOT_AREA, rel=1e-6)
    circle, lens = sorted(found.hole_loops, key=lambda hole: -hole.area)
    assert circle.centroid == pytest.approx((0.03, 0.1 - 0.015))  # y upward from the lower edge of the page
    assert circle.area == pytest.approx(np.pi * 0.005**2, rel=1e-6)
    assert lens.area == pytest.approx(2.0 / 3.0 * 0.01 * 0.005, rel=1e-6)
    inches = plate(tmp_path, outline={"file": "slot.svg", "unit": "mm"}, mass=1.0)
    assert inches.loop.area == pytest.approx(100.0 * SLOT_AREA, rel=1e-6)


def test_a_page_without_a_view_box_is_drawn_in_px(tmp_path: Path) -> None:
    """96 px are an inch: a page of 300 mm is 1134 px wide."""
    body = '<rect x="96" y="96" width="192" height="96"/>'
    (tmp_path / "a.svg").write_text(PAGE.format(size='width="300mm" height="127mm"', body=body), encoding="utf-8")
    found = plate(tmp_path, outline={"file": "a.svg"})
    assert found.bounds[0] == pytest.approx((0.0254, 0.127 - 0.0508))
    assert found.area == pytest.approx(0.0508 * 0.0254)


@pytest.mark.parametrize("mirror", [1, -1])
def test_transforms_that_shear_make_other_ellipses_of_arcs(tmp_path: Path, mirror: int) -> None:
    """Areas change by the determinant, also of an arc's part of an ellipse."""
    one = np.array([[mirror * 1.3, 0.7], [-0.4, 0.9]])
    matrix = f"matrix({one[0, 0]} {one[1, 0]} {one[0, 1]} {one[1, 1]} 80 90)"
    body = (
        f'<g transform="{matrix}"><path d="M -40 0 A 40 25 0 0 1 40 0 z"/></g>'
        f'<circle r="2" cx="0" cy="-10" transform="{matrix}"/>'
    )
    page = PAGE.format(size='width="300mm" height="200mm" viewBox="0 0 300 200"', body=body)
    (tmp_path / "a.svg").write_text(page, encoding="utf-8")
    found = plate(tmp_path, outline={"file": "a.svg"})
    scale = 1e-6 * abs(np.linalg.det(one))
    assert found.loop.area == pytest.approx(scale * 0.5 * np.pi * 40 * 25, rel=1e-6)
    x, y = one @ (0.0, -10.0) + (80.0, 90.0)
    assert found.hole_loops[0].centroid == pytest.approx((1e-3 * x, 1e-3 * (200.0 - y)))
    assert found.hole_loops[0].area == pytest.approx(scale * np.pi * 4, rel=1e-6)


def test_a_stretched_page_is_refused_and_what_is_hidden_left_out(tmp_path: Path) -> None:
    body = '<rect x="10" y="10" width="60" height="20"/><circle r="99" visibility="hidden"/>'
    size = 'width="300mm" height="200mm" viewBox="0 0 300 {shown}" preserveAspectRatio="none"'
    for shown in (200, 100):
        page = PAGE.format(size=size.format(shown=shown), body=body)
        (tmp_path / f"{shown}.svg").write_text(page, encoding="utf-8")
    assert plate(tmp_path, outline={"file": "200.svg"}, mass=0.002).area == pytest.approx(0.06 * 0.02)
    with pytest.raises(DrawingError, match="stretched to its page"):
        plate(tmp_path, outline={"file": "100.svg"}, mass=0.002)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<symbol><rect width="9" height="9"/></symbol>', "a symbol"),
        ('<use href="#a"/>', "a clone"),
        ('<svg:use href="#a"/>', "a clone"),
        ('<image href="a.png"/>', "an image"),
        ("<path d='M0,0 h100 v100'/>", "open outline: nothing goes on at"),
        ("<text>empty</text>", "no closed curve in it"),
        ("<path d='M0,0 h100", "no SVG drawing that can be read"),
    ],
)
def test_svg_that_is_no_outline_is_refused(tmp_path: Path, body: str, words: str) -> None:
    (tmp_path / "a.svg").write_text(PAGE.format(size="", body=body), encoding="utf-8")
    with pytest.raises(DrawingError, match=words):
        plate(tmp_path, outline={"file": "a.svg"})


def test_entities_are_refused_before_they_are_read(tmp_path: Path) -> None:
    bomb = '<!DOCTYPE svg [<!ENTITY a "x"><!ENTITY b "&a;&a;">]>' + PAGE.format(size="", body="&b;")
    (tmp_path / "a.svg").write_text(bomb, encoding="utf-8")
    with pytest.raises(DrawingError, match="document type"):
        plate(tmp_path, outline={"file": "a.svg"})


def test_files_that_are_no_drawing_are_refused_with_the_key(tmp_path: Path) -> None:
    (tmp_path / "text.dxf").write_text("a letter", encoding="utf-8")
    (tmp_path / "bytes.dxf").write_bytes(bytes(range(256)) * 40)
    (tmp_path / "large.svg").write_text(" " * 1_000_001, encoding="utf-8")
    (tmp_path / "picture.png").write_bytes(b"png")
    for file, words in (
        ("text.dxf", "no DXF drawing"),
        ("bytes.dxf", "no DXF drawing"),
        ("large.svg", "allowed at most 1000000"),
        ("picture.png", "a .dxf or .svg file"),
        ("none.dxf", "no such file beside the declaration"),
    ):
        with pytest.raises(DrawingError, match=words) as caught:
            plate(tmp_path, outline={"file": file})
        assert caught.value.key == "plate.outline"


def test_what_cannot_be_an_outline_is_told_with_its_place(tmp_path: Path) -> None:
    dxf(tmp_path / "open.dxf", lambda space: space.add_lwpolyline([(0, 0), (100, 0), (100, 50)]))
    with pytest.raises(DrawingError, match="open outline: nothing goes on") as caught:
        plate(tmp_path, outline={"file": "open.dxf"})
    assert isinstance(caught.value.fault, GeometryError)
    assert caught.value.fault.places == ((0.0, 0.0),)
    assert len(caught.value.curves) == 2
    dxf(tmp_path / "block.dxf", lambda space: space.add_blockref("none", (0, 0)))
    with pytest.raises(DrawingError, match="holds a INSERT, which is not read; break blocks up"):
        plate(tmp_path, outline={"file": "block.dxf"})
    many = [(k, (k % 2) * 10) for k in range(1001)]
    dxf(tmp_path / "many.dxf", lambda space: space.add_lwpolyline(many, close=True))
    with pytest.raises(DrawingError, match="1001 curves; allowed at most 1000"):
        plate(tmp_path, outline={"file": "many.dxf"})
    dxf(tmp_path / "two.dxf", slot)
    with pytest.raises(DrawingError, match="holds 3 closed loops; allowed one here") as caught:
        plate(tmp_path, outline={"file": "two.dxf"}, hole=[{"kind": "drawing", "file": "two.dxf"}])
    assert caught.value.key == "plate.hole[0]"


def test_keys_of_a_drawing_are_checked(tmp_path: Path) -> None:
    for changes, words in (
        ({"unit": "miles"}, "'mm' or 'cm'"),
        ({"tolerance": 1.0}, "to 0.001"),
        ({"scale": 2}, "Extra"),
    ):
        with pytest.raises(DrawingError, match=words) as caught:
            plate(tmp_path, outline={"file": "a.dxf", **changes})
        assert caught.value.key == f"plate.outline.{next(iter(changes))}"


def test_without_the_extra_the_message_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dxf(tmp_path / "slot.dxf", slot)
    monkeypatch.setitem(sys.modules, "ezdxf.filemanagement", None)
    with pytest.raises(DrawingError, match=r"pip install 'flexura\[drawings\]'"):
        plate(tmp_path, outline={"file": "slot.dxf"})


def test_a_declaration_without_drawings_stays_as_it_is(tmp_path: Path) -> None:
    for declared in ({}, {"plate": 3}, {"plate": {"length_x": 0.2}}, {"plate": {"hole": "x", "zone": [1]}}):
        assert with_drawings(tmp_path, declared) == declared


def test_a_drawing_that_ends_in_its_head_is_refused(tmp_path: Path) -> None:
    """The library asks for a next tag where there is none, and passes the end of its iterator on."""
    (tmp_path / "a.dxf").write_text("  0\nSECTION\n  2\nHEADER\n  9\n$ACADVER\n", encoding="utf-8")
    with pytest.raises(DrawingError, match="no DXF drawing that can be read"):
        plate(tmp_path, outline={"file": "a.dxf"})
