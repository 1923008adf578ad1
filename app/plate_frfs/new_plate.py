"""A ``plate.toml`` to start from: what files, geometries and options say; lines for what only you know.

The plane through the nodes is turned into that of the plate, the smallest rectangle around them is laid along the
sides, and its middle on the plate's middle. Of the ways left, the one that turns least is taken.
"""

import json
import os
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.channel import ORDER, Quantity
from analysis.estimation.quantities import unit
from analysis.estimation.transfer import MeasuredTransfer
from app.files.atomic import write_text
from app.files.bad_file import ResultFileError
from app.files.declarations.plate import FORMAT, NAME, FrfsOfPlate
from app.files.results.modes_file import load_frf
from app.files.settings_toml import toml_text
from app.files.uff.geometry import read_nodes
from app.modal_test.new_declaration import points_of_table
from app.plate_frfs.plate_of_modes import is_table_of_modes
from app.plate_frfs.source_files import UNIVERSAL, FrfsOfFile, circumstances, frfs_of_file, is_own, is_temperatures

COORDINATE_ROUNDING = 1e-3
"""Share of the plate's longer side by which rounded coordinates may reach beyond an edge, or out of the plane."""
SPAN_TOLERANCE = 0.01
"""Share of a side by which nodes may span more than it: drawings and plates differ by a little."""
Place = tuple[float, ...]


@dataclass(frozen=True)
class PlacedNodes:
    """Nodes on a plate.

    Attributes
    ----------
    places : mapping of str to (float, float, float)
        m, from the plate's corner.
    note : str
        How they were moved, and what remains; empty where they lay on the plate as given.
    """

    places: Mapping[str, Place]
    note: str = ""


HEAD = """What plate the FRFs are of; see the guide, "From another program's FRFs to E, nu and eta".
SI units, degrees Celsius; the origin is a corner of the plate, x along length_x.
Lines that begin with # and a key are to be completed: remove the # and put your number in."""
MOTIONS = tuple(ORDER)
BESIDE = {"level": "level", "direction": "descending"}
"""Arrays that Flexura's own exports hold beside the temperatures, by the keys that name them."""


@dataclass(frozen=True)
class SaidOfPlate:
    """What a user said of a plate.

    Attributes
    ----------
    plate : (float, float, float, float) or None
        Length along x and y, thickness, m, and mass, kg.
    units : (str, str) or None
        Of FRFs, response and reference, where the files do not give them.
    points : Path or None
        Table of nodes with their places.
    title : str
        Empty for that of the folder.
    """

    plate: tuple[float, float, float, float] | None = None
    units: tuple[str, str] | None = None
    points: Path | None = None
    title: str = ""


@dataclass(frozen=True)
class KeyLine:
    """One key of a declaration: with a value, or to be completed.

    Attributes
    ----------
    key : str
    value : object
        None for a line to be completed.
    remark : str
        Behind it; of a line to be completed an example first: ``0.4: m, along x``.
    """

    key: str
    value: Any = None
    remark: str = ""

    @property
    def text(self) -> str:
        """As it stands in the file."""
        if self.value is None:
            example, _, words = self.remark.partition(": ")
            return f"# {self.key} = {example}    # {words}"
        written = toml_text({self.key: self.value} if not isinstance(self.value, Mapping) else {}).strip()
        if isinstance(self.value, Mapping):
            inside = ", ".join(f"{json.dumps(k)} = {json.dumps(v)}" for k, v in self.value.items())
            written = f"{self.key} = {{ {inside} }}"
        return f"{written}    # {self.remark}" if self.remark else written


Section = tuple[str, list[KeyLine]]


