"""Blows of an impact hammer in a recording: where each begins, and why some do not count."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.spectra import SampledSignals, Spectra, clipped, of_blocks
from analysis.estimation.windows import RingdownWindow, force_window

USUAL_PRETRIGGER = 0.005
"""s before the trigger: a flank of a soft tip, and samples at rest of which the offset is taken."""

PULSE_END = 0.05
"""Share of its largest force below which a blow is over."""

CUT_SHORT = "cut short"
"""Begins the reason of a blow whose block the recording does not hold whole."""


@dataclass(frozen=True)
class HammerTest:
    """How blows are found and windowed.

    Attributes
    ----------
    trigger : float
        Force at which a blow begins, N; or None: a tenth of the largest force of the recording.
    pretrigger : float or None
        Of a block before the trigger, s; None for `USUAL_PRETRIGGER`, or as much as stands before the first blow:
        analysers that trigger themselves keep a millisecond.
    duration : float or None
        Of a block, s; None for as long as the shortest time between two blows lets be.
    double_hit : float
        Second peak of the force, as a share of the first, from which a block is left out.
    force_window : bool
        Whether the force is set to zero after the blow.
    exponential : float
        Value of the exponential window at the end of a block; 1 for none.
    coupling : float or None
        Where the AC coupling of all channels has lost 3 dB, Hz; None where they couple DC, or it is not known.
        Then the force comes back below zero after a blow, and the window cuts that off, while the responses keep
        what the coupling has done to them: a phase of coupling / frequency, 8 mrad at 60 Hz for one of 0.5 Hz.
    """

    trigger: float | None = None
    pretrigger: float | None = None
    duration: float | None = None
    double_hit: float = 0.1
    force_window: bool = True
    exponential: float = 1.0
    coupling: float | None = None

    def __post_init__(self) -> None:
        if self.trigger is not None and not self.trigger > 0.0:
            raise ValueError(f"trigger {self.trigger:g} N; above 0 allowed")
        if self.pretrigger is not None and not 0.0 <= self.pretrigger <= 10.0:
            raise ValueError(f"pretrigger {self.pretrigger:g} s; 0 to 10 allowed")
        if self.duration is not None and not self.duration > (self.pretrigger or 0.0):
            raise ValueError(
                f"duration {self.duration:g} s; more than the pretrigger of {self.pretrigger or 0:g} s"
            )
        if self.coupling is not None and not 0.0 < self.coupling <= 100.0:
            raise ValueError(f"coupling {self.coupling:g} Hz; above 0 to 100 allowed")
        if not 0.0 < self.double_hit <= 1.0:
            raise ValueError(f"double_hit {self.double_hit:g}; above 0 to 1 allowed")


@dataclass(frozen=True)
class Hit:
    """One blow.

    Attributes
    ----------
    start : int
        First sample of its block, the pretrigger included.
    pulse : (int, int)
        Samples of the block between which the force acts.
    peak : float
        Largest force, N.
    rejected : str
        Why it does not count; empty where it does.
    """

    start: int
    pulse: tuple[int, int]
    peak: float
    rejected: str = ""


@dataclass(frozen=True)
class Blows:
    """Blows of one recording, all of one block length.

    Attributes
    ----------
    recording : SampledSignals
    hits : tuple of Hit
        In the order of time, rejected ones too.
    samples : int
        Of a block.
    test : HammerTest
    before : int
        Samples of a block before the trigger.
    """

    recording: SampledSignals
    hits: tuple[Hit, ...]
    samples: int
    test: HammerTest
    before: int

    @property
    def window(self) -> RingdownWindow:
        """The exponential window."""
        return RingdownWindow.falling_to(self.test.exponential, self.samples / self.recording.rate)

    @property
    def kept(self) -> tuple[Hit, ...]:
        """Blows that count."""
        return tuple(hit for hit in self.hits if not hit.rejected)

    def blocks(self, windowed: bool = True) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Force (B, 1, N) and responses (B, K, N) of the blows that count, each less its mean before the blow."""
        rate, pre = self.recording.rate, self.before
        decay = self.window.values(self.samples, rate) if windowed else 1.0
        force, answers = [], []
        for hit in self.kept:
            span = slice(hit.start, hit.start + self.samples)
            u, y = self.recording.drives[:, span], self.recording.responses[:, span]
            before = max(hit.pulse[0], 0)
            if pre and before >= 4:
                u = u - u[:, :before].mean(axis=1, keepdims=True)
                y = y - y[:, :before].mean(axis=1, keepdims=True)
            if windowed and self.test.force_window:
                u = _windowed(u, force_window(self.samples, *hit.pulse), rate, self.test.coupling)
            force.append(u * decay)
            answers.append(y * decay)
        return np.array(force), np.array(answers)

    def spectra(self) -> Spectra:
        """Spectra of the blows that count; ValueError where none does."""
        if not self.kept:
            why = "; ".join(dict.fromkeys(hit.rejected for hit in self.hits))
            onward = "record this point again"
            if all(hit.rejected.startswith(CUT_SHORT) for hit in self.hits):
                onward = "shorten hammer.pretrigger or hammer.duration, or " + onward
            raise ValueError(f"none of {len(self.hits)} blows counts ({why}); {onward}")
        return of_blocks(*self.blocks(), self.recording.rate)


def _windowed(
    force: NDArray[np.float64], window: NDArray[np.float64], rate: float, coupling: float | None
) -> NDArray[np.float64]:
    """Return a force (1, N) behind its window: as it was before the coupling, windowed, and coupled again.

    A capacitor makes of u(t) the v with v' = u' - a v, a = 2 pi coupling; so u = v + a integral of v, which runs
    away on noise, but not within a blow.
    """
    if coupling is None:
        return np.asarray(force * window)
    from scipy.signal import butter, lfilter  # declarations of tests import this module, and must be read at once

    numerator, denominator = butter(1, coupling, btype="highpass", fs=rate)
    before = lfilter(denominator, numerator, force, axis=-1)
    return np.asarray(lfilter(numerator, denominator, before * window, axis=-1))


