"""Modes of a test dropped or added by hand; the run folder records every change."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.finishing import finish
from analysis.identification.judgement.confirmation import confirmed
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes, Rejected
from analysis.identification.pole_search import fit
from analysis.identification.settings import Settings
from app.files.bad_file import ResultFileError
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp
from app.modal_test.edit_journal import EditJournal
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import TestModes, load_stabilization, load_test, shaped_test, write_run
from app.modal_test.without_windows import rebuilt, without_windows
from app.terminal.end_signals import held_back

BY_HAND = "added by hand"
OUT_BY_HAND = "dropped by hand"
EDITS = "edits"
"""Key of the provenance's settings that lists them, the first one first."""


def drop_mode(run: Path, frequency: float) -> str:
    """Take the mode nearest to a frequency out of a test, leave the others as they are, and save that.

    A refit would let the others move towards what is missing.

    Parameters
    ----------
    run : Path
        Run folder of a test.
    frequency : float
        Hz.

    Returns
    -------
    str
        What was done, as in the run's notes.

    Raises
    ------
    ResultFileError
        Where the run cannot be read, or has no other mode.
    """
    frfs, modes, _ = load_test(run)
    real = np.flatnonzero(modes.real)
    if len(real) < 2:
        raise ResultFileError(f"{run}: its one mode cannot be dropped; identify again with another --band")
    nearest = int(real[np.abs(modes.poles[real].imag / (2.0 * np.pi) - frequency).argmin()])
    place = float(modes.reading().frequency_hz[nearest])
    left = shaped_test(frfs, _without(frfs, modes, nearest), load_stabilization(run / "stabilization.h5"))
    return _saved(run, left, f"mode at {place:.3f} Hz {OUT_BY_HAND}")


def add_mode(run: Path, frequency: float) -> str:
    """Add a mode that starts at a frequency, with the damping usual in the test, fit all anew, and save that.

    Parameters
    ----------
    run : Path
        Run folder of a test.
    frequency : float
        Hz.

    Returns
    -------
    str
        What was done, as in the run's notes.

    Raises
    ------
    ResultFileError
        Where the run cannot be read, or the frequency is outside its band.
    """
    frfs, modes, _ = load_test(run)
    low, high = modes.band
    if not low < frequency < high:
        raise ResultFileError(f"{run}: {frequency:g} Hz; a mode can be added between {low:g} and {high:g} Hz")
    there = modes.poles - frfs.window_rate
    zeta = np.median(-there[modes.real].real / np.abs(there[modes.real])) if modes.real.any() else 0.01
    pole = 2.0 * np.pi * frequency * complex(-zeta, np.sqrt(1.0 - zeta**2))
    with result_file(run / "modes.h5", "identify") as file:
        mains = read_stamp(file)["settings"].get("mains_hz")
    fitted, order = _fitted(frfs, modes, np.append(there, pole), mains)
    by_hand = [j for j, why in enumerate(modes.reason) if why.startswith(BY_HAND)]
    fitted = _kept_by_hand(fitted, order[[*by_hand, len(there)]].tolist())
    frfs, fitted = without_windows(frfs, fitted)
    found = shaped_test(frfs, fitted, load_stabilization(run / "stabilization.h5"))
    place = float(found.modes.reading().frequency_hz[order[-1]])
    return _saved(run, found, f"mode at {place:.3f} Hz, begun at {frequency:.3f} Hz, {BY_HAND}")


def undo_edit(run: Path) -> str:
    """Take the last change by hand back; return which. ResultFileError where there is none."""
    return EditJournal(run).undo()


def redo_edit(run: Path) -> str:
    """Make the change that was taken back last again; return which. ResultFileError where there is none."""
    return EditJournal(run).redo()


def edits_of(run: Path) -> list[str]:
    """Everything that was changed by hand in a run, the first change first.

    Raises ResultFileError where the run cannot be read.
    """
    with result_file(run / "modes.h5", "identify") as file:
        return [str(one) for one in read_stamp(file)["settings"].get(EDITS, ())]


def _without(frfs: FrfSet, modes: Modes, gone: int) -> Modes:
    """Modes less one pole, which stands among those rejected as it was fitted."""
    others = [j for j in range(len(modes.poles)) if j != gone]
    words = modes.confirmation
    left = replace(
        modes,
        poles=np.delete(modes.poles, gone),
        residues=np.delete(modes.residues, gone, axis=1),
        covariance=np.delete(modes.covariance, gone, axis=0),
        rejected=(*modes.rejected, Rejected(complex(modes.poles[gone] - frfs.window_rate), OUT_BY_HAND)),
        status=tuple(modes.status[j] for j in others),
        reason=tuple(modes.reason[j] for j in others),
        confirmation=tuple(words[j] for j in others) if words else (),
    )
    over = frfs.h - rebuilt(left, frfs.frequency, frfs)
    return replace(left, misfit=float(np.sqrt((np.abs(over) ** 2).sum() / (np.abs(frfs.h) ** 2).sum())))


def _saved(run: Path, found: TestModes, done: str) -> str:
    """Write the run anew with the change in its provenance and notes."""
    with result_file(run / "modes.h5", "identify") as file:
        settings: dict[str, Any] = read_stamp(file)["settings"]
    settings[EDITS] = [*settings.get(EDITS, ()), done]
    frfs = replace(found.frfs, notes=(*found.frfs.notes, done))
    journal = EditJournal(run)
    journal.begin()
    with held_back():
        write_run(run, replace(found, frfs=frfs), settings)
        journal.made(done)
    return done


def _fitted(
    frfs: FrfSet, modes: Modes, poles: NDArray[np.complex128], mains: float | None
) -> tuple[Modes, NDArray[np.intp]]:
    """Fit and judge poles on the lines that `modes` were fitted to; also the place of each among the modes."""
    measured = Measured(frfs.frequency, frfs.h, frfs.variance).without(modes.left_out(frfs.frequency))
    lines = measured.lines()  # by their roughness: what the modes leave over holds the one that was missing
    found = fit(averaged(lines), poles, modes.terms, tolerance=1e-5)
    made, order = finish(measured, lines, found, Settings(mains=mains))
    return confirmed(measured, replace(made, rejected=modes.rejected, damping=modes.damping)), order


def _kept_by_hand(modes: Modes, places: list[int]) -> Modes:
    """Call poles modes, whatever they were judged to be, and say who did."""
    status, reason, words = list(modes.status), list(modes.reason), list(modes.confirmation)
    for n in places:
        status[n] = status[n] if modes.real[n] else "weak"
        reason[n] = f"{BY_HAND}; {reason[n]}"
        words[n] = words[n] or "unconfirmed"
    return replace(modes, status=tuple(status), reason=tuple(reason), confirmation=tuple(words))
