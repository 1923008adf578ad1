"""Notes on the drift of the temperature within and between repeats, where it is not followed."""

from analysis.experiment import Protocol
from analysis.material import MaterialLaws
from analysis.protocol.advice import change_over_repeats, change_within_sweep
from analysis.updated import Updated
from analysis.updating.drift import sweep_laws


def untimed(protocol: Protocol) -> tuple[str, ...]:
    """Return a note where the temperature drifts within sweeps and no taper tells when they pass a frequency."""
    drift = change_within_sweep(protocol.sweep_duration, protocol.ramp_rate) if protocol.timing is None else ()
    return tuple(
        f"{words}; with protocol.taper in the declaration, the drift is taken into account" for words in drift
    )


def drift_notes(protocol: Protocol, updated: Updated, laws: MaterialLaws | None) -> tuple[str, ...]:
    """Return notes on the drift of the temperature within and between repeats, where updating does not follow it.

    Parameters
    ----------
    laws : MaterialLaws or None
        Through the estimates; None for fewer than three temperatures.
    """
    if laws is None:
        within = (
            () if protocol.timing is None else change_within_sweep(protocol.sweep_duration, protocol.ramp_rate)
        )
        return tuple(
            f"{words}; from three temperatures on, update takes the drift into account" for words in within
        )
    local = sweep_laws(updated.temperature, updated.material, laws)
    sensitivity = max(
        abs(law.slope[0]) / eta for law, eta in zip(local, updated.material.loss_factor, strict=True)
    )
    return change_over_repeats(protocol.record, protocol.repeats, protocol.ramp_rate, float(sensitivity))
