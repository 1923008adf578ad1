"""Drawings and meshes named in a declaration, turned into what they hold: it then needs no other file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Field, ValidationError

from analysis.declared import Declared, FileName
from analysis.geometry.chain import closed_loops
from analysis.geometry.curves import Curve, moved
from analysis.geometry.fault import GeometryError
from analysis.geometry.loop import Loop
from analysis.outline import MOST_POINTS, row_of
from app.files.allowed_values import allowed_at
from app.files.mesh_file import METRES, MeshFile, mesh_of_file

LARGEST = {".dxf": 5_000_000, ".svg": 1_000_000}
"""Bytes of a drawing: outlines are a page of numbers, which DXF wraps in much else."""
NEEDS = "reading drawings needs the extra drawings: pip install 'flexura[drawings]'"

Kind = TypeVar("Kind", bound=Declared)


class Drawing(Declared):
    """An outline in a file: ``kind = "drawing"``."""

    kind: Literal["drawing"]
    file: Annotated[FileName, Field(min_length=5, description="a .dxf or .svg file")]
    unit: Annotated[Literal["mm", "cm", "m", "in"] | None, Field(description="default: the file's, else mm")] = (
        None
    )
    tolerance: Annotated[float, Field(ge=0.0, le=1e-3, description="m, gaps that are closed")] = 1e-5
    layer: Annotated[str | None, Field(max_length=255, description="of a DXF file; default: all")] = None


class DrawingError(ValueError):
    """A drawing, or a mesh, cannot be taken.

    Attributes
    ----------
    key : str
        Where the declaration names it.
    fault : GeometryError, optional
        What is wrong with the curves in it, and where.
    curves : sequence of Curve
        What it holds.
    """

    def __init__(
        self, key: str, message: str, fault: GeometryError | None = None, curves: Sequence[Curve] = ()
    ) -> None:
        super().__init__(message)
        self.key, self.fault, self.curves = key, fault, curves


def with_drawings(folder: Path, declared: Mapping[str, Any]) -> dict[str, Any]:
    """Return a declaration with the curves and the mesh themselves where its plate, holes or zones name a file.

    The largest loop in the plate's drawing is its outline, and every other one is a hole. A hole's or a zone's
    drawing holds one loop.

    Raises
    ------
    DrawingError
        For keys that are wrong, for files that are missing, too large, or no closed outline, and where the extra
        is not installed.
    """
    table = dict(declared)
    plate = table.get("plate")
    if not isinstance(plate, Mapping):
        return table
    plate = dict(plate)
    holes: list[Any] = []
    if _names_a_drawing(plate.get("outline")):
        outline, *others = _loops(folder, plate["outline"], "plate.outline")
        plate["outline"] = _declared(outline)
        holes = [_declared(loop) for loop in others]
    for name in ("hole", "zone"):
        items = plate.get(name, [])
        if isinstance(items, list):
            plate[name] = [_one(folder, item, f"plate.{name}[{n}]") for n, item in enumerate(items)]
    plate["hole"] = [*plate["hole"], *holes] if isinstance(plate.get("hole"), list) else plate.get("hole")
    mesh = plate.get("mesh")
    if isinstance(mesh, Mapping) and "file" in mesh:
        plate["mesh"] = _mesh(folder, mesh, table.get("patch"))
    table["plate"] = {key: value for key, value in plate.items() if not (key in ("hole", "zone") and value == [])}
    return table


def _names_a_drawing(outline: object) -> bool:
    return isinstance(outline, Mapping) and outline.get("kind") == "drawing"


def _one(folder: Path, item: Any, key: str) -> Any:
    if not _names_a_drawing(item):
        return item
    named = {name: value for name, value in item.items() if name != "thickness"}
    loops = _loops(folder, named, key)
    if len(loops) != 1:
        curves = [curve for loop in loops for curve in loop.curves]
        raise DrawingError(key, f"the drawing holds {len(loops)} closed loops; allowed one here", None, curves)
    return {**_declared(loops[0]), **({"thickness": item["thickness"]} if "thickness" in item else {})}


def _mesh(folder: Path, declared: Mapping[str, Any], patches: object) -> dict[str, Any]:
    """Numbers of a mesh's file; a patch's surface has its name, or is called by its place: ``patch 1``."""
    key = "plate.mesh"
    named = _checked(MeshFile, declared, key)
    items = [item for item in patches if isinstance(item, Mapping)] if isinstance(patches, list) else []
    names = {str(item.get("id")): f"patch {k + 1}" for k, item in enumerate(items)}
    names |= {group: names.get(stands, stands) for group, stands in named.groups.items()}
    try:
        return mesh_of_file(folder / named.file, METRES[named.unit], names)
    except ImportError as error:
        raise DrawingError(key, str(error)) from error
    except (ValueError, OSError) as error:
        raise DrawingError(key, f"{named.file}: {error}") from error


def _checked(model: type[Kind], declared: Mapping[str, Any], key: str) -> Kind:
    """Hold what names a file against its model; DrawingError for a key that is wrong."""
    try:
        return model.model_validate(declared, strict=True)
    except ValidationError as error:
        (first, *_) = error.errors(include_url=False)
        name = ".".join(str(part) for part in first["loc"])
        raise DrawingError(
            f"{key}.{name}", f"{first['msg']}; allowed: {allowed_at(model, first['loc'])}"
        ) from error


def _declared(loop: Loop) -> dict[str, Any]:
    return {"kind": "curves", "curves": [list(row_of(curve)) for curve in loop.curves]}


def _loops(folder: Path, declared: Mapping[str, Any], key: str) -> tuple[Loop, ...]:
    drawing = _checked(Drawing, declared, key)
    curves: list[Curve] = []
    try:
        curves = _curves(folder / drawing.file, drawing)
        loops = closed_loops(curves, drawing.tolerance)
    except ImportError as error:
        raise DrawingError(key, NEEDS) from error
    except GeometryError as error:
        raise DrawingError(key, f"{drawing.file}: {error}", error, curves) from error
    except ValueError as error:
        raise DrawingError(key, f"{drawing.file}: {error}", None, curves) from error
    if not loops:
        raise DrawingError(key, f"{drawing.file}: no closed curve in it", None, curves)
    return loops


def _curves(path: Path, drawing: Drawing) -> list[Curve]:
    """Curves of a file, m; ValueError for a file that cannot be taken."""
    kind = path.suffix.lower()
    if kind not in LARGEST:
        raise ValueError("allowed: a .dxf or .svg file")
    try:
        size = path.stat().st_size if path.is_file() else -1
        if size < 0:
            raise ValueError("there is no such file beside the declaration")
        if size > LARGEST[kind]:
            raise ValueError(f"{size} bytes; allowed at most {LARGEST[kind]}: keep the outline only")
        if kind == ".dxf":
            from app.files.dxf_curves import dxf_curves

            found, unit = dxf_curves(path, drawing.layer)
        else:
            from app.files.svg_curves import svg_curves

            if drawing.layer is not None:
                raise ValueError("layer is for DXF files; remove it")
            found, unit = svg_curves(path)
    except UnicodeDecodeError as error:
        raise ValueError(f"byte {error.start} is not UTF-8") from error
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}") from error
    if len(found) > MOST_POINTS:
        raise ValueError(f"{len(found)} curves; allowed at most {MOST_POINTS}: keep the outline only")
    scale = METRES[drawing.unit] if drawing.unit else unit or METRES["mm"]
    curves = [moved(curve, 0.0, (0.0, 0.0), scale) for curve in found]
    if not all(np.isfinite(curve.at([0.0, 0.3, 1.0])).all() for curve in curves):
        raise ValueError("holds a number that is not finite")
    return curves
