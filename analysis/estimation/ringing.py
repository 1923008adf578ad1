"""Responses that still ring where their record ends: what leaks, and how long a record would have to be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SILENT_LEVEL = 1e-3
"""Share of its largest value to which a response is to fall within its record (-60 dB)."""

RINGING_LEVEL = 3.0
"""End of a record in standard deviations of the noise from which it rings."""

LEAST_DECAY = 0.05
"""Natural logarithm by which a response falls over the end of a record if it is a decay at all."""

DECAY_PIECES = 4
"""Of the end of a record, over which its decay is read."""


@dataclass(frozen=True)
class Ringing:
    """A response that has not come to rest.

    Attributes
    ----------
    share : float
        Of its largest value that is left at the end of the record.
    frequency : float
        At which it rings most, Hz.
    loss_factor : float
        Read from its decay.
    needed : float
        Time in which it would fall to a thousandth, counted from the end of the drive, s.
    """

    share: float
    frequency: float
    loss_factor: float
    needed: float

    def message(self, tail: float, remedy: str) -> str:
        """Return a message with the `tail` there was (s) and what to lengthen."""
        rings = f"rings on with {100 * self.share:.2g} % of its largest value at {self.frequency:.0f} Hz"
        return (
            f"{rings}: leakage widens its peaks. A loss factor of {100 * self.loss_factor:.2g} % there needs "
            f"a tail of {self.needed:.2g} s, it is {tail:.2g} s: {remedy}"
        )


def ringing(response: NDArray[np.float64], rate: float, tail: float) -> Ringing | None:
    """Look at the end of a response that is the same in every repeat.

    Parameters
    ----------
    response : (R, N) ndarray
        Repeats, or blows, of one response; what they have in common rings, what they have not is noise.
    rate : float
        Hz.
    tail : float
        Time at the end of the record in which nothing drives, s.

    Returns
    -------
    Ringing or None
        None where the response is at rest within its noise, or has fallen to a thousandth.
    """
    samples = min(round(tail * rate), response.shape[1])
    if samples < 16 * DECAY_PIECES:
        return None
    mean = response.mean(axis=0) - np.median(response)
    largest = float(np.abs(mean).max())
    if largest == 0.0:
        return None
    end = mean[len(mean) - samples :]
    pieces = np.array_split(end, DECAY_PIECES)
    levels = np.array([np.sqrt(2.0 * np.mean((piece - piece.mean()) ** 2)) for piece in pieces])
    noise = 0.0
    if len(response) > 1:
        last = response[:, response.shape[1] - len(pieces[-1]) :]
        noise = float(np.sqrt(2.0 * last.var(axis=0, ddof=1).mean() / len(response)))
    if levels[-1] <= max(SILENT_LEVEL * largest, RINGING_LEVEL * noise):
        return None
    spectrum = np.abs(np.fft.rfft((end - end.mean()) * np.hanning(len(end))))
    frequency = float(np.fft.rfftfreq(len(end), 1.0 / rate)[1 + int(np.argmax(spectrum[1:]))])
    whole = float(np.polyfit(np.arange(DECAY_PIECES) * samples / DECAY_PIECES / rate, np.log(levels), 1)[0])
    slope = _slope(end, frequency, rate)
    if min(whole, slope) * samples / rate > -LEAST_DECAY:
        return None  # a hum, whose phase was the same by chance
    slope = slope if slope < 0.1 * whole else whole  # two close modes beat, and seem to grow meanwhile
    needed = float(np.log(1.0 / SILENT_LEVEL) / -slope)
    if needed <= tail:
        return None  # this decay has ended by then: what is left is noise, of which a single response says nothing
    return Ringing(float(levels[-1] / largest), frequency, float(-slope / (np.pi * frequency)), needed)


def _slope(end: NDArray[np.float64], frequency: float, rate: float) -> float:
    """Fit the decay of the one frequency, 1/s; the whole of the signal decays as faster modes do at first."""
    length = len(end) // 2
    carrier = np.hanning(length) * np.exp(-2j * np.pi * frequency * np.arange(length) / rate)
    starts = np.linspace(0, len(end) - length, 2 * DECAY_PIECES + 1).astype(int)
    size = np.array([abs((end[start : start + length] * carrier).sum()) for start in starts])
    return float(np.polyfit(starts / rate, np.log(np.maximum(size, np.finfo(float).tiny)), 1)[0])
