"""What ``flexura thermometer`` prints: a record and one line."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.arrays import Real

if TYPE_CHECKING:  # a run is told to be of another kind before what computes is imported
    from app.sound.stretch import RecordingStretch


def record(
    stretches: "list[RecordingStretch]", by_laws: float, true: Real | None, target: Path | None
) -> dict[str, Any]:
    """Return what ``--json`` prints; null where a stretch was refused.

    Parameters
    ----------
    stretches : (n,) list of RecordingStretch
        At least one.
    by_laws : float
        Standard deviation of the last temperature by the law of E, K; infinite where there is none.
    true : (n,) ndarray or None
        True temperatures, degrees Celsius; None where they are not known.
    target : Path or None
        File of the readings.

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    accepted = [stretch for stretch in stretches if not stretch.reading.refused]
    last = stretches[-1]
    found: dict[str, Any] = {
        "file": None if target is None else str(target),
        "stretches": len(stretches),
        "refused": len(stretches) - len(accepted),
        "temperature_c": last.temperature if accepted else None,
        "sigma_k": last.sigma if accepted else None,
        "sigma_by_laws_k": by_laws if math.isfinite(by_laws) else None,
        "readings": [
            {
                "time_s": stretch.time,
                "temperature_c": None if stretch.reading.refused else stretch.reading.temperature,
                "sigma_k": None if stretch.reading.refused else stretch.reading.sigma,
                "explained": stretch.reading.explained,
                "refused": stretch.reading.refused,
            }
            for stretch in stretches
        ],
    }
    if true is not None and accepted:
        found["rms_error_k"] = _rms(stretches, true)
    return found


def summary(stretches: "list[RecordingStretch]", by_laws: float, true: Real | None, target: Path | None) -> str:
    """Return one line for people.

    Parameters
    ----------
    stretches : (n,) list of RecordingStretch
        At least one.
    by_laws : float
        Standard deviation of the last temperature by the law of E, K; infinite where there is none.
    true : (n,) ndarray or None
        True temperatures, degrees Celsius; None where they are not known.
    target : Path or None
        File of the readings.
    """
    last = stretches[-1]
    refused = sum(bool(stretch.reading.refused) for stretch in stretches)
    line = (
        f"{last.temperature:.2f} ± {last.sigma:.2f} °C at the end by noise, "
        f"± {by_laws:.2f} by the law of E; {len(stretches)} stretches, {refused} refused"
    )
    if true is not None:
        line += f"; rms error {_rms(stretches, true):.3f} K"
    return line if target is None else f"{line}; {target}"


def _rms(stretches: "list[RecordingStretch]", true: Real) -> float:
    error = np.array([stretch.temperature for stretch in stretches]) - true
    return float(np.sqrt(np.nanmean(error**2)))
