"""What stands first in universal files (data sets 15, 151, 164, 2411, 82), and mode shapes after it (55).

Some programs refuse files without header and units; lines make a cloud of nodes a structure on their screens.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyuff
from pyuff.datasets.dataset_55 import prepare_55

from analysis.identification.modes import Modes
from analysis.shapes.participation import ModeShapes, Position, lines_between
from app.files.atomic import atomic_path
from app.files.uff.opening import file_units, opened_uff

SI_UNITS = 1


def geometry_text(title: str, points: Mapping[int, Position] | None = None) -> str:
    """Return the data sets that go before functions or modes, delimiters included.

    Parameters
    ----------
    title : str
        Of the model.
    points : mapping of int to (float, float, float), optional
        Nodes, m.

    Returns
    -------
    str
        Nodes in single precision (15), which every program reads, and again with all digits (2411).
    """
    parts = [_header(title), _units()]
    if points:
        # nodes first: scripts that read them from the head of our files, up to 0.3, find them there
        parts = [_nodes(points), *parts, _nodes_double(points)]
        parts += [_trace(number, line) for number, line in enumerate(lines_between(points), start=1)]
    return "".join(parts)


def _header(title: str) -> str:
    """Return a data set 151 without dates: equal input gives equal files."""
    none = f"{'NONE':10}{'NONE':10}"
    lines = [
        f"{title[:80] or 'NONE':80}",
        f"{'NONE':80}",
        f"{'Flexura':80}",
        f"{none}{0:10d}{0:10d}{0:10d}",
        none,
        f"{'Flexura':80}",
        none,
    ]
    return _set(151, lines)


def _units() -> str:
    # 1P3D25.16, exponents with E: Fortran reads both, but SDynPy, and most that is not Fortran, no 1.0D+00
    # numbers in 1P3D25.16 with E: Fortran reads both, but SDynPy and what else is not Fortran reads no 1.0D+00
    factors = "".join(f"{value:25.16E}" for value in (1.0, 1.0, 1.0)), f"{273.15:25.16E}"
    return _set(164, [f"{SI_UNITS:10d}{'SI: m, N, K':20}{2:10d}", *factors])


def _nodes(points: Mapping[int, Position]) -> str:
    systems = f"{0:10d}" * 3  # global coordinates, no colour
    return _set(15, [f"{n:10d}{systems}" + "".join(f"{c:13.5e}" for c in place) for n, place in points.items()])


def _nodes_double(points: Mapping[int, Position]) -> str:
    lines = []
    for node, place in points.items():
        lines += [f"{node:10d}{1:10d}{1:10d}{11:10d}", "".join(f"{c:25.16E}" for c in place)]
    return _set(2411, lines)


def _trace(number: int, nodes: Sequence[int]) -> str:
    written = [f"{node:10d}" for node in nodes]
    starts = [*range(0, len(written), 8), len(written)]
    rows = ["".join(written[a:b]) for a, b in pairwise(starts)]
    return _set(82, [f"{number:10d}{len(nodes):10d}{0:10d}", f"{'NONE':80}", *rows])


def _set(kind: int, lines: Sequence[str]) -> str:
    return "\n".join([f"{-1:6d}", f"{kind:6d}{'':74}", *lines, f"{-1:6d}"]) + "\n"


NODE_SETS = (15, 2411)
"""Nodes in single and in double precision."""


def read_nodes(path: Path) -> dict[int, Position]:
    """Read where the nodes of a universal file are, m: its data set 164 says in which unit they are written.

    Returns
    -------
    dict of int to (float, float, float)
        Empty where the file has no coordinates.

    Raises
    ------
    ValueError
        For a data set of nodes, or of units, that is damaged.
    """
    found: dict[int, Position] = {}
    with opened_uff(path) as (file, kinds):
        units = file_units(file, kinds)
        for number, kind in enumerate(kinds):
            if kind not in NODE_SETS:
                continue
            try:
                read: Any = file.read_sets(number)
            except Exception as error:  # damage leads the library into whatever there is
                raise ValueError(f"its data set of points ({kind}) cannot be read; damaged?") from error
            held: dict[str, Sequence[float]] = read[0] if isinstance(read, list) else read
            nodes = zip(*(held[name] for name in ("node_nums", "x", "y", "z")), strict=True)
            try:
                found |= {int(n): tuple(float(c) * units.metre for c in place) for n, *place in nodes}  # type: ignore[misc]
            except OverflowError as error:
                raise ValueError(f"a node's number is no whole number ({error}); damaged?") from error
    for node, place in found.items():
        if not np.isfinite(place).all():
            raise ValueError(f"node {node} is at {place}; coordinates must be finite numbers, m")
    return found


STRUCTURAL, COMPLEX_MODES, THREE_TRANSLATIONS, DISPLACEMENT = 1, 3, 2, 8


def write_modes(
    target: Path, modes: Modes, shapes: ModeShapes, points: Mapping[int, tuple[float, float, float]]
) -> None:
    """Write shapes as complex modes, whole or not at all.

    Parameters
    ----------
    shapes : ModeShapes
        Directions -1 to -3 turn the sign; a place without a direction counts as along z.
    points : mapping of int to (float, float, float)
        m; nodes of which none is known are left out of the geometry.
    """
    nodes = sorted({int(place.partition(":")[0]) for place in shapes.places})
    with atomic_path(target) as partial:
        known = {node: points[node] for node in nodes if node in points}
        partial.write_text(geometry_text(target.stem, known), encoding="ascii")
        file = pyuff.UFF(str(partial))
        frequency = modes.reading().frequency_hz
        for number, (pole, shape) in enumerate(zip(shapes.pole, shapes.shape, strict=True), start=1):
            motion = np.zeros((3, len(nodes)), dtype=complex)
            for place, component in zip(shapes.places, shape, strict=True):
                node, _, direction = place.partition(":")
                along = int(direction) or 3
                if np.isfinite(component) and abs(along) <= 3:
                    motion[abs(along) - 1, nodes.index(int(node))] = np.sign(along) * component
            eigenvalue = complex(modes.poles[pole])
            file.write_sets(
                prepare_55(
                    id1=f"mode {number}: {frequency[pole]:.4f} Hz",
                    model_type=STRUCTURAL,
                    analysis_type=COMPLEX_MODES,
                    data_ch=THREE_TRANSLATIONS,
                    spec_data_type=DISPLACEMENT,
                    load_case=1,
                    mode_n=number,
                    eig=eigenvalue,
                    modal_a=0j,
                    modal_b=0j,
                    node_nums=nodes,
                    r1=motion[0],
                    r2=motion[1],
                    r3=motion[2],
                ),
                "add",
            )