def new_plate(files: Sequence[Path], said: SaidOfPlate, target: Path) -> tuple[Path, list[str], list[str]]:
    """Write ``plate.toml`` into the folder `target`, or as the file of that name.

    Parameters
    ----------
    files : sequence of Path
        With FRFs; the first is looked into.
    said : SaidOfPlate
    target : Path

    Returns
    -------
    file : Path
    missing : list of str
        Keys to be completed by hand, with their tables.
    notes : list of str
        What is to be checked.

    Raises
    ------
    ResultFileError
        Where there is a declaration already, and for files that cannot be read.
    """
    if not files:
        raise ResultFileError("no file named; type: flexura new plate FRFS.uff ...")
    file = target if target.suffix == ".toml" else target / NAME
    if file.exists():
        raise ResultFileError(f"{file}: is there already; name another with --out, or remove it")
    folder = file.resolve().parent
    named = _named(files, folder)
    title = said.title or (folder.name if file.name == NAME else file.stem)
    if is_own(files[0]):
        _write(file, _as_recorded(files[0], named, title))
        return file, [], []
    notes: list[str] = []
    if is_table_of_modes(files[0]):
        sections = [_plate(said), *(("[[modes]]", [KeyLine("file", one)]) for one in named)]
    else:
        found = frfs_of_file(files[0], _bare(files[0], said.units))
        places, notes = _places(files[0], said)
        sections, frf = _sections(files[0], found, said, places)
        sections += [("[[frf]]", [KeyLine("file", one), *frf]) for one in named]
    lines = [*(f"# {line}" for line in (*HEAD.splitlines(), *notes)), "", f'format = "{FORMAT}"']
    lines.append(KeyLine("title", title).text)
    for heading, keys in sections:
        lines += ["", heading, *(key.text for key in keys)]
    _write(file, "\n".join(lines) + "\n")
    missing = [f"{heading} {key.key}" for heading, keys in sections for key in keys if key.value is None]
    return file, list(dict.fromkeys(missing)), notes


def _as_recorded(source: Path, named: Sequence[str], title: str) -> str:
    """Return the declaration of a run's frf.h5: all of it is in the file."""
    experiment, _ = load_frf(source)
    declared = experiment.model_dump(mode="json", exclude={"format"}, exclude_none=True)
    table = {"format": FORMAT} | declared | {"title": title, "frf": [{"file": one} for one in named]}
    return toml_text({key: value for key, value in table.items() if value not in ((), [], "")})


def _named(files: Sequence[Path], folder: Path) -> list[str]:
    """Return the files relative to the declaration: a pattern where one means them and no other, else each."""
    every = [Path(os.path.relpath(file.resolve(), folder)).as_posix() for file in files]
    beside, names = {file.resolve().parent for file in files}, [file.name for file in files]
    if len(every) == 1 or len(beside) > 1:
        return every
    start, end = _common_start(names), _common_start([name[::-1] for name in names])[::-1]
    pattern = f"{re.sub(r'[-+0-9.]+$', '', start)}*{end}"
    if {one.name for one in beside.pop().glob(pattern)} != set(names):
        return every
    return [(Path(every[0]).parent / pattern).as_posix()]


def _common_start(words: Sequence[str]) -> str:
    """Return the letters with which all words begin."""
    first, last = min(words), max(words)
    same = next((n for n, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), len(first))
    return first[:same]


def _sections(
    path: Path, found: FrfsOfFile, said: SaidOfPlate, places: Mapping[str, Sequence[float]]
) -> tuple[list[Section], list[KeyLine]]:
    """Return the tables of plate, drives, sensors and electronics, and the keys of ``[[frf]]``."""
    sections: list[Section] = [_plate(said)]
    drives: dict[str, str] = {}
    sensors: dict[str, str] = {}
    stars = _stars(found)
    volts = False
    roving = _roving(found, said)
    below = _below(found)
    # where several drove, a sensor has an FRF of each
    by_node = path.suffix.lower() in UNIVERSAL or len({frf.reference for frf in found.transfers}) > 1
    if roving:
        sections.append(_roving_hammer(roving, places))
        sections[-1][1].extend(_pushing_up({one.reference for one in found.transfers}))
    for frf in found.transfers:
        reference, response = _quantity(frf, said, 1), _quantity(frf, said, 0)
        if not roving and frf.reference not in drives:
            drives[frf.reference] = f"D{len(drives) + 1}"
            sections.append(_end(drives[frf.reference], reference, places.get(_node(frf.reference)), drives=True))
            if reference == "force":
                sections[-1][1].extend(_pushing_up({frf.reference}))
        key = stars.get(frf.name, _node(frf.response) if by_node else frf.name)
        if key not in sensors:
            sensors[key] = f"S{len(sensors) + 1}"
            section = _end(sensors[key], response, places.get(_node(frf.response)), drives=False)
            if section[0] == "[[sensor]]" and frf.response in below:
                section[1].append(KeyLine("side", "bottom", "-z in the file: out of the bottom face"))
            sections.append(section)
            volts = volts or response == "voltage"
    if volts:
        sections.append(
            (
                "[acquisition]",
                [
                    KeyLine("input_resistance", None, "1e6: ohm across each sensor patch"),
                    KeyLine("input_capacitance", None, "1e-10: F, module plus cable"),
                ],
            )
        )
    return sections, _frf_lines(path, found, said, drives, sensors, stars=bool(stars))


