"""Residues of FRFs between many places, pole by pole, as shape times participation.

How alike shapes are, and how real each is.

Lines and faces between the measuring points of a structure, where nobody has declared any.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.channel import ORDER
from analysis.estimation.transfer import MeasuredTransfer

REPEATED = 0.1
"""Second singular value of a pole's residues over the first from which two modes share the pole."""

ABOVE_NOISE = 2.0
"""The same over the largest singular value that noise alone would have."""

AROUND = 5.0
"""Half widths, and lines at least, to either side of a pole in which what is left over counts as its noise."""

STEPS = 200
"""Alternating projections at most where not every response was measured with every reference."""


@dataclass(frozen=True)
class ModeShapes:
    """Shapes at places, one for each mode; a pole with two modes has two.

    Attributes
    ----------
    pole : (S,) int ndarray
        Which pole of the identification.
    places : tuple of str
        K places of the shape, node and direction as ``5:+3``: those of the responses, or of the references where
        these are more (a hammer that was moved; by reciprocity it is the same shape).
    references : tuple of str
        M places of the other end.
    shape : (S, K) complex ndarray
        The largest component is 1; NaN where a place was not measured.
    participation : (S, M) complex ndarray
        With `shape`, what the displacement's residues are made of: R = shape x participation.
    rank_one : (S,) ndarray
        Share of the residues' energy that this one mode holds, 0 to 1.
    """

    pole: NDArray[np.int64]
    places: tuple[str, ...]
    references: tuple[str, ...]
    shape: NDArray[np.complex128]
    participation: NDArray[np.complex128]
    rank_one: NDArray[np.float64]

    def __post_init__(self) -> None:
        count, places, references = len(self.pole), len(self.places), len(self.references)
        wanted = {"shape": (count, places), "participation": (count, references), "rank_one": (count,)}
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; {shape} wanted")


def mode_shapes(
    transfers: Sequence[MeasuredTransfer],
    poles: NDArray[np.complex128],
    residues: NDArray[np.complex128],
    wanted: NDArray[np.bool_],
    deviation: NDArray[np.float64] | None = None,
) -> ModeShapes:
    """Take shapes and participations out of residues.

    Parameters
    ----------
    transfers : sequence of MeasuredTransfer
        L FRFs; where two have the same ends, their mean counts.
    poles : (J,) complex ndarray
        rad/s.
    residues : (L, J) complex ndarray
        As identified; those of velocities and accelerations are referred to displacement, so that a shape may be
        read by sensors of several kinds.
    wanted : (J,) bool ndarray
        Poles that are modes.
    deviation : (L, J) ndarray, optional
        Standard deviation of each residue, see `residue_deviation`: noise has singular values too, and a second
        shape has to be larger than these.
    """
    responses = tuple(dict.fromkeys(one.response for one in transfers))
    references = tuple(dict.fromkeys(one.reference for one in transfers))
    turned = len(references) > len(responses)
    rows, columns = (references, responses) if turned else (responses, references)
    order = np.array([ORDER.get(one.quantity, 0) - ORDER.get(one.reference_quantity, 0) for one in transfers])  # type: ignore[call-overload]
    found: list[tuple[int, NDArray[np.complex128], NDArray[np.complex128], float]] = []
    noise = np.zeros(residues.shape) if deviation is None else deviation
    for j in np.flatnonzero(wanted):
        expected = float(np.sqrt(np.mean((noise[:, j] / np.abs(poles[j]) ** order) ** 2)))
        table = np.full((len(rows), len(columns)), np.nan, dtype=complex)
        seen = np.zeros(table.shape, dtype=int)
        for one, residue in zip(transfers, residues[:, j] / poles[j] ** order, strict=True):
            ends = (one.reference, one.response) if turned else (one.response, one.reference)
            place = rows.index(ends[0]), columns.index(ends[1])
            before = 0.0 if seen[place] == 0 else table[place] * seen[place]
            seen[place] += 1
            table[place] = (before + residue) / seen[place]
        found += [(int(j), *part) for part in _parts(table, expected)]
    return ModeShapes(
        pole=np.array([part[0] for part in found], dtype=np.int64),
        places=rows,
        references=columns,
        shape=np.array([part[1] for part in found], dtype=complex).reshape(-1, len(rows)),
        participation=np.array([part[2] for part in found], dtype=complex).reshape(-1, len(columns)),
        rank_one=np.array([part[3] for part in found]),
    )


