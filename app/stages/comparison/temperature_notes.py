"""Notes on temperatures that cannot be true, by rig, air and plate, and on drift that is not followed."""

import numpy as np

from analysis.experiment import Protocol
from analysis.material import MaterialLaws
from analysis.plate_temperature.label_check import (
    MOST_NAMED,
    doubtful_sweeps,
    hysteresis,
    misplaced,
    offset_change,
    said_of_doubts,
)
from analysis.plate_temperature.resonances import unlike_resonances
from analysis.protocol.objections import change_over_repeats, change_within_sweep
from analysis.recordings.campaign import Sweep
from analysis.recordings.frf import Frf
from analysis.recordings.frf_campaign import AnyCampaign, FrfCampaign
from analysis.updated import Updated


def recorded_notes(campaign: AnyCampaign) -> tuple[str, ...]:
    """Return a note for every sweep whose temperature the rig or the air puts in doubt, and for slow errors."""
    if isinstance(campaign, FrfCampaign):
        return ()  # no reading of an oven is known; doubts that a rig noted are among its notes
    sweeps = campaign.sweeps
    by_air = doubtful_sweeps(sweeps)
    doubts = {one: sweep.doubt for one, sweep in enumerate(sweeps) if sweep.doubt}
    doubts = {one: doubts.get(one) or by_air[one] for one in sorted({*doubts, *by_air})}
    notes = said_of_doubts({_named(sweeps[one]): why for one, why in doubts.items()}, "sweeps")
    change = offset_change(sweeps, tuple(doubts))
    if change is not None:
        by, coldest, hottest = change
        notes.append(
            f"plate over oven, its lag left aside, changes by {by:+.1f} K from {coldest:.0f} to {hottest:.0f} °C: "
            "one of the two sensors is wrong by as much. Check the thermocouple's type, contact and drift"
        )
    return tuple(notes)


def resonance_notes(campaign: AnyCampaign, frf: Frf) -> tuple[str, ...]:
    """Return a note for every sweep whose plate's temperature the shift of its resonances contradicts.

    It needs no material, and is told where FRFs are first made; the moduli that `label_notes` judges come later.

    Parameters
    ----------
    frf : Frf
        Of all sweeps.
    """
    if not _touched(campaign):
        return ()
    sweeps = campaign.sweeps
    doubted = [one for one, sweep in enumerate(sweeps) if getattr(sweep, "doubt", "")]
    whole = len(sweeps) == len(frf.temperature)
    found = unlike_resonances(frf, doubted if whole else ())
    told = [
        f"look at the sweep at {frf.temperature[one]:.1f} °C on the way {frf.direction[one]}: {why}"
        for one, why in found.items()
    ]
    more = (f"and {len(told) - MOST_NAMED} more sweeps like this",) if len(told) > MOST_NAMED else ()
    return (*told[:MOST_NAMED], *more)


def label_notes(campaign: AnyCampaign, frf: Frf, updated: Updated) -> tuple[str, ...]:
    """Return a note for every sweep whose modulus does not fit its temperature, and where up and down differ.

    Parameters
    ----------
    frf : Frf
        As updated: sweeps left out are not in it.
    """
    log_modulus, direction = np.log(updated.material.youngs_modulus), np.array(frf.direction)
    notes: list[str] = []
    groups = sorted({(int(s), float(v)) for s, v in zip(frf.driven_by, frf.level, strict=True)})
    for source, level in groups:
        legs = {}
        for way in ("up", "down"):
            inside = (frf.driven_by == source) & (frf.level == level) & (direction == way) & updated.settled
            leg = np.flatnonzero(inside)
            found = misplaced(frf.temperature[leg], log_modulus[leg])
            notes += [_misplaced(float(frf.temperature[leg[one]]), way, likely) for one, likely in found.items()]
            fits = np.delete(leg, list(found))
            legs[way] = frf.temperature[fits], log_modulus[fits]
        apart = hysteresis(legs["up"], legs["down"])
        if apart is not None:
            notes.append(_apart(apart, campaign))
    return tuple(dict.fromkeys(notes))


def _apart(kelvins: float, campaign: AnyCampaign) -> str:
    """Say that readings at equal stiffness differ by so much, up less down."""
    touched = _touched(campaign) or campaign.experiment.oven.reading == "plate"
    reading = "plate" if touched else "air"
    seen = f"at equal stiffness the {reading} reads {kelvins:+.1f} K on the way up against the way down"
    if touched:
        return (
            f"{seen}: its sensor leads or lags (half loose, or not on the plate), or the plate itself has changed"
        )
    rate = campaign.experiment.protocol.ramp_rate / 60.0
    if kelvins < 0.0 or not rate:
        return f"{seen}: the plate itself has changed, or labels are wrong; σ of E, ν and η contain nothing of it"
    return (
        f"{seen}: the plate lags about {0.5 * kelvins / rate:.0f} s behind, or has changed. Each E, ν, η is "
        f"{0.5 * kelvins:.1f} K off, which its σ does not contain; the laws are about the mean of both ways. "
        "flexura gap finds a lag"
    )


def _touched(campaign: AnyCampaign) -> bool:
    """Whether all temperatures are those of a sensor on the plate: the air's lag is found by the gap stage."""
    if isinstance(campaign, FrfCampaign):
        return False
    return all(sweep.plate_temperature_start is not None for sweep in campaign.sweeps)


def _misplaced(label: float, way: str, likely: float) -> str:
    return (
        f"look at the sweep at {label:.1f} °C on the way {way}: its modulus fits the neighbours' only if its "
        f"temperature was about {likely:.0f} °C"
    )


def _named(sweep: Sweep) -> str:
    return f"step {sweep.step} ({sweep.temperature:.1f} °C {sweep.direction})"


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
    from analysis.updating.drift import sweep_laws

    local = sweep_laws(updated.temperature, updated.material, laws)
    sensitivity = max(
        abs(law.slope[0]) / eta for law, eta in zip(local, updated.material.loss_factor, strict=True)
    )
    return change_over_repeats(protocol.record, protocol.repeats, protocol.ramp_rate, float(sensitivity))