def _below(found: FrfsOfFile) -> set[str]:
    """Return responses that count out of the bottom face: along -z, beside others or where the force is, too.

    Where all responses are along -z and the force is not, their common sign is that of the force.
    """
    ends = {one.response for one in found.transfers}
    down = {end for end in ends if re.fullmatch(r"-[3z]", end.partition(":")[2])}
    pushed = any(re.fullmatch(r"-[3z]", one.reference.partition(":")[2]) for one in found.transfers)
    return down if pushed or down != ends else set()


def _pushing_up(references: Collection[str]) -> list[KeyLine]:
    """Return the line for forces along +z, which push into the bottom face; none where a file does not say so."""
    up = all(re.fullmatch(r"\+[3z]", one.partition(":")[2]) for one in references)
    return [KeyLine("side", "bottom", "+z in the file: it pushes into the bottom face")] if up else []


FEWEST_HITS = 3
"""Points that drive from which, if they are more than those that answer, a hammer moved between them."""


def _roving(found: FrfsOfFile, said: SaidOfPlate) -> list[str]:
    """Return the nodes of a hammer that moved, in the order of the file; empty where it did not."""
    forces = all(_quantity(one, said, 1) == "force" for one in found.transfers)
    motions = {_quantity(one, said, 0) for one in found.transfers}
    nodes = list(dict.fromkeys(_node(one.reference) for one in found.transfers))
    responses = {one.response for one in found.transfers}
    moved = forces and len(motions) == 1 and motions <= set(MOTIONS) and FEWEST_HITS <= len(nodes) > len(responses)
    return nodes if moved and all(node.isdecimal() for node in nodes) else []


def _roving_hammer(nodes: Sequence[str], places: Mapping[str, Sequence[float]]) -> Section:
    """Return the table of a hammer that moved between nodes."""
    known = all(node in places for node in nodes)
    points = [[places[node][0], places[node][1]] for node in nodes] if known else None
    example = "[[0.05, 0.05], [0.1, 0.05]]: m, x and y of every node, in this order"
    return "[[drive]]", [
        KeyLine("id", "hammer"),
        KeyLine("points", points, "" if known else example),
        KeyLine("nodes", [int(node) for node in nodes]),
    ]


def _plate(said: SaidOfPlate) -> Section:
    keys = ("length_x", "length_y", "thickness", "mass")
    words = ("0.4: m, along x", "0.3: m, along y", "0.003: m", "0.35: kg, weighed with nothing attached")
    given = said.plate or (None, None, None, None)
    rows = zip(keys, given, words, strict=True)
    return "[plate]", [KeyLine(key, value, "" if value else word) for key, value, word in rows]


def _frf_lines(
    path: Path,
    found: FrfsOfFile,
    said: SaidOfPlate,
    drives: Mapping[str, str],
    sensors: Mapping[str, str],
    *,
    stars: bool,
) -> list[KeyLine]:
    lines = [KeyLine("sensors", dict(sensors))]
    if len(drives) > 1:
        lines.append(KeyLine("drives", {_node(end): name for end, name in drives.items()}))
    if said.units is not None:
        lines.append(KeyLine("units", list(said.units)))
    if stars:
        lines.append(KeyLine("temperature", _temperatures(found)))
        lines += [KeyLine(key, name) for key, name in BESIDE.items() if name in found.arrays]
    else:
        first = found.transfers[0]
        try:
            circumstances(found, path, first.name, "", _bare(path))
        except ValueError:
            lines.append(KeyLine("temperature", None, "20.0: °C at which it was measured"))
    if any(one.coherence is not None for one in found.transfers):
        numbers = found.arrays.get("averages")
        count = None if numbers is None or np.ptp(numbers.real) > 0.0 else float(numbers[0].real)
        if count is not None:
            lines.append(KeyLine("averages", count))
    return lines


