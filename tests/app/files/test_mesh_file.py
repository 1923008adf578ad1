"""Meshes of our own, written in Gmsh's format by hand and in others by meshio, and read."""

import numpy as np
import pytest

from analysis.declaration.plate import ForeignMesh, Plate
from analysis.declaration.transducers import Patch
from analysis.geometry import loop
from analysis.geometry.loop import GeometryError
from app.files.drawings.drawing import DrawingError, mesh_of_file, with_drawings
from simulation.meshing.foreign import foreign_mesh as mesh_of
from simulation.meshing.mesher import Border, mesh_plate
from simulation.meshing.plate_mesh import CURVE_DEGREE
from simulation.shell.assembly import assemble
from simulation.shell.shape_functions import lobatto
from simulation.shell.space import ShapeSpace

SQUARE = [
    Border("outline", loop.rectangle((0.05, 0.05), (0.1, 0.1)), "outline"),
    Border("hole 1", loop.rectangle((0.07, 0.07), (0.02, 0.02)), "hole"),
    Border("patch 1", loop.rectangle((0.03, 0.03), (0.02, 0.02), 0.3)),
]
DISC = [
    Border("outline", loop.circle((0.0, 0.0), 0.1), "outline"),
    Border("patch 1", loop.circle((0, 0), 0.02)),
]
TYPES = {(3, False): 2, (4, False): 3, (3, True): 9, (4, True): 16}


def foreign_mesh(path, borders, *, unit=1.0, **how):
    return mesh_of(ForeignMesh.model_validate(mesh_of_file(path, unit, {})), borders, **how)


def written(
    path, mesh, *, quadratic=False, groups=None, curves=("outline",), scale=1.0, mirrored=False, twice=False
):
    """Write a mesh as Gmsh's format 2.2, in a unit of `scale` m; return the path."""
    groups = groups or {"patch 1": mesh.inside["patch 1"]}
    names = {"plate": (2, 1)} | {name: (2, k) for k, name in enumerate(groups, start=2)}
    names |= {name: (1, k) for k, name in enumerate(curves, start=50)}
    middles = mesh.points[mesh.edges].mean(axis=1) + np.einsum(
        "c,kcd->kd", lobatto(CURVE_DEGREE, 0.0)[0], mesh.bow
    )
    points = np.vstack([mesh.points, middles])[:, :] / scale
    rows = []
    every = [
        *zip(mesh.quads, mesh.quad_edges, strict=True),
        *zip(mesh.triangles, mesh.triangle_edges, strict=True),
    ]
    for k, (corners, edges) in enumerate(every):
        below = (mirrored == "patch" and mesh.inside["patch 1"][k]) or mirrored is True
        corners, edges = (corners[::-1], np.roll(edges[::-1], -1)) if below else (corners, edges)
        nodes = [*corners, *(len(mesh.points) + edges)] if quadratic else [*corners]
        tags = [names[name][1] for name, cells in groups.items() if cells[k]] or [1]
        if twice and tags != [1]:
            tags.append(1)
        rows += [(TYPES[len(corners), quadratic], tag, nodes) for tag in tags]
    for name in curves:
        rows += [(1, names[name][1], list(mesh.edges[edge])) for edge in mesh.borders[name].edge]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
    lines += [f'{dimension} {tag} "{name}"' for name, (dimension, tag) in names.items()]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{k} {float(x)!r} {float(y)!r} 0" for k, (x, y) in enumerate(points, start=1)]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    for k, (kind, tag, nodes) in enumerate(rows, start=1):
        lines.append(f"{k} {kind} 2 {tag} {tag} " + " ".join(str(node + 1) for node in nodes))
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return path


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"scale": 1e-3},
        {"mirrored": True},
        {"quadratic": True},
        {"twice": True},
        {"mirrored": True, "quadratic": True},
        {"mirrored": "patch", "quadratic": True},
    ],
)
def test_a_mesh_comes_back_as_it_was(tmp_path, how):
    mesh = mesh_plate(SQUARE, 0.003)
    read = foreign_mesh(written(tmp_path / "a.msh", mesh, **how), SQUARE, unit=how.get("scale", 1.0))
    assert (len(read.quads), len(read.triangles)) == (len(mesh.quads), len(mesh.triangles))
    assert np.sort(read.points, axis=0) == pytest.approx(np.sort(mesh.points, axis=0))
    space = ShapeSpace.on(read, 2)
    assert space.dx.sum() == pytest.approx(0.01 - 4e-4)
    assert space.dx[space.spread(read.inside["patch 1"])].sum() == pytest.approx(4e-4)
    for border in SQUARE:
        own, before = read.borders[border.name], mesh.borders[border.name]
        assert len(own.edge) == len(before.edge)
        assert np.bincount(own.curve) == pytest.approx(np.bincount(before.curve))
        ends = read.points[read.edges[own.edge]]
        at = np.array([border.loop.curves[c].at(t) for c, t in zip(own.curve, own.span, strict=True)])
        assert at == pytest.approx(ends, abs=1e-9)


