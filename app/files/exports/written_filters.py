"""Filters written in the form that another program takes, for verb and library alike.

Forms of numbers are written here: NPZ for Python, CSV for everything else, WAV for any convolution engine.
"""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.focusing.responses import spaced
from analysis.rendering.following import TanhWeights
from app.files.bad_file import ResultFileError
from app.files.exports.c_code import PREFIX, write_c
from app.files.exports.destination import written_together
from app.files.exports.onnx_graph import write_onnx
from app.files.exports.shipment import Shipment
from app.files.sound_file import WavFileError, create_wav


def export_temperatures(sent: Shipment, given: Sequence[float], name: str) -> Real:
    """Return the temperatures given, each once, ascending, or every 5 °C.

    Parameters
    ----------
    name : str
        What a message calls them.

    Raises
    ------
    ResultFileError
        For one that the filters do not cover.
    """
    low, high = sent.filters.temperature_range
    for t in given:
        if not low - 1e-9 <= t <= high + 1e-9:
            raise ResultFileError(f"{name} {t:g} °C is outside what the filters cover, {low:g} to {high:g} °C")
    if len(given):
        return np.array(sorted(set(given)))
    return spaced(low, high, 5.0) if low < high else np.array([low])


def same_names(temperature: Real) -> bool:
    """Whether two temperatures would give one name of a WAV file."""
    return len({f"{t:.2f}" for t in temperature}) < len(temperature)


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


def write_wav(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write a file per temperature, one channel per actuator, float32 in V per unit of audio signal.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.

    Returns
    -------
    (T,) tuple of Path

    Raises
    ------
    ResultFileError
        For a sample rate that WAV does not hold, or a folder that cannot be written.
    """
    names = tuple(f"flexura_filters_{t:+07.2f}C.wav" for t in temperature)
    filters = shipment.filters
    taps = filters.taps(temperature)
    try:
        with written_together(folder, names) as paths:
            for path, one in zip(paths, taps, strict=True):
                with create_wav(path, filters.sample_rate, len(one), one.shape[1], shipment.stamp) as file:
                    file.write(one)
    except WavFileError as error:
        raise ResultFileError(f"{error}; take --to npz") from error
    return tuple(folder / name for name in names)


def write_filters(
    sent: Shipment,
    form: str,
    folder: Path,
    temperature: Real,
    *,
    number: str,
    prefix: str | None = None,
    example: bool = False,
    tilt: bool = False,
) -> tuple[Path, ...]:
    """Write filters as ``c``, ``onnx``, ``npz``, ``wav`` or ``csv``; return the files written.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius, for ``npz``, ``wav`` and ``csv``.
    number, prefix, example, tilt
        Of the C code, see `app.files.exports.c_code.write_c`.
    """
    if form == "c":
        return write_c(sent, folder, number == "int16", prefix or PREFIX, example, tilt)
    if form == "onnx":
        return write_onnx(sent, folder)
    return {"npz": write_npz, "wav": write_wav, "csv": write_csv}[form](sent, folder, temperature)
