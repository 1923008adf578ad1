"""FRFs of a universal file as those of one structure."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analysis.estimation.transfer import MeasuredTransfer
from app.files.bad_file import ResultFileError
from app.files.provenance import sha256
from app.files.uff_nodes import read_nodes
from app.modal_test.frf_set import FrfSet, said_of_coherence


def of_universal(path: Path, transfers: list[MeasuredTransfer]) -> FrfSet:
    """Return the FRFs of a universal file as those of one structure, with the nodes that the file holds.

    Parameters
    ----------
    path : Path
    transfers : list of MeasuredTransfer
        Read from it; those that are zero throughout are left out, with a note.

    Returns
    -------
    FrfSet

    Raises
    ------
    ResultFileError
        Where there are none, their lines differ, or two have the same ends, as those of two temperatures.
    """
    try:
        alive, dead = _alive(transfers)
        notes, hashes = (*dead, *said_of_coherence(alive)), {path.name: sha256(path)}
        frfs = FrfSet(path.stem, tuple(alive), read_nodes(path), notes=notes, hashes=hashes)
        _require_one_of_each(frfs.transfers)
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error
    return frfs


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


def _require_one_of_each(transfers: Sequence[MeasuredTransfer]) -> None:
    """Raise ValueError where two FRFs of a quantity have the same ends; node 0 stands for an end not named."""
    seen: dict[tuple[str, str, str], MeasuredTransfer] = {}
    for one in transfers:
        if one.response.startswith("0:") or one.reference.startswith("0:"):
            continue
        ends = one.response, one.reference, one.quantity
        if ends in seen:
            raise ValueError(
                f"node {one.response} answers node {one.reference} more than once, as {seen[ends].name!r} and "
                f"{one.name!r}; are these several temperatures, levels or repeats? Poles are shared by one FRF of "
                "each pair: export one sweep (flexura identify CAMPAIGN --export FRFS.uff --temperature 20), or "
                "leave out --shared-poles, and each FRF is identified by itself"
            )
        seen[ends] = one
