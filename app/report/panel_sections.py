"""The report's sections on the panel: focusing, compensation."""

import base64
import io
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from analysis.arrays import Real
from app.files.bad_file import ResultFileError
from app.files.results.best_twin import BY_UPDATE
from app.files.results.panel_files import (
    load_compensation,
    load_focusing,
    load_pareto,
    load_radiation,
    load_uncorrected,
)
from app.report import focusing, paper, radiation
from app.report.page import Item, PageTable, Paragraph, Picture, Player


def focusing_section(run: Path, rows: list[paper.PaperRow]) -> list[Item]:
    """Return the filters over temperature; their figures for the paper's table are appended to `rows`."""
    panel, found, comparison = load_focusing(run / "filters.h5")
    rows.extend([*paper.method_rows(comparison), *paper.temperature_rows(found)])
    reference = f"{found.reference_temperature:g} °C"
    items: list[Item] = [
        Picture(
            "panel",
            "What is to be moved, and by which actuators?",
            focusing.layout(panel),
            "The panel: what the paper leaves open is stated in its file.",
        ),
        Picture(
            "methods",
            "What does STIF gain over other ways to drive the panel?",
            focusing.methods(comparison),
            f"All ways to drive it, complex filters (paper Fig. 4); {paper.material_of(comparison)}.",
        ),
        Picture(
            "before",
            "What does temperature do to filters that do not follow it?",
            focusing.before(found),
            f"The filters of {reference} used at every temperature (paper Fig. 13).",
        ),
    ]
    curve = load_pareto(run / "filters.h5")
    if curve is not None:
        best = curve.recommended
        caption = (
            "Filters between the best field and an even sound. Recommended: outside weight "
            f"{curve.outside_weight[best]:g}, contrast {curve.contrast[best]:.3f}, ripple ± "
            f"{curve.ripple[best]:.2f} dB, {100 * curve.drive[best]:.0f} % of the rated drive."
        )
        items.append(Picture("tradeoff", "What does an even sound cost?", focusing.tradeoff(curve), caption))
    uncorrected = load_uncorrected(run / "filters.h5")
    if uncorrected is not None:
        caption = (
            f"Filters from the corrected laws, and from those {BY_UPDATE}; both on a plate that obeys the "
            "corrected laws."
        )
        question = "What is the corrected twin worth for the filters?"
        items.append(Picture("correction", question, focusing.correction(found, uncorrected), caption))
    return items


def compensation_section(run: Path, rows: list[paper.PaperRow]) -> list[Item]:
    """Return the compensated filters; their figures for the paper's table are appended to `rows`."""
    _, found = load_compensation(run / "compensation.h5")
    rows.extend(paper.compensation_rows(found))
    items: list[Item] = [
        Picture(
            "relative-error",
            "How far are the networks' filters from those computed?",
            focusing.relative_errors(found),
            "Relative error of the filters (paper Fig. 15).",
        ),
        Picture(
            "after",
            "Does compensation bring the aim back?",
            focusing.after(found),
            "Contrast and spot error with compensation (paper Fig. 17).",
        ),
    ]
    if (run / "filters.h5").is_file():
        before = load_focusing(run / "filters.h5")[1]
        items.append(
            Picture(
                "regained",
                "How much of what temperature costs is regained?",
                focusing.loss(before, found),
                "Mean contrast of the band over temperature.",
            )
        )
    if found.weather is not None:
        caption = (
            "Worst line of the band, against filters designed for the field of temperatures itself. One: the "
            "first thermometer; all: a plane through them; own: the panel's response."
        )
        question = "What does a panel cost that is not evenly warm?"
        items.append(Picture("weather", question, focusing.lost_in_weather(found.weather), caption))
    worst = found.relative_error.max(axis=(1, 2))
    cells = [
        (
            name,
            f"{worst[m]:.2g}",
            f"{found.relative_error[m].mean():.2g}",
            f"{found.contrast_loss[m].max():.2g}",
            f"{found.seconds[m]:.2f}",
        )
        for m, name in enumerate(found.methods)
    ]
    headings = ("method", "max RE [%]", "mean RE [%]", "largest contrast loss", "seconds")
    said = "RE, relative error, eq. (13), is a ratio of energies: 0.01 % of it is 1 % of a filter's amplitude."
    return [*items, PageTable(headings, cells, numbers=(1, 2, 3, 4)), Paragraph(said)]


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
    from scipy.signal import resample_poly  # half a second of processor time, and few reports have sound

    down = max(1, int(rate // LOWEST_RATE))
    return rate // down, np.asarray(resample_poly(first, 1, down))


def _wav(samples: Real, rate: int) -> str:
    """Return 16-bit samples as a WAV file in base64."""
    stream = io.BytesIO()
    wavfile.write(stream, rate, np.clip(np.round(32_767.0 * samples), -32_768, 32_767).astype(np.int16))
    return base64.b64encode(stream.getvalue()).decode("ascii")


def radiation_section(run: Path) -> list[Item]:
    """Return the sound of the panel at its listeners."""
    panel, found = load_radiation(run / "radiation.h5")
    who = ", ".join(found.names)
    rows = [
        (
            f"{temperature:g}",
            f"{found.ripple(found.following)[t]:.2f}",
            f"{found.ripple(found.kept)[t]:.2f}",
            f"{found.following.contrast[t].mean():.3f}",
            f"{found.following.contrast[t].min():.3f}",
            f"{found.following.peak[t].max():.3g}",
        )
        for t, temperature in enumerate(found.temperature)
    ]
    headings = ("°C", "ripple [± dB]", "with filters kept", "contrast", "worst line", "peak drive")
    said = (
        f"Aim: {panel.filters.aim}. Levels are relative to the sound wanted: that of the target moving alone as "
        "asked, by the level and the curve of [sound]. Ripple is half the span of third-octave levels."
    )
    return [
        PageTable(headings, rows, numbers=(0, 1, 2, 3, 4, 5)),
        Paragraph(said),
        Picture("levels", "What does a listener hear?", radiation.levels(found), f"At: {who}; ± 1 dB is shaded."),
        Picture(
            "powers",
            "Which part of the panel radiates?",
            radiation.powers(found),
            "The power that target and rest make together is halved; a share above 1: the rest takes sound up.",
        ),
        Picture(
            "polar",
            "Where does the sound go?",
            radiation.polar(found),
            "Far away, in third-octave bands, relative to the normal of the panel.",
        ),
        *players(run),
    ]
