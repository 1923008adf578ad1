"""Sample rates as files give them: by times or by one step, each with the error that its digits leave.

Times t_k = t_0 + k/f of a converter are even. What differs is the rounding of what was written: half a unit of the
last digit, whatever the length of the record. A tolerance that grows with the record would let samples be missing.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_DIGITS = 12
"""Decimals, and significant digits, beyond which numbers are called exact; double precision holds 15."""
EARLY_SAMPLES = 100
"""Samples in which times have to rise: later ones of six digits may be rounded to more than a step."""
SINGLE_PRECISION = 1.2e-7
"""Relative rounding of times that were kept in single precision."""
LARGEST_TIME_ERROR = 0.5
"""Of a step, by which one time may be off besides its rounding. A missing sample moves all times after it by one
step, and a line through both parts misses by half a step next to the gap."""
LARGEST_RATE_ERROR = 1e-4
"""Largest relative error of a rate that is used. An error of the rate is one of every frequency; this one is a
hundredth of the half-power bandwidth at a damping ratio of 0.5 %."""
EXACT_RATE_ERROR = 1e-9
"""Relative distance from a plain number of hertz that double precision leaves."""
ROUNDED_DIGITS = 3
"""Significant digits from which a step that is no plain rate looks like a rounded one: 0.000977 s, not "
"0.0015 s."""
CLOCKS = (51200.0, 102400.0, 50000.0, 48000.0, 44100.0, 65536.0, 131072.0, 1e5)
"""Hz, which converters divide by products of 2, 3 and 5: a step of few digits may be that of any of them."""


@dataclass(frozen=True)
class RateSeen:
    """A sample rate that one place in a file gives.

    Attributes
    ----------
    rate : float
        Hz.
    error : float
        By which its digits may be wrong, relative.
    place : str
        Where it stands, for messages: ``its times``, ``Delta_X = 0.000977``.
    """

    rate: float
    error: float
    place: str

    def agrees(self, other: "RateSeen") -> bool:
        """Whether both can be the same rate."""
        return abs(self.rate / other.rate - 1.0) <= 1.5 * (self.error + other.error) + 1e-6


def of_times(time: NDArray[np.float64], place: str = "its times") -> RateSeen:
    """Rate of samples by their times.

    Parameters
    ----------
    time : (N,) ndarray
        s.
    place : str
        For messages.

    Raises
    ------
    ValueError
        Where they do not rise, or are not even within their rounding and half a step: samples are missing.
    """
    if len(time) < 3 or not np.isfinite(time).all():
        raise ValueError(f"{place}: {len(time)} times, or some not finite; three at least are needed")
    count, number = len(time), np.arange(len(time))
    quantum = _quanta(time)
    span = float(time[-1] - time[0])
    early = float(quantum[1 : 1 + EARLY_SAMPLES].min())
    if span <= 0.0 or (np.diff(time) < -quantum[1:]).any() or early > 1.2 * span / (count - 1):
        raise ValueError(f"{place}: times do not rise; export them with more digits, or give sample_rate in Hz")
    step = span / (count - 1)
    coarsest = float(quantum.max())
    if (np.diff(time) <= 0.0).any() and coarsest < 0.5 * step:
        raise ValueError(f"{place}: times do not rise, one occurs twice; give sample_rate in Hz if all is there")
    _require_even(time, quantum, place)
    slope, start = np.polyfit(number, time - time[0], 1)
    off = float(np.abs(time - time[0] - start - slope * number).max())
    # rounding that differs from sample to sample averages out over the fit (uniform: quantum / sqrt 12 each);
    # rounding that is the same throughout may hide half a quantum over the whole record
    left = coarsest / np.sqrt(count) if off > 0.25 * coarsest else 0.5 * coarsest
    rate = 1.0 / float(slope)
    exact = off < 1e-6 * step and _plain(rate)
    return RateSeen(float(np.round(rate, 3)) if exact else rate, 0.0 if exact else float(left / span), place)


def of_step(step: float, place: str, written: str = "") -> RateSeen:
    """Rate by the step between samples.

    Parameters
    ----------
    step : float
        s, above zero.
    place : str
        What the file calls it.
    written : str
        As it stands in a file of text, whose last digit tells its rounding; empty where it is a binary number.

    Returns
    -------
    RateSeen
        Its error is 0 where one over the step is a plain number of hertz: then the step is no rounded one. Zeros
        at the end show that it was written with fixed decimals; then no usual clock may give the same digits,
        either.
    """
    text = written.strip() or f"{step:.15g}"
    mantissa, _, exponent = text.lower().replace(",", ".").replace("d", "e").partition("e")
    decimals = len(mantissa.partition(".")[2]) - int(exponent or 0)
    digits = mantissa.replace(".", "").lstrip("-+0")
    padded = bool(written) and "." in mantissa and digits.endswith("0")
    rate, error = 1.0 / step, 0.5 * 10.0**-decimals / step
    if (_plain(rate) and not (padded and _rivals(rate, error))) or (len(digits) < ROUNDED_DIGITS and not padded):
        error = 0.0
    return RateSeen(rate, error, f"{place} = {text}")


