"""Time responses in universal files (data set 58, function type 1), through pyuff, by node and direction.

A step stands in such a file with six digits, which is enough; times of samples in uneven form, too, so that their
spacing varies by far more than 1e-3 late in a record.
"""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimation.sampling import is_default, of_step, of_times
from app.files.measurements.columns import Columns, add_rate, unused_name
from app.files.uff.frfs import dof, functions
from app.files.uff.opening import in_seconds, unit_of

TIME = 1
NAMES = ("rsp_ent_name", "id1", "id2", "id4", "id5")
"""Texts in the head of a response that may name its channel; the third line is usually its date."""


def read(path: Path) -> Columns:
    """Read every time response; where the same ones follow again and again, each time as a group, ``run 2``.

    Parameters
    ----------
    path : Path
        Universal file with data sets 58.

    Returns
    -------
    Columns
        Named by node and direction; those without a node by a line of their head, if that tells them apart.

    Raises
    ------
    ValueError
        Where there is none, with what there is; where one is cut short.
    """
    held = [data for data in functions(path) if int(data["func_type"]) == TIME]
    names, run = _names_and_run(held)
    values: dict[str, np.ndarray] = {}
    by_place: dict[str, str] = {}
    described: list[tuple[str, dict[str, Any]]] = []
    channels: dict[str, str] = {}
    for number, (data, own) in enumerate(zip(held, names, strict=True)):
        before = f"run {number // run + 1}/" if run < len(held) else ""
        name = unused_name(before + own, values)
        if before:
            channels[name] = name.removeprefix(before)
        else:
            by_place[unused_name(dof(data, "rsp"), by_place)] = name
        if len(np.asarray(data["x"])) != len(np.asarray(data["data"])) or len(data["x"]) < 2:
            raise ValueError(
                f"time response {name}: {len(data['data'])} values at {len(data['x'])} times; cut short?"
            )
        values[name] = np.asarray(np.asarray(data["data"]).real, dtype=float)
        described.append((name, data))
    if not values:
        raise ValueError(
            "no time response (data set 58, function type 1); for the modes and shapes of FRFs type: "
            "flexura identify FILE.uff --shared-poles --out RUN"
        )
    columns = Columns(values, channels=channels, aliases={a: n for a, n in by_place.items() if a not in values})
    for name, data in described:
        _describe(columns, name, data)
    return columns


def _describe(columns: Columns, name: str, data: dict[str, Any]) -> None:
    """Add a response's unit, place, rate and start."""
    if place := _place(data):
        columns.places[name] = place
    if unit := unit_of(data, "ordinate"):
        columns.units[name] = unit
    try:
        time = np.asarray(data["x"], dtype=float) * in_seconds(data)
        step = float(data.get("abscissa_inc", 0.0)) * in_seconds(data)
        if int(data.get("abscissa_spacing", 1)) == 0:
            add_rate(columns, name, [of_times(time, f"times of {name}")])
        elif is_default(step) or not step > 0.0:
            add_rate(columns, name, [], "the abscissa's increment")
        else:
            add_rate(columns, name, [of_step(step, "the abscissa's increment")])
        columns.starts[name] = float(time[0])
    except ValueError as error:
        columns.doubts[name] = str(error)


def _names_and_run(held: list[dict[str, Any]]) -> tuple[list[str], int]:
    """Name every response, and say after how many the same ones begin again.

    By node and direction; by a text of the head where there is no node, or two of a run have the same.
    """
    ends, texts = [dof(data, "rsp") for data in held], _telling_texts(held)
    plain = [
        (end, data.get("ordinate_spec_data_type"), unit_of(data, "ordinate"))
        for end, data in zip(ends, held, strict=True)
    ]
    kinds = [(*kind, text) for kind, text in zip(plain, texts, strict=True)]
    run = _run_length(kinds)
    if run == len(held) and not all(end.startswith("0:") for end in ends):
        run = _run_length(plain)
    often = Counter(ends[:run])
    return [
        text if text and (end.startswith("0:") or often[end] > 1) else end
        for end, text in zip(ends, texts, strict=True)
    ], run


def _telling_texts(held: list[dict[str, Any]]) -> list[str]:
    """Text of every response's head, from the line that tells them apart; empty where none does."""
    lines = {key: [str(data.get(key, "")).strip() for data in held] for key in NAMES}
    told = [texts for texts in lines.values() if len(set(texts)) > 1 and not {"", "NONE"} & set(texts)]
    # a line that repeats from run to run names channels; one that is new every time numbers records
    best = max(told, key=lambda texts: (_repeats(texts), len(set(texts))), default=None)
    return best or [""] * len(held)


def _repeats(texts: list[str]) -> bool:
    return _run_length([(text,) for text in texts]) < len(texts)


def _run_length(kinds: list[tuple[Any, ...]]) -> int:
    """Return after how many responses the same ones begin again, two at least; all where they do not.

    A run holds no two of a kind: of four channels that nothing tells apart the third is not the first one again.
    """
    lengths = (n for n in range(2, len(kinds)) if len(kinds) % n == 0 and len(set(kinds[:n])) == n)
    return next((n for n in lengths if kinds == kinds[:n] * (len(kinds) // n)), len(kinds))


def _place(data: dict[str, Any]) -> str:
    """Node and direction of a response as in declarations, ``5:+z``; empty where it is not along an axis."""
    node, direction = int(data.get("rsp_node", 0)), int(data.get("rsp_dir", 0))
    if node < 1 or not 1 <= abs(direction) <= 3:
        return ""
    return f"{node}:{'+' if direction > 0 else '-'}{'xyz'[abs(direction) - 1]}"