def test_quadratic_edges_follow_a_circle_better_than_straight_ones(tmp_path):
    mesh = mesh_plate(DISC, 0.003)
    misses = []
    for quadratic in (False, True):
        read = foreign_mesh(written(tmp_path / "d.msh", mesh, quadratic=quadratic), DISC, tolerance=0.01)
        misses.append(abs(ShapeSpace.on(read, 2).dx.sum() / (np.pi * 0.01) - 1.0))
    assert misses[0] > 1e-2
    assert misses[1] < 1e-3


def test_points_need_not_be_where_the_declared_curves_meet(tmp_path):
    """A circle is declared as four arcs, of which Gmsh knows nothing: here the mesh is turned by 0.2 rad."""
    mesh, turned = mesh_plate(DISC, 0.003), []
    for border, radius in zip(DISC, (0.1, 0.02), strict=True):
        turned.append(Border(border.name, loop.ellipse((0.0, 0.0), (radius, radius), 0.2), border.kind))
    read = foreign_mesh(written(tmp_path / "d.msh", mesh, quadratic=True), turned, tolerance=0.01)
    for border in turned:
        own = read.borders[border.name]
        assert len(own.edge) == len(mesh.borders[border.name].edge)
        inside = own.span.mean(axis=1)
        assert ((inside > 0.0) & (inside < 1.0)).all()  # supports of a whole curve hold its edges


def test_a_chord_away_from_the_declared_edge_is_refused_with_its_place(tmp_path):
    with pytest.raises(GeometryError, match=r"away from the edge of the plate; allowed 0\.1 mm") as caught:
        foreign_mesh(written(tmp_path / "d.msh", mesh_plate(DISC, 0.003)), DISC)
    assert 0.085 < np.hypot(*caught.value.places[0]) < 0.0999


def test_groups_that_are_unknown_or_missing_are_named(tmp_path):
    mesh = mesh_plate(SQUARE, 0.003)
    inside = mesh.inside["patch 1"]
    with pytest.raises(ValueError, match="physical surface 'Patch1' is unknown; this plate has plate, patch 1"):
        foreign_mesh(written(tmp_path / "a.msh", mesh, groups={"Patch1": inside}), SQUARE)
    with pytest.raises(ValueError, match="physical surface 'patch 1' is missing; the mesh has plate"):
        foreign_mesh(written(tmp_path / "a.msh", mesh, groups={"patch 1": np.zeros_like(inside)}), SQUARE)
    mesh.borders["rim"] = mesh.borders["outline"]
    with pytest.raises(ValueError, match="physical curve 'rim' is unknown"):
        foreign_mesh(written(tmp_path / "a.msh", mesh, curves=("rim",)), SQUARE)


