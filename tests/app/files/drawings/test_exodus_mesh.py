"""Meshes of Exodus II: written as SAND92-2137 says, in classic netCDF and in netCDF-4, and read."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import netcdf_file

from analysis.declaration.plate import ForeignMesh
from app.files.drawings.drawing import mesh_of_file
from simulation.meshing.foreign import foreign_mesh
from simulation.meshing.mesher import mesh_plate
from simulation.meshing.plate_mesh import CURVE_DEGREE
from simulation.shell.shape_functions import lobatto
from simulation.shell.space import ShapeSpace
from tests.app.files.test_mesh_file import DISC, SQUARE

Variables = dict[str, tuple[NDArray[Any], str]]


def texts(names: list[str]) -> NDArray[np.bytes_]:
    return np.array([list(name.ljust(33, "\0")) for name in names], dtype="S1")


def exodus(mesh: Any, *, shells: bool, quadratic: bool = False, named: bool = True, patches: int = 1) -> Variables:
    """Return the variables of a file, each with its type of cell: blocks of plate and patches, rim as side set."""
    edges = np.vstack([mesh.quad_edges, np.column_stack([mesh.triangle_edges, mesh.triangle_edges[:, :1]])])
    corners = [*np.asarray(mesh.quads), *np.asarray(mesh.triangles)]
    middles = mesh.points[mesh.edges].mean(axis=1)
    middles = middles + np.einsum("c,kcd->kd", lobatto(CURVE_DEGREE, 0.0)[0], mesh.bow)
    points = np.vstack([mesh.points, middles]) if quadratic else mesh.points
    inside = {f"PATCH_{k}": np.asarray(mesh.inside[f"patch {k}"]) for k in range(1, patches + 1)}
    made: Variables = {}
    names: list[str] = []
    place: dict[int, int] = {}
    for name, chosen in (("PLATE", ~np.any([*inside.values()], axis=0)), *inside.items()):
        for count in (3, 4):
            cells = [k for k in np.flatnonzero(chosen).tolist() if len(corners[k]) == count]
            if not cells:
                continue
            rows = [[*corners[k], *((len(mesh.points) + edges[k][:count]) if quadratic else ())] for k in cells]
            family = {(3, True): "TRISHELL", (4, True): "SHELL", (3, False): "TRI", (4, False): "QUAD"}
            names.append(name)
            made[f"connect{len(names)}"] = (
                np.array(rows, dtype=np.int32) + 1,
                f"{family[count, shells]}{len(rows[0])}",
            )
            place.update({k: number for number, k in enumerate(cells, len(place))})
    rim, sides = set(np.asarray(mesh.borders["outline"].edge).tolist()), []
    for k, cell in enumerate(corners):
        sides += [(place[k], j + 1) for j in range(len(cell)) if int(edges[k][j]) in rim]
    assert len(sides) == len(rim)
    element, side = np.array(sides, dtype=np.int32).T
    made["elem_ss1"] = (element + 1, "")
    made["side_ss1"] = (side + (2 if shells else 0), "")
    made["eb_prop1"] = (np.array([10 + k for k in range(len(names))], dtype=np.int32), "")
    made["ss_prop1"] = (np.array([4], dtype=np.int32), "")
    if named:
        made["eb_names"] = (texts(names), "")
        made["ss_names"] = (texts(["outline"]), "")
    if shells:
        points = np.column_stack([points, np.full(len(points), 0.2)])
    for axis, column in zip("xyz", points.T, strict=False):
        made[f"coord{axis}"] = (np.ascontiguousarray(column), "")
    return made


def written(path: Path, made: Variables, *, classic: bool) -> Path:
    if classic:
        with netcdf_file(path, "w", version=2) as file:
            for name, (values, kind) in made.items():
                dimensions = [f"{name}_{k}" for k in range(values.ndim)]
                for dimension, size in zip(dimensions, values.shape, strict=True):
                    file.createDimension(dimension, size)
                variable = file.createVariable(name, values.dtype.str.replace("S1", "c"), dimensions)
                variable[:] = values
                if kind:
                    variable.elem_type = kind
        return path
    with h5py.File(path, "w") as file:
        for name, (values, kind) in made.items():
            file[name] = values
            if kind:
                file[name].attrs["elem_type"] = kind
    return path


@pytest.mark.parametrize(
    ("ending", "classic", "shells"),
    [(".e", True, True), (".exo", False, True), (".ex2", True, False), (".g", False, False)],
)
def test_blocks_and_side_sets_are_patches_and_the_outline(
    tmp_path: Path, ending: str, classic: bool, shells: bool
) -> None:
    mesh = mesh_plate(SQUARE, 0.003)
    path = written(tmp_path / f"a{ending}", exodus(mesh, shells=shells), classic=classic)
    numbers = mesh_of_file(path, 1.0, {})
    assert set(numbers["surface"]) == {"plate", "patch 1"}
    assert len(numbers["curve"]["outline"]) == len(mesh.borders["outline"].edge)
    read = foreign_mesh(ForeignMesh.model_validate(numbers), SQUARE)
    assert (len(read.quads), len(read.triangles)) == (len(mesh.quads), len(mesh.triangles))
    space = ShapeSpace.on(read, 2)
    assert space.dx.sum() == pytest.approx(0.01 - 4e-4)
    assert space.dx[space.spread(read.inside["patch 1"])].sum() == pytest.approx(4e-4)


def test_blocks_without_names_are_named_by_the_declaration(tmp_path: Path) -> None:
    mesh = mesh_plate(SQUARE, 0.003)
    made = exodus(mesh, shells=False, named=False)
    inside = np.asarray(mesh.inside["patch 1"])
    mixed = bool(inside[: len(mesh.quads)].any() and inside[len(mesh.quads) :].any())
    last = 10 + sum(name.startswith("connect") for name in made) - 1
    names = {str(number): "patch 1" for number in ((last - 1, last) if mixed else (last,))}
    path = written(tmp_path / "a.exo", made, classic=False)
    read = foreign_mesh(ForeignMesh.model_validate(mesh_of_file(path, 1.0, names | {"side 4": "outline"})), SQUARE)
    assert np.asarray(read.inside["patch 1"]).sum() == inside.sum()


def test_quadratic_cells_follow_a_circle(tmp_path: Path) -> None:
    mesh = mesh_plate(DISC, 0.003)
    path = written(tmp_path / "a.e", exodus(mesh, shells=True, quadratic=True), classic=True)
    read = foreign_mesh(ForeignMesh.model_validate(mesh_of_file(path, 1.0, {})), DISC, tolerance=0.01)
    assert abs(ShapeSpace.on(read, 2).dx.sum() / (np.pi * 0.01) - 1.0) < 1e-3


def damaged(made: Variables, name: str, values: NDArray[Any], kind: str = "") -> Variables:
    return {**made, name: (values, kind)}


def test_what_cannot_be_taken_is_said(tmp_path: Path) -> None:
    made = exodus(mesh_plate(SQUARE, 0.003), shells=False)
    solid = damaged(made, "connect1", np.arange(1, 9, dtype=np.int32)[None], "HEX8")
    beyond = damaged(made, "connect1", np.array([[1, 2, 30000]], dtype=np.int32), "TRI3")
    sides = damaged(made, "elem_ss1", np.full(len(made["elem_ss1"][0]), 10**6, dtype=np.int32))
    none = {name: one for name, one in made.items() if not name.startswith("connect")}
    for name, content, said in (
        ("solid.e", solid, "cells of type HEX8 make no plate"),
        ("beyond.e", beyond, "cells of block 1 name points beyond"),
        ("sides.e", sides, "side set 4 names cells beyond"),
        ("none.e", none, r"no Exodus mesh that can be read \(it has no blocks of cells"),
    ):
        with pytest.raises(ValueError, match=said):
            mesh_of_file(written(tmp_path / name, content, classic=False), 1.0, {})
    for head, said in ((b"CDF\x05", "CDF-5"), (b"none", "it is no netCDF file")):
        (tmp_path / "a.exo").write_bytes(head + bytes(100))
        with pytest.raises(ValueError, match=said):
            mesh_of_file(tmp_path / "a.exo", 1.0, {})
