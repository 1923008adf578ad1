"""Drawings and meshes named in a declaration, turned into what they hold: it then needs no other file.

Meshes are those of Gmsh, Abaqus, Nastran, Exodus and VTK.

Whether a declared plate can be meshed, found out when its declaration is read.

Otherwise borders that touch, a mesh that does not fit, or a plate too large for any computer would be found only
when the twin is built, after the campaign, when its declaration cannot be changed any more.
"""

import hashlib
import json
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Field, ValidationError

from analysis.declaration.outline import MOST_POINTS, row_of
from analysis.declaration.strict import Declared, FileName
from analysis.geometry.loop import Curve, GeometryError, Loop, closed_loops, moved
from app.files.allowed_values import allowed_at
from app.files.bad_file import Misplaced
from app.files.drawings.exodus_mesh import ENDINGS as EXODUS
from app.files.isolation import run_isolated
from app.files.parsed_text import parse_json

if TYPE_CHECKING:
    from analysis.declaration.plate import Plate
    from analysis.declaration.transducers import Patch
    from simulation.meshing.plate_mesh import MeshRecipe

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


METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
MESHES_NEED = "reading meshes needs the extra meshes: pip install 'flexura[meshes]'"
LARGEST_MESH_FILE = 20_000_000
"""Bytes of a file."""
READER = "app.files.drawings.mesh_reader"


class MeshFile(Declared):
    """A mesh in a file: ``[plate.mesh]`` with the key ``file``.

    `groups` gives names to groups that the file calls otherwise, such as the numbers of Nastran's properties.
    """

    file: Annotated[FileName, Field(min_length=3, description="a mesh's file, such as plate.msh")]
    unit: Literal["mm", "cm", "m", "in"] = "m"
    groups: Annotated[dict[str, str], Field(default_factory=dict, max_length=1000)]


def mesh_of_file(path: Path, unit: float, names: Mapping[str, str]) -> dict[str, Any]:
    """Numbers of a mesh, as `analysis.declaration.plate.ForeignMesh` takes them.

    A process of its own reads the file, in bounded time and memory: meshio sets memory aside for the largest
    number of a point, and a damaged file may say any.

    Parameters
    ----------
    path : Path
        Of an ending in `app.files.drawings.mesh_reader.LIBRARY`, in any version.
    unit : float
        Length of one unit of the file, m.
    names : mapping
        Other names of groups (identifiers of patches), and what each stands for.

    Returns
    -------
    dict
        Points, m; cells and curves by their points, surfaces by their cells, all counted from 0.

    Raises
    ------
    ImportError
        Where meshio is not installed, but for Exodus.
    ValueError
        For what is no plane mesh of triangles and quadrilaterals, or is not read in time.
    """
    if path.suffix.lower() not in EXODUS and find_spec("meshio") is None:
        raise ImportError(MESHES_NEED)
    size = path.stat().st_size if path.is_file() else -1
    if size < 0:
        raise ValueError("there is no such file beside the declaration")
    if size > LARGEST_MESH_FILE:
        raise ValueError(f"{size} bytes; allowed at most {LARGEST_MESH_FILE}")
    with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
        numbers = Path(folder) / "mesh.json"
        run_isolated(READER, [str(path.resolve()), str(numbers)], size)
        mesh: dict[str, Any] = parse_json(numbers.read_bytes())
    keep = str if path.suffix.lower() == GMSH else _plain  # other names are mistakes there
    known = {keep(name): stands for name, stands in names.items()}
    return {
        **mesh,
        "points": [[unit * x, unit * y] for x, y in mesh["points"]],
        "surface": _renamed(_called(mesh["surface"], keep), known, every=keep is str),
        "curve": _renamed(_called(mesh["curve"], keep), known, every=keep is str),
    }


