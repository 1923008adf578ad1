"""Modes of one sweep as rows of words, for the report and the window."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.identification.modes import Modes
from analysis.identification.reading import Damping, PoleReading

SWEEP_HEADINGS = ("mode", "f [Hz]", "σ [Hz]", "ζ [%]", "σ [%]", "η [%]", "status", "why")
NUMBERS = (0, 1, 2, 3, 4, 5)
"""Columns of numbers."""
READ_AS: dict[Damping, str] = {
    "hysteretic": "Poles are read as hysteretic: f = √(Re k) / 2π and η = Im k / Re k, with k = −pole².",
    "viscous": "Poles are read as viscous: f = |pole| / 2π and η = 2ζ.",
}
"""What frequency and loss factor mean, by the choice `--damping`."""


def reading_cells(reading: PoleReading, pole: int) -> tuple[str, str, str, str]:
    """Frequency and damping ratio of a pole, each with its standard deviation, in Hz and per cent."""
    return (
        f"{reading.frequency_hz[pole]:.3f}",
        f"{reading.sigma_frequency_hz[pole]:.2g}",
        f"{100 * reading.damping_ratio[pole]:#.4g}",
        f"{100 * reading.sigma_damping_ratio[pole]:.2g}",
    )


def sweep_rows(modes: Modes, track: NDArray[np.int64]) -> list[tuple[str, ...]]:
    """Words under `SWEEP_HEADINGS` for every mode of a sweep.

    Parameters
    ----------
    track : (J,) int ndarray
        Pole of every tracked mode, -1 for none.
    """
    reading, reasons = modes.reading(), modes.explanation()
    number = {int(pole): str(j) for j, pole in enumerate(track, start=1) if pole >= 0}
    return [
        (
            number.get(j, "–"),
            *reading_cells(reading, j),
            f"{100 * reading.loss_factor[j]:#.4g}",
            modes.standing(j),
            reasons[j],
        )
        for j in shown_poles(modes)
    ]


def shown_poles(modes: Modes) -> Sequence[int]:
    """Poles that have a row in `sweep_rows`."""
    shown: list[int] = np.flatnonzero(modes.real).tolist()
    return shown