def find_blows(
    recording: SampledSignals,
    test: HammerTest,
    full_scales: Sequence[float | None] | None = None,
    names: Sequence[str | None] | None = None,
) -> Blows:
    """Find the blows of a recording with one drive, and reject double hits, overloads and those cut short.

    Parameters
    ----------
    full_scales : sequence, optional
        Largest value that the drive and each response can have, SI; None where it is not known.
    names : sequence of str, optional
        Of the drive and of each response, for messages.

    Raises
    ------
    ValueError
        Where there are several drives, or no force reaches the trigger.
    """
    if len(recording.drives) != 1:
        raise ValueError(f"{len(recording.drives)} drives; a hammer test has one: declare the others unused")
    force = recording.drives[0] - np.median(recording.drives[0])
    force = force if force.max() >= -force.min() else -force
    trigger = test.trigger if test.trigger is not None else 0.1 * float(force.max())
    begins = _crossings(force, trigger, recording.rate)
    if not len(begins):
        raise ValueError(
            f"no force reaches the trigger of {trigger:g} N; the largest is {force.max():g} N: lower the trigger, "
            "or check the hammer's sensitivity"
        )
    pre = _before(begins, recording.rate, test)
    samples = _length(begins, pre, recording, test)
    channels = [None] * (1 + len(recording.responses))
    limits = list(zip(full_scales or channels, names or channels, strict=True))
    hits: list[Hit] = []
    end_of_last = -1
    for begin in begins:
        if begin < end_of_last:  # inside the block of the blow before, to which it belongs
            continue
        hits.append(_hit(recording, force, int(begin) - pre, samples, pre, test, limits))
        end_of_last = int(begin) - pre + samples
    return Blows(recording, tuple(hits), samples, test, pre)


def _before(begins: NDArray[np.intp], rate: float, test: HammerTest) -> int:
    """Return how many samples of a block lie before the trigger."""
    if test.pretrigger is not None:
        return round(test.pretrigger * rate)
    # a force that is there at the first sample has begun before: that blow is cut short, and tells nothing
    first = [int(begin) for begin in begins[begins > 0][:1]]
    return min([round(USUAL_PRETRIGGER * rate), *first])


def _crossings(force: NDArray[np.float64], trigger: float, rate: float) -> NDArray[np.intp]:
    """Return the samples at which the force rises through the trigger, the flanks of a blow once."""
    above = force >= trigger
    rises = np.flatnonzero(above[1:] & ~above[:-1]) + 1
    if above[0]:
        rises = np.append(0, rises)
    if not len(rises):
        return rises
    apart = np.append(True, np.diff(rises) > max(1e-3 * rate, 2.0))
    kept: NDArray[np.intp] = rises[apart]
    return kept


def _length(begins: NDArray[np.intp], pre: int, recording: SampledSignals, test: HammerTest) -> int:
    """Return how many samples a block has: as declared, or as far as the next blow well apart."""
    if test.duration is not None:
        return round(test.duration * recording.rate)
    gaps = np.diff(np.append(begins, recording.samples))
    apart = gaps[gaps > 0.25 * np.median(gaps)]
    return max(int(apart.min()) - (pre if len(begins) > 1 else -pre), 16)


def _hit(
    recording: SampledSignals,
    force: NDArray[np.float64],
    start: int,
    samples: int,
    pre: int,
    test: HammerTest,
    limits: Sequence[tuple[float | None, str | None]],
) -> Hit:
    """Judge the blow whose block begins at `start`."""
    if start < 0 or start + samples > recording.samples:
        there = (start + pre if start < 0 else recording.samples - start) / recording.rate
        wanted = "a pretrigger of" if start < 0 else "a block of"
        needed = (pre if start < 0 else samples) / recording.rate
        return Hit(start, (pre, pre), 0.0, f"{CUT_SHORT}: {wanted} {needed:.4g} s, and {there:.4g} s are recorded")
    block = force[start : start + samples]
    first = pre + int(np.argmax(block[pre : pre + max(round(0.01 * recording.rate), 8)]))
    peak = float(block[first])
    low = np.flatnonzero(block[first:] < PULSE_END * peak)
    end = first + int(low[0]) if len(low) else samples
    before = np.flatnonzero(block[:first] < PULSE_END * peak)
    begin = int(before[-1]) if len(before) else 0
    rest, early = block[min(end + 1, samples - 1) :], block[:begin]
    rejected = ""
    if early.size and early.max() > test.double_hit * peak:
        sooner = 1e3 * (first - int(np.argmax(early))) / recording.rate
        rejected = f"double hit: {100 * early.max() / peak:.0f} % of the force {sooner:.1f} ms earlier"
    elif rest.max() > test.double_hit * peak:
        later = 1e3 * (int(np.argmax(rest)) + end + 1 - first) / recording.rate
        rejected = f"double hit: {100 * rest.max() / peak:.0f} % of the force again {later:.1f} ms later"
    signals = (recording.drives[0], *recording.responses)
    for number, (signal, (limit, name)) in enumerate(zip(signals, limits, strict=True)):
        if clipped(signal[start : start + samples], limit):
            called = name or (f"response {number}" if number else "force")
            rejected = f"overload: {called} was cut off; lower its gain or hit softer"
            break
    return Hit(start, (begin, end), peak, rejected)
