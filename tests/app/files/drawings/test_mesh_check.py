"""A mesh that does not fit is refused when the declaration is read, with its place and a picture."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from pydantic import BaseModel

from analysis.declaration.plate import Plate
from analysis.declaration.transducers import Patch
from analysis.geometry.loop import GeometryError
from app.commands.bad_input import fault_picture
from app.files.campaign_error import CampaignFileError
from app.files.drawings.drawing import mesh_fault
from app.files.settings_toml import checked
from app.report.declared import pieces_declared

SQUARES = [(x, y) for y in (0.0, 0.1, 0.2) for x in (0.0, 0.1, 0.2, 0.3)]
"""Two rows of three cells."""


class Declaration(BaseModel):
    plate: Plate
    patch: tuple[Patch, ...] = ()


def table(points: list[tuple[float, float]], turned: tuple[int, ...] = ()) -> dict[str, Any]:
    quads = [[k, k + 1, k + 5, k + 4] for k in (0, 1, 2, 4, 5, 6)]
    quads = [quad[::-1] if k in turned else quad for k, quad in enumerate(quads)]
    mesh = {"points": [list(point) for point in points], "quads": quads}
    return {"plate": {"length_x": 0.3, "length_y": 0.2, "thickness": 0.003, "mass": 0.17, "mesh": mesh}}


@pytest.mark.parametrize("turned", [(), (0, 4), (0, 1, 2, 3, 4, 5)])
def test_surfaces_with_their_normals_up_and_down_are_taken(tmp_path: Path, turned: tuple[int, ...]) -> None:
    """Gmsh turns the cells of a surface whose curves were named clockwise."""
    checked(tmp_path / "a.toml", table(SQUARES, turned), Declaration)


def test_an_inverted_cell_is_refused_with_its_place_and_a_picture(tmp_path: Path) -> None:
    """A point moved beyond the next one: the cells between lie over their neighbours."""
    points = [*SQUARES]
    points[5] = (0.29, 0.1)
    path = tmp_path / "a.toml"
    with pytest.raises(
        CampaignFileError, match=r"plate\.mesh: .* at \(0\.\d+, 0\.\d+\) m is turned over"
    ) as caught:
        checked(path, table(points), Declaration)
    wrong = caught.value.misplaced
    assert wrong is not None
    assert 0.1 < wrong.places[0][0] < 0.3
    assert len(pieces_declared(wrong).mesh) == 17
    assert fault_picture(wrong, {}).endswith("a-geometry.png")
    assert (tmp_path / "a-geometry.png").stat().st_size > 1000


def test_a_patch_without_its_surface_is_refused(tmp_path: Path) -> None:
    declared = table(SQUARES)
    patch = {"id": "A1", "role": "actuator", "center": [0.15, 0.1], "size": [0.02, 0.02], "thickness": 5e-4}
    declared["patch"] = [patch]
    with pytest.raises(CampaignFileError, match="physical surface 'patch 1' is missing"):
        checked(tmp_path / "a.toml", json.loads(json.dumps(declared)), Declaration)


@pytest.mark.parametrize(
    ("centers", "words", "place"),
    [
        (((0.01, 0.05), (0.2, 0.1)), "outline and patch 'A1': two borders touch without crossing", (0.0, 0.05)),
        (((0.05, 0.05), (0.07, 0.05)), "patch 'A1' and patch 'B': two borders touch", (0.06, 0.05)),
    ],
)
def test_borders_that_only_touch_are_refused_when_they_are_declared(
    tmp_path: Path, centers: tuple[tuple[float, float], ...], words: str, place: tuple[float, float]
) -> None:
    """They were found when the twin was built, after the campaign."""
    patches = [
        {"id": name, "role": "sensor", "center": list(center), "diameter": 0.02, "thickness": 5e-4, "side": side}
        for name, center, side in zip(("A1", "B"), centers, ("top", "bottom"), strict=True)
    ]
    plate = {"length_x": 0.3, "length_y": 0.2, "thickness": 0.003, "mass": 0.17}
    with pytest.raises(CampaignFileError, match=words) as caught:
        checked(tmp_path / "a.toml", {"plate": plate, "patch": patches}, Declaration)
    assert caught.value.misplaced is not None
    assert caught.value.misplaced.places[0] == pytest.approx(place, abs=1e-6)


def test_a_plate_of_too_many_waves_is_refused_with_the_band_that_fits(tmp_path: Path) -> None:
    sheet = Plate(length_x=5.0, length_y=4.0, thickness=0.003, mass=57.0)
    fault = mesh_fault(
        tmp_path / "a.toml", {}, SimpleNamespace(plate=sheet, sweep=SimpleNamespace(band=(50.0, 1500.0)))
    )
    assert fault is not None
    assert "5 by 4 m are 85 by 68 of the shortest bending wavelengths" in fault[1]
    highest = float(fault[1].split("End the band at ")[1].split(" Hz")[0])
    lower = SimpleNamespace(plate=sheet, sweep=SimpleNamespace(band=(50.0, 0.95 * highest)))
    assert mesh_fault(tmp_path / "a.toml", {}, lower) is None


def test_a_declaration_is_meshed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Until the plate or the band changes; a fault is found every time."""
    monkeypatch.setenv("FLEXURA_CACHE", str(tmp_path / "cache"))
    meshed: list[float] = []

    def mesh_of(plate: Plate, *rest: object) -> None:
        meshed.append(plate.length_x)
        if plate.length_x == 0.25:
            raise GeometryError("no mesh")

    monkeypatch.setattr("simulation.shell.shell_plate.mesh_of", mesh_of)
    sides, bands = [0.24, 0.24, 0.24, 0.23, 0.25, 0.25], [1500.0, 1500.0, 1400.0, 1500.0, 1500.0, 1500.0]
    for side, high in zip(sides, bands, strict=True):
        plate = Plate(length_x=side, length_y=0.19, thickness=0.003, mass=0.12)
        declared = SimpleNamespace(plate=plate, sweep=SimpleNamespace(band=(100.0, high)))
        assert (mesh_fault(tmp_path / "a.toml", {}, declared) is None) == (side != 0.25)
    assert meshed == [0.24, 0.24, 0.23, 0.25, 0.25]
