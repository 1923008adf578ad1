"""Residues of FRFs between many places, pole by pole, as shape times participation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
