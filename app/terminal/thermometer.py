"""What ``flexura thermometer`` tells: a record and one line."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from app.sound.look import Look


def record(looks: list[Look], by_laws: float, true: Real | None, target: Path) -> dict[str, Any]:
    """Return what ``--json`` prints; null where a stretch was refused.

    Parameters
    ----------
    looks : (n,) list of Look
        At least one.
    by_laws : float
        Standard deviation of the last temperature by the law of E, K; infinite where there is none.
    true : (n,) ndarray or None
        True temperatures, degrees Celsius; None where they are not known.
    target : Path
        File of the readings.

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    told = [look for look in looks if not look.reading.refused]
    last = looks[-1]
    found: dict[str, Any] = {
        "file": str(target),
        "stretches": len(looks),
        "refused": len(looks) - len(told),
        "temperature_c": last.temperature if told else None,
        "sigma_k": last.sigma if told else None,
        "sigma_by_laws_k": by_laws if math.isfinite(by_laws) else None,
        "readings": [
            {
                "time_s": look.time,
                "temperature_c": None if look.reading.refused else look.reading.temperature,
                "sigma_k": None if look.reading.refused else look.reading.sigma,
                "explained": look.reading.explained,
                "refused": look.reading.refused,
            }
            for look in looks
        ],
    }
    if true is not None and told:
        found["rms_error_k"] = _rms(looks, true)
    return found


def summary(looks: list[Look], by_laws: float, true: Real | None, target: Path) -> str:
    """Return one line for people.

    Parameters
    ----------
    looks : (n,) list of Look
        At least one.
    by_laws : float
        Standard deviation of the last temperature by the law of E, K; infinite where there is none.
    true : (n,) ndarray or None
        True temperatures, degrees Celsius; None where they are not known.
    target : Path
        File of the readings.

    Returns
    -------
    str
    """
    last = looks[-1]
    refused = sum(bool(look.reading.refused) for look in looks)
    line = (
        f"{last.temperature:.2f} ± {last.sigma:.2f} °C at the end by noise, "
        f"± {by_laws:.2f} by the law of E; {len(looks)} stretches, {refused} refused"
    )
    if true is not None:
        line += f"; rms error {_rms(looks, true):.3f} K"
    return f"{line}; {target}"


def _rms(looks: list[Look], true: Real) -> float:
    error = np.array([look.temperature for look in looks]) - true
    return float(np.sqrt(np.nanmean(error**2)))
