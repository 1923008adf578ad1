"""A faultless drawing and mesh of every format, each beside the declaration of a panel that names it."""

from pathlib import Path
from typing import Any

import numpy as np

from app.files.settings_toml import toml_text
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.shell_plate import ShellPlate
from tests.app.files.drawings.test_exodus_mesh import exodus
from tests.app.files.drawings.test_exodus_mesh import written as exodus_file
from tests.app.files.test_mesh_file import written
from tests.app.view.test_gap_and_fields import PANEL
from tests.fuzz.measurement_readers import DRAWINGS, MESHES

SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="400mm" height="300mm" viewBox="0 0 400 300">
<g transform="translate(1 1) rotate(0.1)"><title>plate</title>
<path d="M 20 0 L 380 0 A 20 20 0 0 1 400 20 V 280
Q 400 300 380 300 H 20 C 9 300 0 291 0 280 L 0 20 a 20 20 0 0 1 20 -20 z"/>
<circle cx="200" cy="220" r="8"/><rect x="190" y="60" width="20" height="12" rx="3"/></g>
</svg>
"""


def write_geometry(folder: Path) -> None:
    """Write drawings of a plate of 400 by 300 mm, and meshes of the rectangle, in one folder."""
    folder.mkdir()
    splines, lines, svg = (folder.parent / name for name in DRAWINGS)
    _write_dxf(splines)
    _write_plain_dxf(lines)
    svg.write_text(SVG, encoding="utf-8")
    for path in (splines, lines, svg):
        _declare(path, {"outline": {"kind": "drawing", "file": path.name, "unit": "mm"}})
    _write_meshes(*(folder.parent / name for name in MESHES))


def _declare(drawn: Path, shape: dict[str, Any]) -> None:
    """Write the panel whose plate has this shape."""
    table = PANEL.model_dump(mode="json", exclude_defaults=True)
    plate = {"thickness": PANEL.plate.thickness, "mass": PANEL.plate.mass, **shape}
    drawn.with_suffix(".toml").write_text(toml_text(table | {"plate": plate}), encoding="utf-8")


def _write_dxf(path: Path) -> None:
    """Write a spline, a polyline with bulges, an ellipse and a text, with all that the library puts about them."""
    from ezdxf.filemanagement import new

    document = new()
    document.units = 4
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (400, 0, 0, 0, 0.1), (400, 300)])
    space.add_open_spline([(400, 300), (300, 310), (100, 290), (0, 300)])
    space.add_line((0, 300), (0, 0))
    space.add_ellipse((200, 80), (0, 8), 0.5)
    space.add_text("plate")
    document.saveas(path)


def _write_plain_dxf(path: Path) -> None:
    """Write lines, arcs and a circle with nothing about them."""
    from ezdxf.addons import r12writer

    with r12writer(path) as file:
        file.add_line((0, 0), (400, 0))
        file.add_line((400, 0), (400, 290))
        file.add_arc((390, 290), 10, 0, 90)
        file.add_line((390, 300), (0, 300))
        file.add_polyline_2d([(0, 300), (0, 200), (0, 0)])
        file.add_circle((200, 80), 9)


def _write_meshes(ascii_file: Path, binary: Path, entities: Path, blocks: Path) -> None:
    """Write one mesh as Gmsh's format 2.2, in text and in bytes, as format 4.1, and in Exodus' blocks."""
    import meshio

    coarse = MeshRecipe(spacing=0.3, strip=10.0, grading=0.0, pieces=1)
    mesh = ShellPlate.of(PANEL.plate, PANEL.patch, recipe=coarse, degree=1).space.mesh
    groups = {f"patch {k + 1}": mesh.inside[f"patch {k + 1}"] for k in range(len(PANEL.patch))}
    written(ascii_file, mesh, groups=groups, quadratic=True)
    read = meshio.gmsh.read(ascii_file)
    meshio.gmsh.write(binary, read, "2.2", binary=True)
    _write_entities(entities, read)
    exodus_file(blocks, exodus(mesh, shells=False, patches=len(PANEL.patch)), classic=True)
    size = {"length_x": PANEL.plate.length_x, "length_y": PANEL.plate.length_y}
    for path in (ascii_file, binary, entities, blocks):
        _declare(path, size | {"mesh": {"file": path.name}})


def _write_entities(path: Path, read: Any) -> None:
    """Write format 4.1, in which cells have their group through the entity they belong to."""
    blocks = [
        (block.type, int(tag), block.data[tags == tag])
        for block, tags in zip(read.cells, read.cell_data["gmsh:physical"], strict=True)
        for tag in np.unique(tags)
    ]
    kinds = {"line": (1, 1), "quad": (2, 3), "triangle": (2, 2), "quad9": (2, 10), "triangle6": (2, 9)}
    kinds |= {"line3": (1, 8), "quad8": (2, 16)}
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(read.field_data))]
    lines += [f'{dimension} {tag} "{name}"' for name, (tag, dimension) in read.field_data.items()]
    entities = {d: sorted({tag for kind, tag, _ in blocks if kinds[kind][0] == d}) for d in (1, 2)}
    lines += ["$EndPhysicalNames", "$Entities", f"0 {len(entities[1])} {len(entities[2])} 0"]
    lines += [f"{tag} 0 0 0 1 1 0 1 {tag} 0" for d in (1, 2) for tag in entities[d]]
    count = len(read.points)
    lines += ["$EndEntities", "$Nodes", f"1 {count} 1 {count}", f"2 {entities[2][0]} 0 {count}"]
    lines += [str(n + 1) for n in range(count)]
    lines += [" ".join(repr(float(x)) for x in point) for point in read.points]
    total = sum(len(data) for *_, data in blocks)
    lines += ["$EndNodes", "$Elements", f"{len(blocks)} {total} 1 {total}"]
    number = 0
    for kind, tag, data in blocks:
        lines.append(f"{kinds[kind][0]} {tag} {kinds[kind][1]} {len(data)}")
        for row in data.tolist():
            number += 1
            lines.append(" ".join(str(n) for n in (number, *(one + 1 for one in row))))
    path.write_text("\n".join([*lines, "$EndElements", ""]), encoding="utf-8")
