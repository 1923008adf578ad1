"""``transfers.h5``, ``stabilization.h5`` and ``modes.csv`` of a test at many places."""

import csv
import io
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimation.segments import Segments
from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.modes import Modes
from analysis.shapes.assurance import mpc
from analysis.shapes.participation import ModeShapes
from analysis.shapes.stabilization import StabilizationChart
from app.files.atomic import atomic_hdf5, write_text
from app.files.hdf5_file import result_file
from app.files.parsed_text import parse_json
from app.files.provenance import stamp
from app.files.values import read_value, write_value
from app.modal_test.frf_set import FrfSet

TEXTS = ("name", "response", "reference", "quantity", "reference_quantity")
COLUMNS = ("frequency_hz", "sigma_frequency_hz", "damping_ratio", "sigma_damping_ratio", "loss_factor")


def save_frfs(target: Path, frfs: FrfSet, made_from: Mapping[str, Any]) -> None:
    """Write a test's FRFs, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    record = {
        "title": frfs.title,
        "transfers": [{name: getattr(t, name) for name in TEXTS} | {"units": t.units} for t in frfs.transfers],
        "points": {str(node): place for node, place in frfs.points.items()},
        "mains": frfs.mains,
        "segments": None if frfs.segments is None else asdict(frfs.segments),
        "notes": frfs.notes,
        "hashes": dict(frfs.hashes),
        "operator": frfs.operator,
        "date": frfs.date,
    }
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        file.create_dataset("test", data=json.dumps(record))  # an attribute holds 64 KiB only
        file.attrs["window_rate"], file.attrs["temperature"] = frfs.window_rate, frfs.temperature
        file["frequency"], file["h"] = frfs.frequency, frfs.h
        for name in ("variance", "coherence"):
            values = [getattr(t, name) for t in frfs.transfers]
            if all(value is not None for value in values):
                file[name] = np.array(values)


def load_frfs(path: Path) -> FrfSet:
    """Read back what `save_frfs` wrote.

    Raises
    ------
    ResultFileError
        Where the file is missing or something else.
    """
    with result_file(path, "identify") as file:
        record = parse_json(file["test"].asstr()[()])
        frequency, h = file["frequency"][()], file["h"][()]
        known = {name: file[name][()] if name in file else [None] * len(h) for name in ("variance", "coherence")}
        transfers = tuple(
            MeasuredTransfer(
                **{name: str(one[name]) for name in TEXTS},
                units=(str(one["units"][0]), str(one["units"][1])),
                frequency=frequency,
                h=row,
                variance=variance,
                coherence=coherence,
            )
            for one, row, variance, coherence in zip(record["transfers"], h, *known.values(), strict=True)
        )
        return FrfSet(
            title=str(record["title"]),
            transfers=transfers,
            points={int(node): (float(x), float(y), float(z)) for node, (x, y, z) in record["points"].items()},
            window_rate=float(file.attrs["window_rate"]),
            temperature=float(file.attrs["temperature"]),
            mains=None if record["mains"] is None else float(record["mains"]),
            segments=None if record.get("segments") is None else Segments(**record["segments"]),
            notes=tuple(str(note) for note in record["notes"]),
            hashes={str(name): str(digest) for name, digest in record["hashes"].items()},
            operator=str(record.get("operator", "")),
            date=str(record.get("date", "")),
        )


def save_stabilization(target: Path, chart: StabilizationChart, made_from: Mapping[str, Any]) -> None:
    """Write a chart, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        write_value(file.create_group("stabilization"), chart)


def load_stabilization(path: Path) -> StabilizationChart:
    """Read back what `save_stabilization` wrote.

    Raises
    ------
    ResultFileError
        Where the file is missing or something else.
    """
    with result_file(path, "identify") as file:
        return read_value(file["stabilization"], StabilizationChart)


def write_modes_table(target: Path, modes: Modes, shapes: ModeShapes) -> None:
    """Write one row per mode as comma-separated text, its shape (real and imaginary part by place) after it.

    Parameters
    ----------
    shapes : ModeShapes
        Of these modes.
    """
    reading, reasons = modes.reading(), modes.explanation()
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    places = [f"{part} {place}" for place in shapes.places for part in ("re", "im")]
    rows.writerow(["mode", *COLUMNS, "status", "confirmation", "reason", "mpc", "rank_one", *places])
    for number, (pole, shape, collinear, share) in enumerate(
        zip(shapes.pole, shapes.shape, mpc(shapes.shape), shapes.rank_one, strict=True), start=1
    ):
        values = [f"{float(getattr(reading, name)[pole]):.9g}" for name in COLUMNS]
        parts = [f"{part:.6g}" for component in shape for part in (component.real, component.imag)]
        judged = [modes.status[pole], modes.confirmed_word(pole), reasons[pole]]
        rows.writerow([number, *values, *judged, f"{collinear:.4f}", f"{share:.4f}", *parts])
    write_text(target, stream.getvalue())
