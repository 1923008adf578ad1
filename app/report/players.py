"""Short pieces of sound at the first listener, to be played on the page: filters that follow beside those kept."""

import base64
import io
from pathlib import Path

import numpy as np
from scipy.io import wavfile
from scipy.signal import resample_poly

from analysis.arrays import Real
from app.files.bad_file import ResultFileError
from app.report.page import Player

PIECE_SECONDS = 6.0
"""Of each piece."""
LOWEST_RATE = 8_000.0
"""Hz, which the band of a panel needs at least: pieces are resampled to a whole part of their rate above it."""
PEAK_LEVEL = 0.9
"""Of full scale, of the louder of both pieces."""


def players(run: Path) -> list[Player]:
    """Return the last seconds of the first sound that ``flexura render --heard`` left in a run; none without.

    Returns
    -------
    list of Player
        Both scaled by one factor, which the caption says.

    Raises
    ------
    ResultFileError
        For a file that cannot be read.
    """
    found = sorted(path for path in run.glob("*-heard.wav") if path.with_name(f"{path.stem}-kept.wav").is_file())
    if not found:
        return []
    pieces, rates = [], []
    for path in (found[0].with_name(f"{found[0].stem}-kept.wav"), found[0]):
        rate, piece = _last_seconds(path)
        pieces.append(piece)
        rates.append(rate)
    loudest = max(float(np.abs(piece).max(initial=0.0)) for piece in pieces)
    if loudest == 0.0 or rates[0] != rates[1]:
        return []
    factor = PEAK_LEVEL / loudest
    names = ("before: filters of the first temperature kept", "after: filters follow the temperature")
    caption = (
        f"{found[0].name}, its last seconds at the first listener; both at {factor:.3g} of full scale for each Pa."
    )
    files = [_wav(factor * piece, rates[0]) for piece in pieces]
    return [Player(name, data, caption) for name, data in zip(names, files, strict=True)]


def _last_seconds(path: Path) -> tuple[int, Real]:
    """Rate, Hz, and samples of the first channel, resampled, Pa."""
    try:
        rate, samples = wavfile.read(path)
    except (OSError, ValueError, EOFError) as error:
        raise ResultFileError(
            f"{path}: cannot be read as sound ({error}); make it again with flexura render --heard, or remove it"
        ) from error
    first = np.asarray(samples.reshape(len(samples), -1)[-int(PIECE_SECONDS * rate) :, 0], dtype=float)
    if not np.isfinite(first).all():
        raise ResultFileError(
            f"{path}: holds samples that are no numbers; make it again with flexura render --heard, or remove it"
        )
    down = max(1, int(rate // LOWEST_RATE))
    return rate // down, np.asarray(resample_poly(first, 1, down))


def _wav(samples: Real, rate: int) -> str:
    """Return 16-bit samples as a WAV file in base64."""
    stream = io.BytesIO()
    wavfile.write(stream, rate, np.clip(np.round(32_767.0 * samples), -32_768, 32_767).astype(np.int16))
    return base64.b64encode(stream.getvalue()).decode("ascii")
