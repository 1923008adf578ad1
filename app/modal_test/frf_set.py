"""FRFs of one structure, with the places of their ends and what they came from."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.channel import UNITS, Quantity
from analysis.estimation.estimators import Segments, without_information
from analysis.estimation.quantities import frf_label, frf_name, frf_unit
from analysis.estimation.transfer import MeasuredTransfer, turns_backward
from analysis.identification.judgement.confirmation import WithoutHit
from analysis.identification.settings import lines_inside
from analysis.labelled import Labelled, LabelledArrays
from analysis.shapes.stabilization import FrfCheck, checks
from app.files.bad_file import ResultFileError

Position = tuple[float, float, float]

LARGEST_FRF = 1e50
"""Beyond it, and below its inverse, squares of what is computed from FRFs leave the range of numbers."""


@dataclass(frozen=True)
class FrfSet(Labelled):
    """FRFs that share their lines.

    Attributes
    ----------
    title : str
    transfers : tuple of MeasuredTransfer
    points : dict of int to (float, float, float)
        Places of nodes, m, as far as they are known.
    window_rate : float
        Of an exponential window, which all poles lie further left by, 1/s.
    segments : Segments or None
        Windowed segments that were averaged, whose leakage is taken out of poles; None where there were none.
    temperature : float
        Degrees Celsius; NaN where it is not known.
    mains : float or None
        Hz, where it is known.
    notes : tuple of str
    hashes : dict of str to str
        SHA-256 of the files they came from.
    operator, date : str
        Who measured, and when, where the declaration says.
    without_hits : tuple of WithoutHit
        The same FRFs without each hit in turn, of hammer tests with three hits or more at every point.
    """

    title: str
    transfers: tuple[MeasuredTransfer, ...]
    points: Mapping[int, Position] = field(default_factory=dict)
    window_rate: float = 0.0
    segments: Segments | None = None
    temperature: float = float("nan")
    mains: float | None = None
    notes: tuple[str, ...] = ()
    hashes: Mapping[str, str] = field(default_factory=dict)
    operator: str = ""
    date: str = ""
    without_hits: tuple[WithoutHit, ...] = field(default=(), repr=False)

    def __repr__(self) -> str:
        """Title, number and lines in one line."""
        lines = self.transfers[0].frequency
        span = f"{len(lines)} lines from {lines[0]:g} to {lines[-1]:g} Hz"
        return f"<FrfSet {self.title!r}: {len(self.transfers)} FRF{'s'[: len(self.transfers) > 1]}, {span}>"

    def __post_init__(self) -> None:
        if not self.transfers:
            raise ValueError("no FRF")
        largest = max(float(np.abs(one.h).max()) for one in self.transfers)
        if largest and not 1.0 / LARGEST_FRF < largest < LARGEST_FRF:
            raise ValueError(
                f"FRFs up to {largest:.3g}; allowed: {1.0 / LARGEST_FRF:g} to {LARGEST_FRF:g}: correct their units"
            )
        first = self.transfers[0]
        for one in self.transfers[1:]:
            same = one.frequency.shape == first.frequency.shape
            if not same or not np.allclose(one.frequency, first.frequency, rtol=1e-6):
                raise ValueError(
                    f"{one.name!r} and {first.name!r} have different frequency lines; poles are shared by FRFs of "
                    "the same lines: export or record them with the same, or take those of a universal file one "
                    "by one: flexura identify, without --shared-poles"
                )

    @property
    def frequency(self) -> NDArray[np.float64]:
        """Lines that all have, Hz."""
        return self.transfers[0].frequency

    @property
    def h(self) -> NDArray[np.complex128]:
        """FRFs, (L, F)."""
        return np.array([one.h for one in self.transfers])

    @property
    def variance(self) -> NDArray[np.float64] | None:
        """E|h - H|^2, (L, F), where it is known of all."""
        known = [one.variance for one in self.transfers if one.variance is not None]
        return np.array(known) if len(known) == len(self.transfers) else None

    def labelled(self) -> LabelledArrays:
        """FRFs over transfer and frequency, variance and coherence where known; x, y, z are of the responses."""
        lines = ("transfer", "frequency")
        fields: dict[str, tuple[tuple[str, ...], NDArray[Any]]] = {"h": (lines, self.h)}
        for name in ("variance", "coherence"):
            known = [getattr(one, name) for one in self.transfers]
            if any(one is not None for one in known):
                unknown = np.full(len(self.frequency), np.nan)
                fields[name] = lines, np.array([unknown if one is None else one for one in known])
        of_each = {
            name: (("transfer",), np.array([getattr(one, name) for one in self.transfers]))
            for name in ("name", "response", "reference", "quantity", "reference_quantity")
        }
        units = [self.unit(number) for number in range(len(self.transfers))]
        places = np.array([self._place(one.response) for one in self.transfers])
        return LabelledArrays(
            fields,
            {
                **of_each,
                "unit": (("transfer",), np.array(units)),
                **{axis: (("transfer",), places[:, k]) for k, axis in enumerate("xyz")},
                "frequency": (("frequency",), self.frequency),
            },
            {"h": " or ".join(dict.fromkeys(units)), "frequency": "Hz", **dict.fromkeys("xyz", "m")},
            self.notes,
        )

    def _place(self, end: str) -> Position:
        """Return where an end of an FRF is, m; NaN where its node is at no known place."""
        node = end.partition(":")[0]
        nowhere = (math.nan, math.nan, math.nan)
        return self.points.get(int(node), nowhere) if node.isdecimal() else nowhere

    def unit(self, number: int) -> str:
        """Return the unit of an FRF: that of its file, SI where that says none, ``?`` where neither is known."""
        one = self.transfers[number]
        if any(one.units):
            return f"{one.units[0] or '?'}/{one.units[1] or '?'}"
        if one.quantity in UNITS and one.reference_quantity in UNITS:
            return frf_unit(one.quantity, one.reference_quantity)
        return "?"

    def label(self, number: int) -> str:
        """Name an FRF's axis.

        Parameters
        ----------
        number : int
            Of the FRF, from 0.

        Returns
        -------
        str
            ``accelerance [m/s2/N]``, in the units that its file says; SI where it says none.
        """
        one, name = self.transfers[number], "FRF"
        if one.quantity in UNITS and one.reference_quantity in UNITS:
            if not any(one.units):
                return frf_label(one.quantity, one.reference_quantity)
            name = frf_name(one.quantity, one.reference_quantity)
        return f"{name} [{one.units[0] or '?'}/{one.units[1] or '?'}]"


def ends(transfers: Sequence[MeasuredTransfer]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Places of all responses and of all references, in the order of their first FRF.

    Returns
    -------
    responses, references : tuple of str
        Each place once.
    """
    responses = tuple(dict.fromkeys(one.response for one in transfers))
    return responses, tuple(dict.fromkeys(one.reference for one in transfers))