def _end(name: str, quantity: str, place: Sequence[float] | None, *, drives: bool) -> Section:
    """Return the table of one drive or sensor."""
    point = KeyLine(
        "point", None if place is None else [place[0], place[1]], "" if place else "[0.05, 0.05]: m, x and y"
    )
    if quantity == "force" and drives:
        return "[[drive]]", [KeyLine("id", name), point]
    if quantity in ("voltage", "charge"):
        role = "actuator" if drives else "sensor"
        how = [KeyLine("quantity", quantity)] if quantity == "charge" else []
        return "[[patch]]", [
            KeyLine("id", name),
            KeyLine("role", role),
            *how,
            KeyLine("center", None, "[0.05, 0.05]: m, x and y"),
            KeyLine("size", None, "[0.02, 0.02]: m, along x and y"),
            KeyLine("thickness", None, "0.0005: m"),
            KeyLine("side", None, '"top": or "bottom"'),
            KeyLine("material", None, '"PIC255": NCE51, PIC255, PZT-5A or PZT-5H'),
        ]
    if drives:
        return "[[drive]]", [KeyLine("id", name), point]
    kind = quantity if quantity in MOTIONS else None
    mass = KeyLine("mass", 0.0, "kg: weigh the accelerometer, it loads the plate")
    return "[[sensor]]", [
        KeyLine("id", name),
        KeyLine("kind", kind, "" if kind else '"acceleration": displacement, velocity or acceleration'),
        point,
        *([mass] if kind == "acceleration" else []),
    ]


def _quantity(frf: MeasuredTransfer, said: SaidOfPlate, end: int) -> str:
    """Return what was measured at the response (0) or the reference (1), ``unknown`` where nothing says it."""
    written = frf.units[end] or ("" if said.units is None else said.units[end])
    if written:
        try:
            known: Quantity = unit(written).quantity
        except ValueError:
            return "unknown"
        return known
    return (frf.quantity, frf.reference_quantity)[end]


def _stars(found: FrfsOfFile) -> dict[str, str]:
    """Return ``H[*]`` for names ``H[1]``, ``H[2]``, ... of as many FRFs as the file has temperatures."""
    lengths = {len(values) for name, values in found.arrays.items() if is_temperatures(name, values)}
    groups: dict[str, list[str]] = {}
    for frf in found.transfers:
        numbered = re.fullmatch(r"(.*)\[(\d+)(,\d+)?\]", frf.name)
        if numbered:
            groups.setdefault(f"{numbered[1]}[*{numbered[3] or ''}]", []).append(frf.name)
    return {name: key for key, names in groups.items() if len(names) in lengths for name in names}


def _temperatures(found: FrfsOfFile) -> str | None:
    return next((name for name, values in found.arrays.items() if is_temperatures(name, values)), None)


def _places(path: Path, said: SaidOfPlate) -> tuple[Mapping[str, Sequence[float]], list[str]]:
    """Places of nodes, m, by their numbers, and notes: of a table, or of the universal file, put on the plate."""
    if said.points is not None:
        return {str(node): place for node, place in points_of_table(said.points).items()}, []
    if path.suffix.lower() not in UNIVERSAL:
        return {}, []
    given = {str(node): place for node, place in read_nodes(path).items()}
    if said.plate is None:
        return given, []
    try:
        placed = placed_nodes(given, said.plate[:2])
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error
    return placed.places, [placed.note] if placed.note else []


def _bare(path: Path, units: tuple[str, str] | None = None) -> FrfsOfPlate:
    """Return a ``[[frf]]`` that says nothing but the file and units."""
    return FrfsOfPlate.model_validate({"file": path.name, "units": units})


def _node(end: str) -> str:
    return end.partition(":")[0]


def _write(target: Path, text: str) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_text(target, text)
    except OSError as error:
        raise ResultFileError(
            f"{target}: cannot be written ({error.strerror}); name another with --out"
        ) from error


