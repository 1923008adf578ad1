"""Roles of columns without names: the axis, and the two parts of one FRF."""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from app.files.measurements.columns import Columns


def of_unnamed(columns: Columns, taken: AbstractSet[str], kind: str | None) -> dict[str, dict[str, Any]]:
    """Return the roles that only order and values tell: the axis, and the parts of one FRF.

    Parameters
    ----------
    taken : set of str
        Columns that the user named.
    kind : str or None
        Of the test, as far as it is said.

    Returns
    -------
    dict of str to dict
        Of the columns that tell; empty where the columns have names.

    Raises
    ------
    ValueError
        Where the two parts of an FRF may be real and imaginary, or magnitude and phase.
    """
    names = list(columns.values)
    base = names[0].removesuffix("1]") + "{}]" if names[0].endswith("[1]") else "{}"
    numbered = names == [base.format(number) for number in range(1, len(names) + 1)]
    first = columns.values[names[0]]
    step = np.diff(first.real)
    one_way = len(step) > 1 and bool((step > 0.0).all() or (step < 0.0).all())  # sines are stepped up or down
    even = one_way and bool(np.ptp(step) < 0.1 * np.median(step))
    leads = names[0] == "1" or (numbered and even)
    if not leads or names[0] in taken or columns.rates or not (one_way if kind == "frf" else even):
        return {}
    if kind != "frf":
        return {names[0]: {"role": "time"}} if not np.iscomplexobj(first) else {}
    roles = _parts_of_frf(columns, names) if numbered and len(names) == 3 else []
    return {name: {"role": role} for name, role in zip(names, ["frequency", *roles], strict=False)}


FULL_TURNS = (np.pi, 2.0 * np.pi, 180.0, 360.0)
"""Where phases end that are wrapped, in radians and in degrees."""
LARGEST_PART_RATIO = 3.0
"""Ratio of the sizes of two parts up to which a number that could be a phase could be an imaginary part, too."""


def _parts_of_frf(columns: Columns, names: Sequence[str]) -> list[str]:
    """Roles of two columns without names: real and imaginary, or magnitude and phase; ValueError if both may be.

    A magnitude is nowhere negative, or in decibels; a phase ends near a half or a whole turn, or jumps by one.
    """
    one, other = (columns.values[name].real for name in names[1:])
    usual = [part[np.isfinite(part)] for part in (one, other)]
    if any(len(part) < 3 for part in usual):
        return ["real", "imaginary"]
    size, reach = float(np.abs(usual[0]).max()), float(np.abs(usual[1]).max())
    jumps = float(np.abs(np.diff(usual[1])).max())
    ends = any(0.9 * turn <= reach <= 1.01 * turn for turn in FULL_TURNS)
    wrapped = any(0.95 * turn <= jumps <= 1.05 * turn for turn in FULL_TURNS[1::2])
    positive = bool((usual[0] >= 0.0).all())
    within = reach <= 1.01 * FULL_TURNS[3]
    if not positive and not (within and (ends or wrapped)):
        return ["real", "imaginary"]
    if not within or reach < 0.5:  # no phase of a resonance turns by less than half a radian
        return ["real", "imaginary"]
    if positive and (ends or wrapped or not 1.0 / LARGEST_PART_RATIO < reach / (0.5 * size) < LARGEST_PART_RATIO):
        return ["magnitude", "phase"]
    raise ValueError(
        "columns 2 and 3 without names may be real and imaginary part, or magnitude and phase; write their names "
        'into the first line: "Frequency,Real,Imaginary" or "Frequency,Magnitude,Phase"'
    )
