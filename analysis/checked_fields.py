"""Checks of a frozen value's fields when it is made: shape, finiteness, range and order.

Nonsense that is let in fails ten frames later, or gives a wrong result. A refusal names value and field, what it
holds and what is allowed; the reader of a file puts the file's name before it.
"""

from operator import attrgetter
from typing import Any

import numpy as np

from analysis.arrays import Numbers


def check_shapes(value: Any, /, **wanted: str) -> None:
    """Refuse fields whose sizes do not agree; fields that are None are left out.

    Parameters
    ----------
    value : dataclass
    wanted : str
        Axes of a field, or of a field's field (``aim.contrast``): a letter for a size that fields share, a number
        for itself, ``n+4`` for four more than n, as ``T 3 n+4``. A tuple of strings counts as one axis.

    Raises
    ------
    ValueError
    """
    sizes: dict[str, tuple[int, str]] = {}
    for name, axes in wanted.items():
        held = attrgetter(name)(value)
        if held is None:
            continue
        shape, words = np.shape(held), axes.split()
        allowed = f"{type(value).__name__}.{name} has shape {shape}; allowed: ({', '.join(words)})"
        if len(shape) != len(words):
            raise ValueError(allowed)
        for word, size in zip(words, shape, strict=True):
            letter, _, more = word.partition("+")
            bare = size - int(more or 0)
            given, by = (int(word), "") if word.isdigit() else sizes.setdefault(letter, (bare, name))
            if bare != given:
                raise ValueError(allowed + (f" with {letter} = {given} as in {by}" if by else ""))


def check_finite(value: Any, *names: str) -> None:
    """Refuse numbers in some fields that are NaN or infinite; fields that are None are left out."""
    for name in names:
        held = _array(value, name)
        wrong = ~np.isfinite(held)
        if wrong.any():
            raise ValueError(
                f"{_called(value, name)}: {int(wrong.sum())} of {held.size} numbers are not finite, the first is "
                f"{held[wrong][0]}"
            )


def check_range(value: Any, low: float, high: float, *names: str, unit: str = "", above: bool = False) -> None:
    """Refuse numbers outside `low` to `high` in some fields, NaN among them; None is left out.

    Parameters
    ----------
    value : dataclass
    unit : str
        In the message.
    above : bool
        Whether `low` itself is refused.

    Raises
    ------
    ValueError
    """
    for name in names:
        held = _array(value, name)
        wrong = ~((held > low if above else held >= low) & (held <= high))
        if wrong.any():
            first, unit_said = held[wrong][0], f" {unit}" if unit else ""
            up_to = "" if high == np.inf else f" to {high:g}"
            raise ValueError(
                f"{_called(value, name)} is {first:g}{unit_said}; allowed: "
                f"{'above' if above else 'from'} {low:g}{up_to}{unit_said}"
            )


def check_ascending(value: Any, *names: str, equal: bool = False) -> None:
    """Refuse fields (N,) whose numbers do not ascend; `equal` neighbours may be allowed."""
    for name in names:
        held = _array(value, name)
        step = np.diff(held)
        wrong = ~(step >= 0.0 if equal else step > 0.0)
        if wrong.any():
            place = int(np.argmax(wrong))
            raise ValueError(
                f"{_called(value, name)} must ascend; {held[place]:g} is followed by {held[place + 1]:g}"
            )


def _array(value: Any, name: str) -> Numbers:
    """Return a field as an array, an empty one where it is None."""
    held = attrgetter(name)(value)
    return np.zeros(0) if held is None else np.asarray(held)


def _called(value: Any, name: str) -> str:
    return f"{type(value).__name__}.{name}"
