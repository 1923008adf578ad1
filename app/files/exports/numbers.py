"""Filters as numbers: NPZ for Python, CSV for everything else."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.rendering.following import TanhWeights
from app.files.exports.destination import written_together
from app.files.exports.shipment import Shipment

NPZ_NAME, CSV_NAME = "flexura_filters.npz", "flexura_filters.csv"


def write_npz(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write ``flexura_filters.npz``: taps at some temperatures, and all that gives them at any other.

    Parameters
    ----------
    temperature : (T,) ndarray
        Of the taps (T, N, M), degrees Celsius.

    Returns
    -------
    (1,) tuple of Path

    Raises
    ------
    ResultFileError
        Where the folder cannot be written.
    """
    filters = shipment.filters
    held: dict[str, Any] = {
        "provenance": shipment.stamp,
        "actuators": shipment.names,
        "sample_rate": filters.sample_rate,
        "delay": filters.delay,
        "temperature": temperature,
        "taps": filters.taps(temperature),
        "input_temperature": filters.input.temperature,
        "input_value": filters.input.value,
        "banks": filters.banks,
    }
    if isinstance(filters.weights, TanhWeights):
        held |= {"slope": filters.weights.slope, "bias": filters.weights.bias}
    else:
        held |= {"knots": filters.weights.knots, "cubics": filters.weights.coefficients}
    with written_together(folder, (NPZ_NAME,)) as (path,), path.open("wb") as file:
        np.savez(file, **held)
    return (folder / NPZ_NAME,)


def write_csv(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write ``flexura_filters.csv``: one row per temperature and tap, one column per actuator.

    Taps are in V per unit of audio signal.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.

    Returns
    -------
    (1,) tuple of Path

    Raises
    ------
    ResultFileError
        Where the folder cannot be written.
    """
    filters = shipment.filters
    with written_together(folder, (CSV_NAME,)) as (path,), path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {shipment.stamp}\n")
        file.write(f"# sample rate {filters.sample_rate:g} Hz, modelling delay {filters.delay} samples\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["temperature_c", "tap", *shipment.names])
        for t, taps in zip(temperature, filters.taps(temperature), strict=True):
            rows.writerows([f"{t:g}", m, *(f"{v:.9g}" for v in tap)] for m, tap in enumerate(taps.T))
    return (folder / CSV_NAME,)
