"""An FRF or a signal as the text of a data set 58, with all the digits that its columns hold.

The format has 13 columns for a frequency and 20 for a value. Writers that fill the 13 with an exponent keep six
digits, and lines 0.01953125 Hz apart come back 3 ppm off; a plain decimal in the same columns keeps ten or more.
"""

import numpy as np

from analysis.arrays import Real
from analysis.estimation.transfer import MeasuredTransfer

TIME_FUNCTION, FRF_FUNCTION = 1, 4
TIME_TYPE, FREQUENCY_TYPE = 17, 18
QUANTITIES = {3: "strain", 8: "displacement", 11: "velocity", 12: "acceleration", 13: "force", 15: "pressure"}
GENERAL = 1
"""Of what the format has no number for: voltage, charge."""
DOUBLE_REAL, DOUBLE_COMPLEX = 4, 6
FREQUENCY_COLUMNS = 12
"""Of 13 for a frequency; one stays blank, so that numbers stand apart."""


def frf_text(frf: MeasuredTransfer) -> str:
    """Return a data set 58, delimiters included.

    Returns
    -------
    str
        Evenly spaced lines by their first and their distance, others each with its own.
    """
    numbers = {name: number for number, name in QUANTITIES.items()}
    (node, direction), (from_node, from_direction) = (
        (int(part) for part in end.split(":")) for end in (frf.response, frf.reference)
    )
    even = _even(frf)
    first, last = float(frf.frequency[0]), float(frf.frequency[-1])
    first, step = (first, (last - first) / (len(frf.frequency) - 1)) if even else (0.0, 0.0)
    ordinate = numbers.get(frf.quantity, 0 if frf.quantity == "unknown" else GENERAL)
    lines = [
        f"{-1:6d}",
        f"{58:6d}{'':74}",
        *(f"{text[:80]:80}" for text in (frf.name, "NONE", "NONE", "NONE", "NONE")),
        f"{FRF_FUNCTION:5d}{0:10d}{0:5d}{0:10d} {'NONE':10}{node:10d}{direction:4d} {'NONE':10}{from_node:10d}"
        f"{from_direction:4d}",
        f"{DOUBLE_COMPLEX:10d}{len(frf.h):10d}{int(even):10d}{_narrow(first)}{_narrow(step)}{_narrow(0.0)}",
        _axis(FREQUENCY_TYPE, "NONE"),
        _axis(ordinate, frf.units[0] or "NONE"),
        _axis(numbers.get(frf.reference_quantity, GENERAL), frf.units[1] or "NONE"),
        _axis(0, "NONE"),
        *_values(frf, even),
        f"{-1:6d}",
    ]
    return "\n".join(lines) + "\n"


def time_text(name: str, place: str, quantity: str, unit: str, samples: Real, step: float) -> str:
    """Return a data set 58 of a signal, delimiters included.

    Parameters
    ----------
    name : str
        Of the channel, in the first line of its head.
    place : str
        Node and direction, ``5:+3``.
    quantity, unit : str
        What it measures.
    samples : (N,) ndarray
    step : float
        Between samples, s.

    Returns
    -------
    str
    """
    numbers = {name: number for number, name in QUANTITIES.items()}
    node, direction = (int(part) for part in place.split(":"))
    values = [f"{value:20.12e}" for value in samples]
    lines = [
        f"{-1:6d}",
        f"{58:6d}{'':74}",
        *(f"{text[:80]:80}" for text in (name, "NONE", "NONE", "NONE", "NONE")),
        f"{TIME_FUNCTION:5d}{0:10d}{0:5d}{0:10d} {name[:10]:10}{node:10d}{direction:4d} {'NONE':10}{0:10d}{0:4d}",
        f"{DOUBLE_REAL:10d}{len(values):10d}{1:10d}{_narrow(0.0)}{_narrow(step)}{_narrow(0.0)}",
        _axis(TIME_TYPE, "s"),
        _axis(numbers.get(quantity, GENERAL), unit),
        _axis(0, "NONE"),
        _axis(0, "NONE"),
        *("".join(values[n : n + 4]) for n in range(0, len(values), 4)),
        f"{-1:6d}",
    ]
    return "\n".join(lines) + "\n"


def _axis(kind: int, unit: str) -> str:
    return f"{kind:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {unit[:20]:20}"


def _values(frf: MeasuredTransfer, even: bool) -> list[str]:
    """Two complex values in a line, or one behind its frequency."""
    pairs = [f"{value.real:20.12e}{value.imag:20.12e}" for value in frf.h]
    if even:
        return ["".join(pairs[n : n + 2]) for n in range(0, len(pairs), 2)]
    return [_narrow(float(f)) + pair for f, pair in zip(frf.frequency, pairs, strict=True)]


def _even(frf: MeasuredTransfer) -> bool:
    """Whether the lines are those that a start and an increment give."""
    even = np.linspace(frf.frequency[0], frf.frequency[-1], len(frf.frequency))
    return bool(np.allclose(frf.frequency, even, rtol=1e-9))


def _narrow(value: float) -> str:
    """Return a number in 13 columns with as many digits as they hold."""
    exact = repr(value)
    if len(exact) <= FREQUENCY_COLUMNS:
        return f"{exact:>13}"
    for digits in range(FREQUENCY_COLUMNS - 1, 0, -1):
        text = f"{value:.{digits}g}"
        if len(text) <= FREQUENCY_COLUMNS:
            return f"{text:>13}"
    return f"{value:13.5e}"