def is_default(step: float) -> bool:
    """Whether a step is that of programs which were not told any: 1 s, at which no vibration is recorded."""
    return step == 1.0


def settled(seen: Sequence[RateSeen]) -> float:
    """Return the rate that all places give, by the one with the most digits.

    Parameters
    ----------
    seen : sequence of RateSeen
        One at least.

    Returns
    -------
    float
        Hz.

    Raises
    ------
    ValueError
        Where two contradict each other, or none has enough digits.
    """
    best = min(seen, key=lambda one: one.error)
    for one in seen:
        if not one.agrees(best):
            told = " and ".join(f"{other.rate:.9g} Hz by {other.place}" for other in seen if other in (one, best))
            raise ValueError(
                f"two sample rates: {told}; find out which is right, and declare it: sample_rate = ... in Hz "
                "(flexura new test: --rate)"
            )
    if best.error > LARGEST_RATE_ERROR:
        raise ValueError(
            f"{best.place} has too few digits: the sample rate is {best.rate:.6g} Hz within "
            f"{100 * best.error:.2g} %, and all frequencies would be as wrong; declare sample_rate = ... in Hz "
            "(flexura new test: --rate), or export more digits"
        )
    return best.rate


def _plain(rate: float) -> bool:
    """Whether a rate has three decimals at most, as rates that people and clocks set."""
    return bool(abs(rate - np.round(rate, 3)) < EXACT_RATE_ERROR * rate)


def _rivals(rate: float, error: float) -> list[float]:
    """Other rates that a usual clock gives and that are as near as `error`."""
    found = []
    for clock in CLOCKS:
        for divisor in {int(clock // rate), int(clock // rate) + 1} - {0}:
            left = divisor
            for prime in (2, 3, 5):
                while left % prime == 0:
                    left //= prime
            if left == 1 and EXACT_RATE_ERROR < abs(clock / divisor / rate - 1.0) <= error:
                found.append(clock / divisor)
    return found


def _quanta(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit of the last digit of every time, s: of as many decimals, or digits, as all have."""
    size = np.abs(time)
    decade = np.floor(np.log10(np.where(size > 0.0, size, 1.0)))
    decimals = next(
        (n for n in range(MOST_DIGITS + 1) if _all_rounded(time, np.full(len(time), float(n)))), MOST_DIGITS
    )
    digits = next((n for n in range(1, MOST_DIGITS + 1) if _all_rounded(time, n - 1.0 - decade)), None)
    by_digits = np.where(size > 0.0, 10.0 ** (decade + 1.0 - digits), 0.0) if digits else np.zeros(len(time))
    single = SINGLE_PRECISION if (time == time.astype(np.float32)).all() else float(np.finfo(float).eps)
    return np.asarray(np.maximum(np.maximum(10.0**-decimals, by_digits), single * size))


def _all_rounded(time: NDArray[np.float64], decimals: NDArray[np.float64]) -> bool:
    """Whether every time has no more than its number of decimals."""
    power = 10.0**decimals
    scaled = time * power
    step = float(time[-1] - time[0]) / (
        len(time) - 1
    )  # late times are near a coarse grid that steps do not follow
    allowed = np.minimum(1e-6, 1e-3 * step * power) + 4e-16 * np.abs(scaled)
    return bool((np.abs(scaled - np.round(scaled)) <= allowed).all())


def _require_even(time: NDArray[np.float64], quantum: NDArray[np.float64], place: str) -> None:
    """Raise ValueError, with the largest gap, where times are not even."""
    steps = np.diff(time)
    usual = float(np.median(steps)) or float(time[-1] - time[0]) / len(steps)
    if float(quantum.max()) > 0.25 * usual:  # rounded steps are 0, 1 or 2 quanta; their mean tells more
        usual = float(time[-1] - time[0]) / len(steps)
    allowed = LARGEST_TIME_ERROR * usual + quantum[1:] + quantum[:-1]
    widest = int(np.argmax(np.abs(steps - usual) - allowed))
    even = time[0] + np.arange(len(time)) * (time[-1] - time[0]) / len(steps)
    off = np.abs(time - even) - quantum - quantum[0] - quantum[-1]
    if abs(steps[widest] - usual) > allowed[widest]:
        lost = round(float(steps[widest]) / usual) - 1
        raise ValueError(
            f"{place} are not evenly spaced: {steps[widest]:.6g} s pass after {time[widest]:.6g} s, {usual:.6g} s "
            f"otherwise; about {lost} samples are missing, or it was resampled; record without gaps, or "
            f"export the "
            "part before or after"
        )
    if off.max() > LARGEST_TIME_ERROR * usual:
        raise ValueError(
            f"{place} are not evenly spaced: at {time[int(np.argmax(off))]:.6g} s they are "
            f"{off.max() / usual:.3g} "
            "samples off a constant rate; samples are missing, or it was resampled; record without gaps"
        )
