"""The sweeps of one of several actuators that drove the plate in turn."""

from dataclasses import replace

from analysis.frf import Frf


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