def residue_deviation(
    frequency: NDArray[np.float64], left: NDArray[np.complex128], poles: NDArray[np.complex128]
) -> NDArray[np.float64]:
    """Return the standard deviations of residues from what the model leaves over around each pole.

    Of least squares on a single line shape 1/(s - pole): the variance of a line, times half width and spacing of
    the lines there (rad/s) over pi; neighbours that overlap make it larger.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.
    left : (L, F) complex ndarray
        Measured minus model.
    poles : (J,) complex ndarray
        rad/s.

    Returns
    -------
    (L, J) ndarray
    """
    distance = np.gradient(frequency)
    found = np.empty((len(left), len(poles)))
    for j, pole in enumerate(poles):
        place = np.clip(pole.imag / (2.0 * np.pi), frequency[0], frequency[-1])
        spacing = float(np.interp(place, frequency, distance))
        reach = AROUND * max(-pole.real / (2.0 * np.pi), spacing)
        power = (np.abs(left[:, np.abs(frequency - place) <= reach]) ** 2).mean(axis=1)
        found[:, j] = np.sqrt(power * -pole.real * 2.0 * spacing)
    return found


def _parts(
    table: NDArray[np.complex128], noise: float
) -> list[tuple[NDArray[np.complex128], NDArray[np.complex128], float]]:
    """Shapes, participations and shares of energy of one pole's residues, (K, M) with NaN where not measured.

    A matrix of noise has a largest singular value of about (sqrt(K) + sqrt(M)) times its deviation.
    """
    measured = np.isfinite(table)
    filled = np.where(measured, table, 0.0)
    if not measured.all():
        filled = _completed(table, measured)
    left, values, right = np.linalg.svd(filled, full_matrices=False)
    energy = float((values**2).sum())
    count = 1
    least = max(REPEATED * values[0], ABOVE_NOISE * noise * float(np.sqrt(table.shape).sum()))
    if measured.all() and len(values) > 1 and values[1] > least:
        count = 2
    parts = []
    for k in range(count):
        shape, partner = left[:, k], values[k] * right[k]
        largest = shape[int(np.argmax(np.abs(shape)))]
        shape = np.where(measured.any(axis=1), shape / largest, np.nan)
        parts.append((shape, partner * largest, float(values[k] ** 2 / energy) if energy else 0.0))
    return parts


def _completed(table: NDArray[np.complex128], measured: NDArray[np.bool_]) -> NDArray[np.complex128]:
    """Fill what was not measured with what the rank-one matrix nearest to the rest has there."""
    filled = np.where(measured, table, 0.0)
    for _ in range(STEPS):
        left, values, right = np.linalg.svd(filled, full_matrices=False)
        guess = values[0] * np.outer(left[:, 0], right[0])
        again = np.where(measured, table, guess)
        if np.abs(again - filled).max() < 1e-10 * values[0]:
            break
        filled = again
    rank_one: NDArray[np.complex128] = guess
    return rank_one


