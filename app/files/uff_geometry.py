"""What stands first in a universal file: nodes, header, units, and lines between nodes (15, 151, 164, 2411, 82).

Some programs refuse files without header and units; lines make a cloud of nodes a structure on their screens.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

from analysis.shapes.wire_frame import Position, lines_between

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
    factors = "".join(f"{value:25.16e}" for value in (1.0, 1.0, 1.0)), f"{273.15:25.16e}"
    return _set(164, [f"{SI_UNITS:10d}{'SI: m, N, K':20}{2:10d}", *(one.replace("e", "D") for one in factors)])


def _nodes(points: Mapping[int, Position]) -> str:
    systems = f"{0:10d}" * 3  # global coordinates, no colour
    return _set(15, [f"{n:10d}{systems}" + "".join(f"{c:13.5e}" for c in place) for n, place in points.items()])


def _nodes_double(points: Mapping[int, Position]) -> str:
    lines = []
    for node, place in points.items():
        lines += [f"{node:10d}{1:10d}{1:10d}{11:10d}", "".join(f"{c:25.16e}" for c in place).replace("e", "D")]
    return _set(2411, lines)


def _trace(number: int, nodes: Sequence[int]) -> str:
    written = [f"{node:10d}" for node in nodes]
    starts = [*range(0, len(written), 8), len(written)]
    rows = ["".join(written[a:b]) for a, b in pairwise(starts)]
    return _set(82, [f"{number:10d}{len(nodes):10d}{0:10d}", f"{'NONE':80}", *rows])


def _set(kind: int, lines: Sequence[str]) -> str:
    return "\n".join([f"{-1:6d}", f"{kind:6d}{'':74}", *lines, f"{-1:6d}"]) + "\n"