def _called(groups: Mapping[str, list[Any]], keep: Callable[[str], str]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for name, members in groups.items():
        found.setdefault(keep(name), []).extend(members)
    return found


GMSH = ".msh"
OF_A_PLATE = re.compile(r"(patch|zone|hole|support)[ _-]?(\d+)|outline|plate", re.IGNORECASE)


def _plain(name: str) -> str:
    """Return ``patch 1`` for PATCH_1: Abaqus knows no small letters."""
    found = OF_A_PLATE.fullmatch(name.strip())
    if found is None:
        return name.strip().casefold()
    return f"{found[1].lower()} {found[2]}" if found[1] else found[0].lower()


def _renamed(
    groups: Mapping[str, list[Any]], names: Mapping[str, str], *, every: bool = True
) -> dict[str, list[Any]]:
    """Give groups the names used in the declaration, and join those of one name; of a plate's alone, or of all."""
    together: dict[str, set[Any]] = {}
    for name, members in groups.items():
        if not (every or name in names or OF_A_PLATE.fullmatch(name)):
            continue
        together.setdefault(names.get(name, name), set()).update(
            tuple(member) if isinstance(member, list) else member for member in members
        )
    return {name: sorted(members) for name, members in together.items()}


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
            from app.files.drawings.curves import dxf_curves

            found, unit = dxf_curves(path, drawing.layer)
        else:
            from app.files.drawings.curves import svg_curves

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


BANDS = ("sweep.band", "protocol.band", "filters.edges")
"""Where an experiment, a campaign and a panel declare the frequencies they need."""
MOST_CELLS = 5000
"""Triangles of a plate: its model then takes 8 GB."""


def mesh_fault(
    source: Path, table: Mapping[str, Any], declared: object
) -> tuple[str, str, Misplaced | None] | None:
    """Mesh a declared plate, or compare its mesh with outline, holes, zones, patches and supports.

    A declaration that passed is remembered by an empty file in the cache folder: meshing it takes longer than
    reading the rest.

    Parameters
    ----------
    source : Path
        File of the declaration.
    table : mapping
        Its keys and values, with the mesh itself.
    declared : object
        What was made of them: an experiment or a panel, with ``plate`` and ``patch``, or other settings.

    Returns
    -------
    (str, str, Misplaced or None) or None
        The key, what is wrong, and where; None if nothing is.
    """
    plate, patches = getattr(declared, "plate", None), getattr(declared, "patch", ())
    if plate is None:
        return None
    band = _band(declared)
    passed = _passed(plate, patches, band)
    if passed.is_file():
        return None
    from analysis.geometry.loop import GeometryError
    from simulation.shell.shell_plate import mesh_of

    try:
        recipe = None if plate.mesh else _recipe(plate, band)
        mesh_of(plate, patches, recipe)
    except GeometryError as error:
        key = "plate.mesh" if plate.mesh else "plate"
        places = Misplaced(source, table, error.places) if error.places else None
        return key, _with_names(str(error), patches), places
    with suppress(OSError):  # without a cache folder it is meshed again
        passed.parent.mkdir(parents=True, exist_ok=True)
        passed.touch()
    return None


def _passed(plate: "Plate", patches: Sequence["Patch"], band: Any) -> Path:
    """Name the file that says that a declaration passed, by all that its mesh depends on."""
    from app.files.basis_cache import cache_folder
    from simulation.reduction.basis_key import METHOD

    declared = [METHOD, plate.model_dump_json(), *(patch.model_dump_json() for patch in patches), band]
    return cache_folder() / f"meshed-{hashlib.sha256(json.dumps(declared).encode()).hexdigest()}"


def _recipe(plate: "Plate", band: Any) -> "MeshRecipe | None":
    """Sizes of the twin's mesh, None without a band; GeometryError for a plate of too many cells."""
    if band is None:
        return None
    from analysis.declaration.plate_material import material_box
    from analysis.geometry.loop import GeometryError
    from simulation.shell.fineness import Fineness, shortest_wave

    box = material_box(plate.material)
    recipe = Fineness().recipe(plate, box, band)
    cells = plate.area / (0.433 * recipe.bulk(plate.thickness) ** 2)  # equilateral triangles
    if cells > MOST_CELLS:
        wave = shortest_wave(plate, box, band)
        raise GeometryError(
            f"{plate.length_x:g} by {plate.length_y:g} m are {plate.length_x / wave:.0f} by "
            f"{plate.length_y / wave:.0f} of the shortest bending wavelengths, {wave:.2g} m at {band[1]:g} Hz: "
            f"a model of {cells:.0f} cells, allowed {MOST_CELLS}. End the band at "
            f"{band[1] * MOST_CELLS / cells:.2g} Hz"
        )
    return recipe


def _band(declared: object) -> Any:
    """Frequencies that are needed, (low, high) Hz; None where none are declared."""

    def value(path: str) -> Any:
        try:
            return attrgetter(path)(declared)
        except AttributeError:
            return None

    return next(filter(None, map(value, BANDS)), None)


def _with_names(message: str, patches: Sequence["Patch"]) -> str:
    """Call patches by their names instead of their numbers."""
    names = {str(k + 1): patch.id for k, patch in enumerate(patches)}
    return re.sub(r"(?<!')\bpatch (\d+)", lambda found: f"patch {names.get(found[1], found[1])!r}", message)