def test_a_patch_and_a_curve_in_the_wrong_place_are_refused(tmp_path):
    mesh = mesh_plate(SQUARE, 0.003)
    other = mesh.inside["patch 1"].copy()
    other[np.flatnonzero(other)[0]] = False
    with pytest.raises(GeometryError, match="physical surface 'patch 1' ends at"):
        foreign_mesh(written(tmp_path / "a.msh", mesh, groups={"patch 1": other}), SQUARE)
    mesh.borders["outline"], mesh.borders["hole 1"] = mesh.borders["hole 1"], mesh.borders["outline"]
    with pytest.raises(GeometryError, match="physical curve 'outline' leaves its border"):
        foreign_mesh(written(tmp_path / "a.msh", mesh), SQUARE)


def test_cells_turned_over_are_refused_with_their_place(tmp_path):
    mesh = mesh_plate(SQUARE, 0.003)
    number = mesh.triangles[0, 0]
    corner = mesh.points[number].copy()
    mesh.points[number] = mesh.points[mesh.triangles[0, 1:]].mean(axis=0) * 2.0 - corner
    with pytest.raises(GeometryError, match="turned over") as caught:
        foreign_mesh(written(tmp_path / "a.msh", mesh), SQUARE)
    assert np.hypot(*(np.array(caught.value.places[0]) - corner)) < 0.03


def test_a_bent_edge_that_turns_a_cell_over_is_refused(tmp_path):
    mesh = mesh_plate(SQUARE, 0.003)
    users = np.bincount(mesh.triangle_edges.ravel(), minlength=len(mesh.edges))
    edge = np.flatnonzero(users == 2)[0]
    a, b = mesh.points[mesh.edges[edge]]
    mesh.bow[edge, 0] = 2.0 * np.array([a[1] - b[1], b[0] - a[0]])
    with pytest.raises(GeometryError, match="is turned over, or nearly so"):
        foreign_mesh(written(tmp_path / "a.msh", mesh, quadratic=True), SQUARE)


def test_what_is_no_mesh_is_refused(tmp_path):
    path = tmp_path / "a.msh"
    path.write_text("no mesh\n")
    with pytest.raises(ValueError, match="no Gmsh mesh that can be read"):
        foreign_mesh(path, SQUARE)


@pytest.mark.parametrize(
    "text",
    [
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Elements\n0\n$EndElements\n",
        '$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 "plate"\n$Nodes\n1\n1 0 0 0\n$EndNodes\n',
    ],
    ids=["no nodes", "names without an end"],
)
def test_a_mesh_without_points_is_refused(tmp_path, text):
    """The library meets the first with TypeError, and reads nothing out of the second."""
    (tmp_path / "a.msh").write_text(text)
    with pytest.raises(ValueError, match="no Gmsh mesh that can be read"):
        foreign_mesh(tmp_path / "a.msh", SQUARE)


def test_a_mesh_that_asks_for_too_much_memory_is_refused(tmp_path):
    """The library sets memory aside for the largest number of a point: here 16 GB."""
    path = written(tmp_path / "a.msh", mesh_plate(SQUARE, 0.003))
    text = path.read_text()
    count = text.split("$Nodes\n")[1].split("\n", 1)[0]
    path.write_text(text.replace(f"\n{count} ", "\n2000000000 ", 1))
    with pytest.raises(ValueError, match=r"more than 1\.5 GB of memory"):
        foreign_mesh(path, SQUARE)


def declared(folder, **mesh):
    plate = {
        "outline": {"kind": "rectangle", "center": (0.05, 0.05), "size": (0.1, 0.1)},
        "hole": [{"kind": "rectangle", "center": (0.07, 0.07), "size": (0.02, 0.02)}],
        "thickness": 0.003,
        "mass": 0.03,
        "mesh": mesh,
    }
    patch = {"id": "A1", "role": "actuator", "center": (0.03, 0.03), "size": (0.02, 0.02)}
    patch |= {"thickness": 5e-4, "angle": float(np.rad2deg(0.3))}
    return with_drawings(folder, {"plate": plate, "patch": [patch]})


