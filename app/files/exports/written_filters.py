"""Filters written in the form that another program takes, for verb and library alike."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.focusing.temperatures import spaced
from app.files.bad_file import ResultFileError
from app.files.exports.c_code import PREFIX, write_c
from app.files.exports.numbers import write_csv, write_npz
from app.files.exports.onnx_graph import write_onnx
from app.files.exports.responses import write_wav
from app.files.exports.shipment import Shipment


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
