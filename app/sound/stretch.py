"""What one stretch of a recording gives of the temperature, and the table of all stretches."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.thermometry import ThermometerReading
from app.files.atomic import written_together

NAME = "thermometer.csv"


@dataclass(frozen=True)
class RecordingStretch:
    """One stretch of a recording.

    Attributes
    ----------
    time : float
        Of its middle, s.
    reading : ThermometerReading
    temperature, sigma : float
        Of the track, degrees Celsius; NaN and infinite before the first reading.
    """

    time: float
    reading: ThermometerReading
    temperature: float
    sigma: float


def write_stretches(stretches: list[RecordingStretch], folder: Path, true: Real | None) -> Path:
    """Write ``thermometer.csv``: a row a stretch; empty where there is no number.

    Parameters
    ----------
    stretches : (n,) list of RecordingStretch
    true : (n,) ndarray or None
        True temperatures, degrees Celsius; None where they are not known.

    Returns
    -------
    Path
        Of the file.
    """
    with written_together(folder, (NAME,)) as (path,), path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        heading = [
            "time_s",
            "temperature_c",
            "sigma_k",
            "reading_c",
            "reading_sigma_k",
            "gain",
            "explained",
            "refused",
        ]
        rows.writerow(heading if true is None else [*heading, "true_c"])
        for n, stretch in enumerate(stretches):
            r = stretch.reading
            values = (
                stretch.time,
                stretch.temperature,
                stretch.sigma,
                r.temperature,
                r.sigma,
                r.gain,
                r.explained,
            )
            cells = [f"{value:.6g}" if np.isfinite(value) else "" for value in values]
            rows.writerow([*cells, r.refused] if true is None else [*cells, r.refused, f"{true[n]:.4f}"])
    return folder / NAME
