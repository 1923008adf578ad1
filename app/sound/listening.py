"""The temperature of a panel from what one of its patches answers while the others play."""

import numpy as np

from analysis.progress import Progress
from analysis.thermometry.listening import Listener
from analysis.thermometry.tracking import Track
from app.files.bad_file import ResultFileError
from app.sound.listening_panel import ListeningPanel
from app.sound.played_signals import PlayedSignals
from app.sound.stretch import RecordingStretch

TEMPERATURE_SPACING = 0.5
"""K between the temperatures at which the twin is asked; between them its answers are interpolated."""


def listened(
    panel: ListeningPanel,
    signals: PlayedSignals,
    band: tuple[float, float],
    span: tuple[float, float],
    seconds: float,
    largest_sigma: float,
    report: Progress = lambda _stage, _share: None,
) -> list[RecordingStretch]:
    """Return what every stretch of a recording says of the temperature, and the track through all.

    Parameters
    ----------
    band : (float, float)
        Hz.
    span : (float, float)
        Temperatures looked at, degrees Celsius.
    seconds : float
        Length of a stretch, s.
    largest_sigma : float
        A reading less certain than this is refused, K.
    report : callable, optional
        Called with the stage's name and the share done.

    Raises
    ------
    ResultFileError
        For signals shorter than a stretch.
    """
    grid = np.linspace(*span, max(round((span[1] - span[0]) / TEMPERATURE_SPACING), 8) + 1)
    listener = Listener.of(panel, grid, signals.sample_rate, band, seconds, largest_sigma)
    count, behind = len(signals.response), listener.whole - listener.before
    if count < listener.whole:
        raise ResultFileError(
            f"{count / signals.sample_rate:.1f} s of sound are too short for a stretch of {seconds:g} s, the "
            f"{(listener.whole - listener.frame) / signals.sample_rate:.1f} s about it included"
        )
    track, stretches = Track(), []
    for first in range(listener.before, count - behind + 1, listener.frame):
        drive = signals.drive[:, first - listener.before : first + behind]
        reading = listener.read(drive, signals.response[first : first + listener.frame])
        track.step(reading, listener.frame / signals.sample_rate)
        middle = (first + 0.5 * listener.frame) / signals.sample_rate
        stretches.append(RecordingStretch(middle, reading, track.temperature, track.sigma))
        report("Listening", min((first + listener.frame) / count, 1.0))
    report("Listening", 1.0)
    return stretches