def mac(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Modal assurance criterion of all pairs (Allemang and Brown, IMAC 1982), 0 to 1.

    Parameters
    ----------
    one, other : (S, K) and (U, K) ndarray
        Shapes at the same places; NaN where one was not measured, which leaves the place out for that pair.

    Returns
    -------
    (S, U) ndarray
    """
    both = np.isfinite(one)[:, None] & np.isfinite(other)[None]
    a = np.where(both, one[:, None], 0.0)
    b = np.where(both, other[None], 0.0)
    cross = np.abs((a.conj() * b).sum(2)) ** 2
    size = (np.abs(a) ** 2).sum(2) * (np.abs(b) ** 2).sum(2)
    found: NDArray[np.float64] = np.divide(cross, size, out=np.zeros_like(cross), where=size > 0.0)
    return found


def mpc(shapes: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Modal phase collinearity (Pappa et al., J. Guid. Control Dyn. 16, 1993): 1 for a shape in one phase.

    Parameters
    ----------
    shapes : (S, K) complex ndarray

    Returns
    -------
    (S,) ndarray
        0 to 1; of a shape at a single place, 1.
    """
    known = np.where(np.isfinite(shapes), shapes, 0.0)
    real, imaginary = known.real, known.imag
    xx, yy, xy = (real**2).sum(1), (imaginary**2).sum(1), (real * imaginary).sum(1)
    apart = np.sqrt((xx - yy) ** 2 + 4.0 * xy**2)
    total = xx + yy
    found: NDArray[np.float64] = np.divide(apart**2, total**2, out=np.ones_like(apart), where=total > 0.0)
    return found


Position = tuple[float, float, float]

LONGEST = 1.5
"""Length of a line, over the median, beyond which it is not drawn: it would cross a hole or close a bay."""
FLAT = 1e-6
"""Smallest extent across, over that along, of nodes that do not lie on one line."""


def lines_between(points: Mapping[int, Position]) -> list[list[int]]:
    """Return nodes to be joined, in this order: those of one line along it, others by the edges of triangles.

    Parameters
    ----------
    points : mapping of int to (float, float, float)

    Returns
    -------
    list of list of int
        Empty for fewer than two places; nodes that are nowhere are joined to none.
    """
    nodes, place = _seen(points)
    if len(np.unique(place, axis=0)) < 2:
        return []
    if _on_a_line(place):
        return [[nodes[n] for n in np.argsort(place[:, 0], kind="stable")]]
    _, short = _triangles(place)
    return [[nodes[a], nodes[b]] for a, b in sorted(short)]


def faces_between(points: Mapping[int, Position]) -> list[tuple[int, int, int]]:
    """Return the corners of triangles between `lines_between`; none for nodes on one line."""
    nodes, place = _seen(points)
    if len(nodes) < 3 or _on_a_line(place):
        return []
    corners, short = _triangles(place)
    return [(nodes[a], nodes[b], nodes[c]) for a, b, c in corners if short.issuperset(_sides((a, b, c)))]


def _seen(points: Mapping[int, Position]) -> tuple[list[int], Real]:
    """Return the nodes that are somewhere, and their places (N, 2) along their two longest extents."""
    nodes = sorted(node for node, place in points.items() if np.isfinite(place).all())
    place = np.array([points[node] for node in nodes]).reshape(-1, 3)
    if not nodes:
        return [], np.zeros((0, 2))
    centred = place - place.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=False)[2]
    return nodes, centred @ axes[:2].T


def _on_a_line(place: Real) -> bool:
    along, across = np.linalg.norm(place, axis=0)
    return bool(across <= FLAT * along)


def _triangles(flat: Real) -> tuple[list[tuple[int, int, int]], set[tuple[int, int]]]:
    """Return Delaunay's triangles of points (N, 2) in a plane, and those of their sides that are short."""
    from scipy.spatial import Delaunay  # slow import

    found = [(int(a), int(b), int(c)) for a, b, c in Delaunay(flat).simplices]
    length = {(a, b): float(np.linalg.norm(flat[a] - flat[b])) for one in found for a, b in _sides(one)}
    longest = LONGEST * float(np.median(list(length.values())))
    return found, {edge for edge, long in length.items() if long <= longest}


def _sides(corners: tuple[int, int, int]) -> list[tuple[int, int]]:
    a, b, c = sorted(corners)
    return [(a, b), (b, c), (a, c)]
