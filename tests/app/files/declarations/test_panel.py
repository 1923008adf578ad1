from pathlib import Path

import pytest

from app.commands.bad_input import fault_picture
from app.files.bad_file import ResultFileError
from app.files.declarations.panel import panel_of_text, read_panel

PANEL = """
format = "panel/1"
title = "disc"
[plate]
thickness = 0.003
mass = 0.2
[plate.outline]
kind = "circle"
center = [0.0, 0.0]
radius = 0.15
[[patch]]
id = "A1"
role = "actuator"
center = [0.0, 0.1]
diameter = 0.02
thickness = 0.0005
[target]
center = [0.3, 0.4]
size = [0.1, 0.2]
"""
SQUARE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0 h{width} v200 h-200 z"/></svg>'


def written(folder: Path, old: str = "", new: str = "") -> Path:
    assert old in PANEL
    file = folder / "disc.toml"
    file.write_text(PANEL.replace(old, new, 1) if old else PANEL, encoding="utf-8")
    return file


def test_a_round_panel_and_one_from_a_drawing(tmp_path: Path) -> None:
    assert read_panel(written(tmp_path)).plate.length_x == pytest.approx(0.3)
    (tmp_path / "square.svg").write_text(SQUARE.format(width=200), encoding="utf-8")
    drawn = 'kind = "drawing"\nfile = "square.svg"\nunit = "mm"'
    old = 'kind = "circle"\ncenter = [0.0, 0.0]\nradius = 0.15'
    with pytest.raises(
        ResultFileError, match=r"'A1' spans -0\.01 to 0\.01 m along x; the plate allows 0 to 0\.2"
    ) as told:
        read_panel(written(tmp_path, old, drawn))
    assert told.value.misplaced is not None
    file = written(tmp_path, old, drawn)
    file.write_text(
        file.read_text(encoding="utf-8").replace("center = [0.0, 0.1]", "center = [0.05, -0.1]"), "utf-8"
    )
    panel = read_panel(file)
    assert panel.plate.area == pytest.approx(0.04)
    assert panel_of_text(panel.model_dump_json(), "filters.h5") == panel


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "circle"', 'kind = "disc"', r"plate\.outline\.kind = 'disc'; allowed: 'rectangle' or 'polygon'"),
        ('kind = "circle"\n', "", r"plate\.outline\.kind is missing; allowed: 'rectangle'"),
        (
            "radius = 0.15",
            "radius = -0.15",
            r"plate\.outline\.radius = -0\.15; allowed: a number from 0\.0005 to 5 \(m\)",
        ),
        (
            "radius = 0.15",
            'file = "a.svg"',
            r"plate\.outline\.file is not known; the keys here are kind, center, radius",
        ),
        (
            "radius = 0.15",
            "radius = 150.0",
            r"plate\.outline\.radius = 150\.0; allowed: .* \(m\) \(values are SI: 150 thousandths are 0\.15\)",
        ),
        ("radius = 0.15", "radus = 0.15", r"plate\.outline\.radus is not known; .* \(did you mean radius\?\)"),
        ('kind = "circle"', 'kind = "drawing"', r"plate\.outline\.file: Field required; allowed: a text"),
    ],
)
def test_keys_of_an_outline_are_told_as_they_stand_in_the_file(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    with pytest.raises(ResultFileError, match=said):
        read_panel(written(tmp_path, old, new))


def test_the_picture_is_written_beside_the_declaration_or_where_results_go(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match="reaches over the plate's edge at") as told:
        read_panel(written(tmp_path, "[0.0, 0.1]", "[0.1, 0.105]"))
    wrong = told.value.misplaced
    assert wrong is not None
    ((x, y),) = wrong.places
    assert 0.15 < (x**2 + y**2) ** 0.5 < 0.16
    assert fault_picture(wrong, {}) == f"picture: {tmp_path / 'disc-geometry.png'}"
    there = tmp_path / "results" / "disc-geometry.png"
    assert fault_picture(wrong, {"out": tmp_path / "results" / "run"}) == f"picture: {there}"
    assert there.read_bytes()[1:4] == b"PNG"
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "cannot be written" in fault_picture(wrong, {"out": tmp_path / "file" / "run"})


def test_an_open_drawing_is_told_with_its_place_and_its_curves(tmp_path: Path) -> None:
    (tmp_path / "open.svg").write_text(SQUARE.format(width=200).replace(" z", ""), encoding="utf-8")
    drawn = 'kind = "drawing"\nfile = "open.svg"\nunit = "mm"'
    with pytest.raises(
        ResultFileError, match=r"plate\.outline: open\.svg: open outline: nothing goes on at"
    ) as told:
        read_panel(written(tmp_path, 'kind = "circle"\ncenter = [0.0, 0.0]\nradius = 0.15', drawn))
    assert told.value.misplaced is not None
    assert len(told.value.misplaced.loose) == 3


@pytest.mark.parametrize("other", ["simulated-rig.toml", "pp-plate/campaign.toml"])
def test_a_file_of_another_kind_is_told_as_such_and_not_key_by_key(other: str) -> None:
    with pytest.raises(ResultFileError) as refused:
        read_panel(Path(__file__).parents[4] / "examples" / other)
    assert "allowed: 'panel/1'; flexura new panel writes one" in str(refused.value)
    assert "is not known" not in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