def said_of_coherence(transfers: Sequence[MeasuredTransfer]) -> list[str]:
    """Say which FRFs' coherences were of no use."""
    empty = [one.name for one in transfers if one.coherence is not None and without_information(one.coherence)]
    if not empty:
        return []
    others = f" and {len(empty) - 1} more" if len(empty) > 1 else ""
    return [
        f"{empty[0]}{others}: coherence 1 on every line, as after one average, gives no noise; its lines are "
        "weighted by the residual of the fit"
    ]


MOTIONS = frozenset({"displacement", "velocity", "acceleration", "strain", "pressure"})
"""Quantities that answer a force; as the reference of an FRF they are no input."""


def said_of_reference(transfers: Sequence[MeasuredTransfer]) -> list[str]:
    """Say that FRFs were not referred to a force, so that their peaks are not the structure's own."""
    moved = [one for one in transfers if one.reference_quantity in MOTIONS and one.quantity in MOTIONS]
    if not moved:
        return []
    first = moved[0]
    ends: tuple[Quantity, Quantity] = first.quantity, first.reference_quantity  # type: ignore[assignment]
    return [
        f"no force was measured: {frf_name(*ends)} to the reference "
        f"{first.reference}. Its peaks are where the reference stands still: modes of the structure held "
        f"there, not "
        "those of the structure as it is. On a moving base they are the modes on that base; for those of the free "
        "structure measure the force, and give it the role drive"
    ]


