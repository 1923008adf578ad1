"""The sweeps of one of several actuators that drove the plate in turn."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.recordings.frf import Frf


def sweeps_of_actuator(frf: Frf, actuator: str | None) -> Frf:
    """Return the sweeps of an actuator, the first unless named, with a note where others drove too.

    Raises ValueError for one that did not drive.
    """
    if actuator is None and not frf.sources:
        return frf
    if actuator is not None and actuator not in frf.sources:
        known = ", ".join(frf.sources) or "none, only one drove the plate"
        raise ValueError(f"actuator {actuator!r} drove no sweep; allowed: {known}")
    source = 0 if actuator is None else frf.sources.index(actuator)
    note = f"modes of the sweeps that {frf.sources[source]} drove, of {', '.join(frf.sources)}: --actuator ID"
    return replace(frf.of_source(source), notes=(*frf.notes, note))


def sweeps_of_modes(frf: Frf, tracked: TrackedModes) -> NDArray[np.int_]:
    """Find the sweeps that modes were identified from: all, or those of one actuator.

    Parameters
    ----------
    frf : Frf
        T sweeps.

    Returns
    -------
    (T,) int ndarray
        Place of every sweep in `tracked`, -1 where it is not one of them. Of several actuators whose sweeps have
        the same temperatures, it is the one whose FRFs the modes miss least.
    """
    places = np.full(len(frf.temperature), -1)
    rows = (np.flatnonzero(frf.driven_by == source) for source in frf.driving)
    fitting = [some for some in rows if _same_sweeps(frf, some, tracked)]
    if fitting:
        own = min(fitting, key=lambda some: _missed(frf, some[0], tracked)) if len(fitting) > 1 else fitting[0]
        places[own] = np.arange(len(own))
    return places


def _same_sweeps(frf: Frf, rows: NDArray[np.int_], tracked: TrackedModes) -> bool:
    return bool(np.array_equal(frf.temperature[rows], tracked.temperature))


def _missed(frf: Frf, row: int, tracked: TrackedModes) -> float:
    """Share of a sweep's FRFs, in power, that the first modes leave inside the band they were found in."""
    modes = tracked.modes[0]
    inside = (frf.frequency >= modes.band[0]) & (frf.frequency <= modes.band[1]) & ~frf.excluded
    h = frf.h[row][:, inside]
    return float((np.abs(h - modes.synthesis(frf.frequency[inside])) ** 2).sum() / (np.abs(h) ** 2).sum())