def placed_nodes(given: Mapping[str, Sequence[float]], sides: tuple[float, float]) -> PlacedNodes:
    """Place nodes on a plate.

    Parameters
    ----------
    given : mapping of str to (float, float, float)
        Coordinates by node, m.
    sides : (float, float)
        Lengths of the plate along x and y, m.

    Returns
    -------
    PlacedNodes

    Raises
    ------
    ValueError
        For nodes that do not fit the plate, with their size and its own.
    """
    if not given:
        return PlacedNodes({})
    nodes, here = list(given), np.array([tuple(place) for place in given.values()], dtype=float)
    near = COORDINATE_ROUNDING * max(sides)
    flat = np.ptp(here[:, 2]) <= near
    if flat and (here[:, :2] >= -near).all() and (here[:, :2] <= np.array(sides) + near).all():
        return PlacedNodes(dict(zip(nodes, map(tuple, here.tolist()), strict=True)))
    if len(nodes) < 3:
        raise ValueError(
            f"{len(nodes)} nodes that are not on the plate of {sides[0]:g} m x {sides[1]:g} m; three are needed "
            "to place them: give their places from a corner of the plate with --points"
        )
    middle = here.mean(axis=0)
    axes = _plane(here - middle)
    across = (here - middle) @ np.cross(*axes)
    plane = (here - middle) @ axes.T
    turned, angle = _turned(plane, sides)
    low, high = turned.min(axis=0), turned.max(axis=0)
    placed = turned - 0.5 * (low + high) + 0.5 * np.array(sides)
    margin = 0.5 * (np.array(sides) - (high - low))
    shift = placed.mean(axis=0) - middle[:2]
    degrees = 0.0 + round(float(np.degrees(angle)), 1)  # no minus sign before nothing
    note = (
        f"{len(nodes)} nodes were not on the plate as the files give them: turned by {degrees:.1f} degrees in "
        f"their plane and moved by {shift[0]:.4g} and {shift[1]:.4g} m, their middle now on that of the plate; "
        f"off their plane by {np.abs(across).max():.2g} m at most, {margin[0]:.3g} and {margin[1]:.3g} m from the "
        f"edges. Check that node {nodes[0]} is at {placed[0, 0]:.4g}, {placed[0, 1]:.4g} m: a half turn and a "
        "mirror image fit as well"
    )
    rows = [(round(float(x), 6), round(float(y), 6), 0.0) for x, y in placed]
    return PlacedNodes(dict(zip(nodes, rows, strict=True)), note)


def _plane(centred: Real) -> Real:
    """Return the two axes (2, 3) of the plane through nodes: those of x and y, as near as they are in it."""
    normal = np.linalg.svd(centred, full_matrices=False)[2][2]
    one, other = np.delete(np.arange(3), np.argmax(np.abs(normal)))  # a drawing in x and z is seen with z up
    x = np.eye(3)[one] - normal[one] * normal
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    return np.array([x, y if y[other] > 0.0 else -y])


def _turned(plane: Real, sides: tuple[float, float]) -> tuple[Real, float]:
    """Turn nodes (N, 2) so that the smallest rectangle around them lies along the sides; also the angle, rad."""
    from scipy.spatial import ConvexHull, QhullError  # slow import

    try:
        hull = plane[ConvexHull(plane).vertices]
    except QhullError as error:
        raise ValueError(
            "the nodes lie on one line, which does not tell where they are on the plate; give their places from a "
            "corner of the plate with --points"
        ) from error
    edges = np.roll(hull, -1, axis=0) - hull
    ways: list[tuple[float, float, float]] = []
    spans = []
    for direction in np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (0.5 * np.pi), 9)):
        for angle in (-direction, 0.5 * np.pi - direction):
            span = np.ptp(hull @ _rotation(angle).T, axis=0)
            spans.append(span)
            if (span <= (1.0 + SPAN_TOLERANCE) * np.array(sides)).all():
                ways.append((float(np.prod(span)), abs(float(angle)), float(angle)))
    if not ways:
        smallest = min(spans, key=lambda span: float(np.prod(span)))
        raise ValueError(
            f"the nodes span {smallest[0]:.4g} m x {smallest[1]:.4g} m, the plate {sides[0]:g} m x {sides[1]:g} "
            "m: are they in another unit, or of another plate? Give places on the plate, m, with --points"
        )
    least = min(area for area, _, _ in ways)
    angle = min((size, angle) for area, size, angle in ways if area <= least * (1.0 + 1e-6))[1]
    return plane @ _rotation(angle).T, angle


def _rotation(angle: float) -> Real:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