def with_said_of_ends(frfs: FrfSet) -> FrfSet:
    """Add notes on drive points that take no power, and on reciprocal FRFs that differ, to those of a set.

    Where a declaration does not say at which nodes drive and sensor stood they are numbered, which makes a drive
    point of the first; shapes would be scaled by it. An FRF alone has no shapes.
    """
    if len(frfs.transfers) < 2:
        return frfs
    failed = [one for one in checks(frfs.transfers, frfs.frequency) if not one.passed]
    points = [one for one in failed if len(one.names) == 1]
    pairs = [one for one in failed if len(one.names) > 1]
    said = [_said_of_drive_point(frfs, point) for point in points]
    if pairs:
        worst = max(pairs, key=lambda one: one.value)
        more = f" ({len(pairs) - 1} more pairs are apart, too)" if len(pairs) > 1 else ""
        said.append(f"{worst.names[0]}: {worst.sentence}{more}")
    return replace(frfs, notes=(*frfs.notes, *said))


def _said_of_drive_point(frfs: FrfSet, point: FrfCheck) -> str:
    """Say that it is none, and which FRF of the same drive or sensor could be, if one alone could."""
    declared = next(one for one in frfs.transfers if one.name == point.names[0])
    column = [one for one in frfs.transfers if one.reference == declared.reference and one is not declared]
    row = [one for one in frfs.transfers if one.response == declared.response and one is not declared]
    places = [(one, one.reference) for one in column] + [(one, declared.reference) for one in row]
    fits = [one.name for one, there in places if _takes_power(replace(one, response=there, reference=there), frfs)]
    instead = f"; {fits[0]} looks like one" if len(fits) == 1 else ""
    return (
        f"{declared.name}: {point.sentence}{instead}. Say under at where the drive and the sensors stood: "
        "the scale of shapes depends on it"
    )


def _takes_power(one: MeasuredTransfer, frfs: FrfSet) -> bool:
    return any(check.passed for check in checks([one], frfs.frequency))


def require_one_of_each(transfers: Sequence[MeasuredTransfer], remedy: str) -> None:
    """Raise ValueError, with the remedy, where two FRFs of a quantity have the same ends; node 0 names none."""
    seen: dict[tuple[str, str, str], MeasuredTransfer] = {}
    for one in transfers:
        if one.response.startswith("0:") or one.reference.startswith("0:"):
            continue
        pair = one.response, one.reference, one.quantity
        if pair in seen:
            raise ValueError(
                f"node {one.response} answers node {one.reference} more than once, as {seen[pair].name!r} and "
                f"{one.name!r}; {remedy}"
            )
        seen[pair] = one


def require_convention(transfers: Sequence[MeasuredTransfer]) -> None:
    """Raise ValueError where FRFs of equal lines are those of the other time convention."""
    if len({one.h.shape for one in transfers}) == 1 and turns_backward(np.array([one.h for one in transfers])):
        raise ValueError(
            "the phase rises through resonances, as with the time convention exp(-jwt) or with response and "
            "reference exchanged; exp(+jwt) is needed: export the complex conjugate"
        )


def cut(frfs: FrfSet, band: tuple[float, float] | None) -> FrfSet:
    """Return the FRFs inside a band.

    Parameters
    ----------
    band : (float, float) or None
        Hz, both ends included; None for all lines.

    Raises
    ------
    ResultFileError
        Where fewer than 8 lines are in it.
    """
    if band is None:
        return frfs
    try:
        inside = lines_inside(frfs.frequency, band)
    except ValueError as error:
        raise ResultFileError(f"{frfs.title}: {error}") from error
    parts = tuple(
        replace(
            one,
            frequency=one.frequency[inside],
            h=one.h[inside],
            variance=None if one.variance is None else one.variance[inside],
            coherence=None if one.coherence is None else one.coherence[inside],
        )
        for one in frfs.transfers
    )
    hits = tuple(replace(one, h=one.h[:, inside]) for one in frfs.without_hits)
    return replace(frfs, transfers=parts, without_hits=hits)