def test_a_declared_file_gives_the_answers_of_the_same_mesh_made_here(tmp_path):
    mesh = mesh_plate(SQUARE, 0.003)
    written(tmp_path / "a.msh", mesh, scale=1e-3, groups={"A1": mesh.inside["patch 1"]})
    table = declared(tmp_path, file="a.msh", unit="mm")
    assert "a.msh" not in repr(table)  # the declaration needs no other file
    patches = [Patch.model_validate(item) for item in table["patch"]]
    plate = Plate.model_validate(table["plate"])
    assert Plate.model_validate_json(plate.model_dump_json(), strict=True) == plate
    own = plate.model_copy(update={"mesh": None})
    found = [assemble(one, patches, degree=3).compliance(2e9, 0.37, 0.05, [200.0, 700.0]) for one in (plate, own)]
    assert found[0] == pytest.approx(found[1], rel=1e-7)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ({"file": "none.msh"}, "no such file"),
        ({"file": "bad.msh"}, "no Gmsh mesh that can be read"),
        ({"file": "bad.msh", "unit": "km"}, "allowed: 'mm' or 'cm'"),
        ({"file": "bad.msh", "scale": 2.0}, "Extra inputs are not permitted"),
    ],
)
def test_a_file_that_cannot_be_taken_is_named_with_its_key(tmp_path, mesh, message):
    (tmp_path / "bad.msh").write_text("no mesh\n")
    with pytest.raises(DrawingError, match=message) as caught:
        declared(tmp_path, **mesh)
    assert caught.value.key.startswith("plate.mesh")


def test_a_support_ends_at_a_point_of_the_mesh(tmp_path):
    path = written(tmp_path / "a.msh", mesh_plate(SQUARE, 0.003))
    corner, beside = (0.1, 0.0), (0.0123, 0.0)
    foreign_mesh(path, SQUARE, cuts=[corner])
    with pytest.raises(GeometryError, match=r"no point at .*, where a support begins or ends"):
        foreign_mesh(path, SQUARE, cuts=[corner, beside])


@pytest.mark.parametrize(
    "surfaces",
    ["1 0 0 0 1 1 0 1 1 0\n2 1 0 0 2 1 0 2 1 2 0", "1 0 0 0 1 1 0 1 1 2 7 -8\n2 1 0 0 2 1 0 2 1 2 1 9"],
    ids=["alone", "with the curves around them, as Gmsh writes them"],
)
def test_format_4_keeps_all_groups_of_a_cell(tmp_path, surfaces):
    """A patch inside a thickness zone: its cells belong to two physical surfaces."""
    places = ["0 0 0", "1 0 0", "2 0 0", "0 1 0", "1 1 0", "2 1 0"]
    parts = [
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat",
        '$PhysicalNames\n2\n2 1 "zone 1"\n2 2 "patch 1"\n$EndPhysicalNames',
        f"$Entities\n0 0 2 0\n{surfaces}\n$EndEntities",
        "$Nodes\n1 6 1 6\n2 1 0 6\n1\n2\n3\n4\n5\n6\n" + "\n".join(places) + "\n$EndNodes",
        "$Elements\n2 2 1 2\n2 1 3 1\n1 1 2 5 4\n2 2 3 1\n2 2 3 6 5\n$EndElements",
    ]
    (tmp_path / "a.msh").write_text("\n".join(parts) + "\n")
    assert mesh_of_file(tmp_path / "a.msh", 1.0, {})["surface"] == {"zone 1": [0, 1], "patch 1": [1]}


def test_a_mesh_over_a_declared_hole_is_refused(tmp_path):
    whole = mesh_plate([SQUARE[0], SQUARE[2]], 0.003)
    with pytest.raises(GeometryError, match="the mesh follows 0% of 'hole 1'"):
        foreign_mesh(written(tmp_path / "a.msh", whole), SQUARE)


