"""FRFs of a universal file as those of one structure."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from analysis.estimation.transfer import MeasuredTransfer
from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.declarations.modal_test import declares_test
from app.files.provenance import sha256
from app.files.uff.frfs import read_frfs
from app.files.uff.geometry import read_nodes
from app.modal_test.declared_test import declared_frfs
from app.modal_test.frf_set import (
    FrfSet,
    Position,
    require_convention,
    require_one_of_each,
    said_of_coherence,
    said_of_reference,
)

SHARED = (
    "are these several temperatures, levels or repeats? Poles are shared by one FRF of each pair: export one "
    "sweep (flexura identify CAMPAIGN --export FRFS.uff --temperature 20), or leave out --shared-poles, and each "
    "FRF is identified by itself"
)
"""What to do with several FRFs between the same ends."""
LARGEST_STRUCTURE = 30.0
"""m. Programs that write mm without their unit make 240 m of a plate."""


def frfs_of_file(path: Path, report: Progress) -> FrfSet:
    """Return the FRFs of a test as declared, or of a universal file as one structure.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError, CampaignFileError
        For files that cannot be used.
    """
    return declared_frfs(path, report) if declares_test(path) else of_universal(path, read_frfs(path))


def of_universal(path: Path, transfers: list[MeasuredTransfer]) -> FrfSet:
    """Return the FRFs of a universal file as those of one structure, with the nodes that the file holds.

    Parameters
    ----------
    transfers : list of MeasuredTransfer
        Read from it; those that are zero throughout are left out, with a note.

    Raises
    ------
    ResultFileError
        Where there are none, their lines differ, or two have the same ends, as those of two temperatures.
    """
    try:
        alive, dead = _alive(transfers)
        nodes, hashes = read_nodes(path), {path.name: sha256(path)}
        notes = (*dead, *said_of_reference(alive), *said_of_coherence(alive), *_said_of_extent(nodes))
        frfs = FrfSet(path.stem, tuple(alive), nodes, notes=notes, hashes=hashes)
        require_one_of_each(frfs.transfers, SHARED)
        require_convention(frfs.transfers)
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error
    return frfs


def _said_of_extent(nodes: Mapping[int, Position]) -> list[str]:
    """Say so where nodes are so far apart that their unit is probably another than was read."""
    if not nodes:
        return []
    extent = float(np.ptp(np.array(list(nodes.values())), axis=0).max())
    if extent <= LARGEST_STRUCTURE:
        return []
    return [
        f"its nodes are up to {extent:.4g} m apart; if they are in mm, export the file with data set 164, which "
        "names the unit: without one, coordinates are in m"
    ]


def _alive(transfers: Sequence[MeasuredTransfer]) -> tuple[list[MeasuredTransfer], list[str]]:
    """FRFs that are not zero throughout, and a note for each other one; all of them where none is left."""
    alive = [one for one in transfers if np.abs(one.h).any()]
    if not alive:
        return list(transfers), []
    return alive, [
        f"{one.name} ({one.response} / {one.reference}): zero on every line, a dead channel; left out"
        for one in transfers
        if not np.abs(one.h).any()
    ]
