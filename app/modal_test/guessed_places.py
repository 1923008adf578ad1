"""Nodes and directions of channels, as the file gives them, or numbered."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from app.files.measurements.columns import Columns

OF_MATRIX = re.compile(r".*\[([1-9]\d*),([1-9]\d*)\]")
"""``H[3,2]``, response and reference of an FRF in an array of three axes."""

OF_POINT = re.compile(
    r"(?:^|[^a-z])(?:points?|pts?|p|nodes?|n|pos(?:ition)?|dof|loc(?:ation)?|place)[ _-]*\d+$", re.I
)
"""Names of files that say where: ``point3``, ``hammer_p12``; not ``hit3``, ``run3``, which say when."""


def of_points(files: Sequence[Path]) -> bool:
    """Whether the names of several files, each another one, say at which points they were measured."""
    stems = [file.name.partition(".")[0] for file in files]
    return len(set(stems)) > 1 and all(OF_POINT.search(stem) for stem in stems)


def guessed_places(channels: Mapping[str, Mapping[str, Any]], columns: Columns) -> dict[str, dict[str, Any]]:
    """Return the channels with ``at``, and FRFs of an array of three axes with ``reference``.

    Parameters
    ----------
    channels : mapping
        Role of each column, and more.

    Returns
    -------
    dict of str to dict
        Places are those of the file; without them responses are numbered from 1, and so are drives.
    """
    taken = set(columns.places.values())
    free = [f"{node}:+z" for node in range(1, len(channels) + len(taken) + 1)]
    free = [place for place in free if place not in taken]
    placed = {name: dict(channel) for name, channel in channels.items()}
    for roles in (("response", "frf"), ("drive",)):
        nodes = iter(free)
        for name, channel in placed.items():
            if channel["role"] not in roles:
                continue
            channel["at"] = columns.places.get(name) or next(nodes)
            if channel["role"] == "frf" and name in columns.references:
                channel["reference"] = columns.references[name]
            if channel["role"] == "frf" and (found := OF_MATRIX.fullmatch(name)):
                channel["at"], channel["reference"] = (f"{node}:+z" for node in found.groups())
    return placed
