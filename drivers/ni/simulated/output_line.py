"""The voltage on an output terminal, at any time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.ni.modules import OutputModule

INTERPOLATION_SAMPLES = 24
"""Samples on either side from which the voltage between two samples is computed: to 1e-3 up to 0.45 of it."""
SMOOTH_RATE_RATIO = 0.75
"""Samples played per sample recorded, from which on the stairs between them are not seen."""


@dataclass(frozen=True)
class _Run:
    """Samples played from `start` on; the last is held. `repeats` plays them over and over instead."""

    start: float
    rate: float
    samples: NDArray[np.float64]
    repeats: bool

    def at(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        # Moments are multiples of a sample period counted from some other start: rounding must not
        # take the sample before the one that has just begun.
        position = (moments - self.start) * self.rate
        index = np.floor(position + 1e-4).astype(np.int64)
        fraction = position - index
        if self._in_stairs(position) or not np.any(np.abs(fraction) > 1e-3):
            return self._sample(index)
        return self._between(index, np.clip(fraction, 1e-9, None))

    def _in_stairs(self, position: NDArray[np.float64]) -> bool:
        """Whether who looks is quick enough to see the stairs: behind a slower input's filter there are none."""
        return self.samples.size < 2 or position.size < 2 or float(position[1] - position[0]) < SMOOTH_RATE_RATIO

    def _sample(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        if self.repeats:
            return np.asarray(self.samples[np.maximum(index, 0) % self.samples.size])
        return np.asarray(self.samples[np.clip(index, 0, self.samples.size - 1)])

    def _between(self, index: NDArray[np.int64], fraction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the smooth voltage between samples: a sum of sinc functions under a Hann window."""
        total, angle = np.zeros(index.size), 0.5 * np.pi / INTERPOLATION_SAMPLES
        even, odd = np.cos(angle * fraction), np.sin(angle * fraction)
        for tap in range(1 - INTERPOLATION_SAMPLES, INTERPOLATION_SAMPLES + 1):
            window = (even * np.cos(angle * tap) + odd * np.sin(angle * tap)) ** 2
            total += self._sample(index + tap) * window * (-1.0) ** tap / (fraction - tap)
        return np.asarray(total * np.sin(np.pi * fraction) / np.pi)


class OutputLine:
    """What a digital-to-analog converter has put on its terminal so far, and is going to.

    It holds its last value until the next command, as the real one does: stopping a task leaves the
    voltage standing.

    Attributes
    ----------
    version : int
        Counts the changes, which shows whether results computed from it are out of date.
    """

    def __init__(self, module: OutputModule) -> None:
        self._module = module
        self._runs = [_Run(-1e9, 1.0, np.zeros(1), repeats=False)]
        self.version = 0

    def play(self, samples: NDArray[np.float64], rate: float, start: float, repeats: bool = False) -> None:
        """Play samples, rounded to the converter's codes and clipped at its full scale.

        Parameters
        ----------
        samples : (M,) ndarray
            V.
        rate : float
            Hz.
        start : float
            When the first sample comes, s on the simulation's clock.
        repeats : bool
            Begin again after the last sample, without end; otherwise the last one stands.
        """
        quantum = self._module.quantum
        reach = self._module.full_scale
        coded = np.clip(np.round(np.asarray(samples, dtype=np.float64) / quantum) * quantum, -reach, reach)
        self._runs.append(_Run(start, rate, coded, repeats))
        self.version += 1

    def extend(self, samples: NDArray[np.float64]) -> None:
        """Add samples to those being played."""
        latest = self._runs.pop()
        self.play(np.concatenate([latest.samples, samples]), latest.rate, latest.start, latest.repeats)

    def hold(self, value: float, moment: float) -> None:
        """Put a single value on the terminal."""
        self.play(np.array([value]), 1.0, moment)

    def stop(self, moment: float) -> None:
        """Hold from `moment` on what is on the terminal then."""
        self.hold(self.voltage(moment), moment)

    def voltage(self, moment: float) -> float:
        """Voltage at one moment, V."""
        return float(self.voltages(np.array([moment]))[0])

    def voltages(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """Voltages at ascending moments (M,), V."""
        values = np.empty(len(moments))
        first = np.searchsorted(moments, [run.start - 1e-4 / run.rate for run in self._runs])
        # A run that starts later overrides; runs are in the order they were begun.
        last = np.minimum.accumulate(np.append(first[1:], len(moments))[::-1])[::-1]
        for number, run in enumerate(self._runs):
            values[first[number] : last[number]] = run.at(moments[first[number] : last[number]])
        return values

    def forget_before(self, moment: float) -> None:
        """Drop samples that are not needed any more: memory must not grow during a long campaign."""
        last = max((n for n, run in enumerate(self._runs) if run.start <= moment), default=0)
        self._runs = self._runs[last:]
