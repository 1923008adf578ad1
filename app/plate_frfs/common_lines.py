"""Lines that all FRFs of a plate share: evenly spaced, inside the band."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.experiment import LEAST_LINES

LARGEST_UNEVENNESS = 1e-3
"""Part of the spacing by which a line may lie off an even grid: files keep six digits of a frequency."""


@dataclass(frozen=True)
class CommonLines:
    """Evenly spaced lines.

    Attributes
    ----------
    first : float
        Hz.
    spacing : float
        Hz.
    count : int
    """

    first: float
    spacing: float
    count: int

    @property
    def frequency(self) -> Real:
        """(F,) ndarray, Hz."""
        return np.asarray(self.first + self.spacing * np.arange(self.count))

    def inside(self, frequency: Real) -> slice:
        """Return where the lines are among those of an FRF that `common_lines` has seen."""
        start = int(np.argmin(np.abs(frequency - self.first)))
        return slice(start, start + self.count)


def common_lines(named: Sequence[tuple[str, Real]], band: tuple[float, float] | None) -> CommonLines:
    """Find the lines that all FRFs have, inside a band.

    Parameters
    ----------
    named : sequence of (str, (F,) ndarray)
        File and FRF for messages, and its lines, Hz; one at least.
    band : (float, float) or None
        Hz; None for all.

    Returns
    -------
    CommonLines

    Raises
    ------
    ValueError
        For lines that are not even, of different spacing, that lie between each other, or too few in common.
    """
    name, lines = named[0]
    spacing = float(lines[-1] - lines[0]) / (len(lines) - 1)
    low, high = (0.0, np.inf) if band is None else band
    for one, frequency in named:
        own = float(frequency[-1] - frequency[0]) / (len(frequency) - 1)
        off = np.abs(frequency - frequency[0] - own * np.arange(len(frequency))).max()
        # frequencies written with few digits are off by rounding, which grows with the frequency
        if off > max(LARGEST_UNEVENNESS * own, 1e-5 * float(frequency[-1])):
            raise ValueError(f"{one}: its lines are not evenly spaced; export it with lines of one spacing")
        apart = (float(frequency[0]) - float(lines[0])) / spacing
        if abs(own / spacing - 1.0) * len(frequency) > 0.1 or abs(apart - round(apart)) > 0.1:
            raise ValueError(
                f"{one}: lines every {own:.6g} Hz from {frequency[0]:.6g} Hz, {name} every {spacing:.6g} Hz from "
                f"{lines[0]:.6g} Hz; all FRFs of a plate share their lines: export them alike, or make a "
                "plate.toml of each"
            )
        low, high = max(low, float(frequency[0])), min(high, float(frequency[-1]))
    tolerance = 0.01 * spacing  # a band of round numbers, and lines with the rounding of a file
    begin = int(np.ceil((low - float(lines[0]) - tolerance) / spacing))
    end = int(np.floor((high - float(lines[0]) + tolerance) / spacing))
    if end - begin + 1 < LEAST_LINES:
        within = "" if band is None else f" inside measurement.band {[*band]} Hz"
        raise ValueError(
            f"{max(end - begin + 1, 0)} lines that all FRFs have{within}; {LEAST_LINES} wanted: {name} from "
            f" {lines[0]:g} to {lines[-1]:g} Hz"
        )
    return CommonLines(float(lines[0]) + begin * spacing, spacing, end - begin + 1)