def as_others_have_it(mesh, *, quadratic=False):
    """Return the same mesh as meshio has it: sets of cells by name, a number of a property for each cell."""
    import meshio

    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    inside = mesh.inside["patch 1"]
    quads, triangles = np.asarray(mesh.quads), np.asarray(mesh.triangles)
    blocks = [("quad", quads)] if len(quads) else []
    blocks += [("triangle", triangles)] if len(triangles) else []
    parts = np.split(inside, [len(quads)]) if len(quads) and len(triangles) else [inside]
    rim = np.array([mesh.edges[edge] for edge in mesh.borders["outline"].edge])
    return meshio.Mesh(
        points,
        [*blocks, ("line", rim)],
        cell_sets={
            "PATCH_1": [*(np.flatnonzero(one) for one in parts), np.array([], dtype=int)],
            "OUTLINE": [*(np.array([], dtype=int) for _ in parts), np.arange(len(rim))],
            "SET-7": [np.arange(2), *(np.array([], dtype=int) for _ in parts[1:]), np.array([], dtype=int)],
        },
        cell_data={"property": [*(np.where(one, 12, 11) for one in parts), np.full(len(rim), 13)]},
    )


@pytest.mark.parametrize("ending", [".inp", ".bdf", ".vtk", ".vtu"])
def test_meshes_of_other_programs(tmp_path, ending):
    """Sets of Abaqus by their names, in any case; of the others by the numbers that the declaration names."""
    from meshio import abaqus, nastran, vtk, vtu

    mesh = mesh_plate(SQUARE, 0.003)
    path, theirs = tmp_path / f"a{ending}", as_others_have_it(mesh)
    if ending == ".bdf":
        theirs.cell_data = {"nastran:ref": theirs.cell_data["property"]}
    writers = {".inp": abaqus.write, ".bdf": nastran.write, ".vtk": vtk.write, ".vtu": vtu.write}
    if ending != ".inp":
        theirs.cell_sets = {}
    writers[ending](path, theirs)
    if ending == ".inp":  # meshio writes a set once for each type of cell, Abaqus once
        head, *sets = path.read_text().split("*ELSET, ELSET=")
        joined: dict[str, str] = {}
        for name, numbers in (one.split("\n", 1) for one in sets):
            joined[name] = joined.get(name, "") + numbers.rstrip(",\n") + ",\n"
        path.write_text(head + "".join(f"*ELSET, ELSET={name}\n{numbers}" for name, numbers in joined.items()))
    names = {} if ending == ".inp" else {"12": "patch 1", "13": "outline"}
    read = mesh_of(ForeignMesh.model_validate(mesh_of_file(path, 1.0, names)), SQUARE)
    assert (len(read.quads), len(read.triangles)) == (len(mesh.quads), len(mesh.triangles))
    space = ShapeSpace.on(read, 2)
    assert space.dx.sum() == pytest.approx(0.01 - 4e-4, rel=1e-6)
    assert space.dx[space.spread(read.inside["patch 1"])].sum() == pytest.approx(4e-4, rel=1e-5)


def test_other_endings_and_damaged_files_are_said(tmp_path):
    for name, content, said in (
        ("a.med", "x", "ending '.med' is none of a mesh; allowed: .msh, .inp, .bdf"),
        ("a.inp", "*NODE\n1, 0.0, x\n", "no Abaqus mesh that can be read"),
        ("b.inp", "*Include, input=/etc/passwd\n", "other files are not read"),
        ("c.inp", "*ELSET, ELSET=a\n1\n*Elset, elset=A\n2\n", "A stands in several parts"),
        ("a.vtu", "<VTKFile", "no VTK mesh that can be read"),
        ("a.bdf", "GRID,1,,0.0", "no Nastran mesh that can be read"),
    ):
        (tmp_path / name).write_text(content)
        with pytest.raises(ValueError, match=said):
            mesh_of_file(tmp_path / name, 1.0, {})
