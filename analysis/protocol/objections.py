"""Why a protocol cannot be run on the hardware at hand.

Advice on a protocol: settings that are allowed, but give worse results.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from analysis.experiment import LEAST_LINES, Experiment
from analysis.protocol.protocol import AcquisitionProtocol

ALIAS_FREE_SHARE = 0.45
"""Share of the sample rate up to which a delta-sigma input shows no aliases."""


@dataclass(frozen=True)
class Hardware:
    """What cards, amplifier and oven allow.

    Attributes
    ----------
    sample_rate : float
        That the inputs will run at, Hz.
    output_range : float
        Largest amplitude of the output, V.
    drive_gain : float
        V/V of the amplifier, N/V of an exciter; may be a rough value.
    rated_force : float or None
        Amplitude that the exciter is rated for, N; None where a patch is driven.
    oven_minimum, oven_maximum : float
        Set-points allowed, degrees Celsius.
    oven_max_rate : float
        Steepest ramp it can follow, K/min.
    """

    sample_rate: float
    output_range: float
    drive_gain: float
    oven_minimum: float
    oven_maximum: float
    oven_max_rate: float
    rated_force: float | None = None


@dataclass(frozen=True)
class Objection:
    """One reason why not.

    Attributes
    ----------
    key : str
        Of the experiment's file.
    seen : str
    allowed : str
    remedy : str
    """

    key: str
    seen: str
    allowed: str
    remedy: str


def objections(protocol: AcquisitionProtocol, hardware: Hardware) -> tuple[Objection, ...]:
    """Return every reason against running `protocol` on `hardware`."""
    return (
        *_levels(protocol, hardware),
        *_frequencies(protocol, hardware),
        *_temperatures(protocol, hardware),
        *_times(protocol),
    )


def _levels(protocol: AcquisitionProtocol, hardware: Hardware) -> Iterator[Objection]:
    highest = max(protocol.sweep.levels)
    if hardware.rated_force is None:
        rated, unit, driver, driven = (
            protocol.limits.patch_voltage or math.inf,
            "V on the patch",
            "amplifier",
            "patch",
        )
    else:
        rated, unit, driver, driven = hardware.rated_force, "N on the plate", "exciter", "exciter"
    reached = highest * hardware.drive_gain
    if highest > hardware.output_range:
        yield Objection(
            "sweep.levels",
            f"{highest:g} V",
            f"at most {hardware.output_range:g} V, the output card's range",
            "lower the level, or use an output card that reaches further",
        )
    if reached > rated:
        yield Objection(
            "sweep.levels",
            f"{highest:g} V, which the {driver} makes {reached:g} {unit}",
            f"at most {rated / hardware.drive_gain:.4g} V: the {driven} is rated for {rated:g} {unit[0]}",
            f"lower the level or the {driver}'s gain",
        )


def _frequencies(protocol: AcquisitionProtocol, hardware: Hardware) -> Iterator[Objection]:
    (low, high), record = protocol.sweep.band, protocol.sweep.record
    lines = (high - low) * record
    if lines < LEAST_LINES:
        yield Objection(
            "sweep.band",
            f"{low:g} to {high:g} Hz, with {lines:.0f} frequency lines in a record of {record:g} s",
            f"at least {LEAST_LINES} lines, here a band of {LEAST_LINES / record:.3g} Hz",
            "bands are in Hz (1 kHz is 1000); widen the band, or lengthen the sweep",
        )
    top, reach = protocol.sweep.frequency_range[1], ALIAS_FREE_SHARE * hardware.sample_rate
    if top > reach:
        yield Objection(
            "sweep.band",
            f"ends at {protocol.sweep.band[1]:g} Hz, its fade at {top:.5g} Hz",
            f"the fade's end at most {reach:.5g} Hz, {ALIAS_FREE_SHARE:g} of the "
            f"{hardware.sample_rate:.6g} Hz sampled",
            "raise cards.sample_rate, lower the band, or shorten sweep.taper",
        )


def _temperatures(protocol: AcquisitionProtocol, hardware: Hardware) -> Iterator[Objection]:
    programme, limits = protocol.programme, protocol.limits
    for low, high, key, whose in (
        (hardware.oven_minimum, hardware.oven_maximum, "oven.minimum and oven.maximum", "the oven's set-points"),
        (limits.coldest, limits.hottest, "limits.coldest and limits.hottest", "the temperatures it may have"),
    ):
        for name, nearest, end in (
            ("lowest", programme.lowest, programme.lowest - programme.lead),
            ("highest", programme.highest, programme.highest + programme.lead),
        ):
            if not low <= end <= high:
                yield Objection(
                    f"programme.{name}",
                    f"{nearest:g} °C, with the lead a ramp to {end:g} °C",
                    f"ramps between {low:g} and {high:g} °C, {whose}",
                    f"move {name}, shorten programme.lead, or correct {key}",
                )
    for name, rate in (("ramp_rate", programme.ramp_rate), ("approach_rate", programme.to_start)):
        if rate > hardware.oven_max_rate:
            yield Objection(
                f"programme.{name}",
                f"{rate:g} K/min",
                f"at most {hardware.oven_max_rate:g} K/min, the steepest ramp the oven can follow",
                "ramp more slowly",
            )


def _times(protocol: AcquisitionProtocol) -> Iterator[Objection]:
    programme = protocol.programme
    travel = protocol.sweep_travel * len(protocol.sweep.levels)
    if travel > 2.0 * programme.tolerance:
        window = 120.0 * programme.tolerance / programme.ramp_rate
        yield Objection(
            "sweep.duration",
            f"{len(protocol.sweep.levels)} level(s) of {protocol.sweep.repeats} repeats take "
            f"{protocol.sweep_seconds * len(protocol.sweep.levels):.4g} s, in which the ramp moves {travel:.3g} K",
            f"at most {2.0 * programme.tolerance:g} K ({window:.4g} s), the window programme.tolerance leaves",
            "sweep faster, repeat less, ramp more slowly, or widen programme.tolerance",
        )
    if protocol.sweep_travel > protocol.limits.drift:
        yield Objection(
            "limits.drift",
            f"{protocol.limits.drift:g} K",
            f"more than the {protocol.sweep_travel:.3g} K that the ramp moves during every sweep",
            "raise it, sweep faster, or ramp more slowly",
        )


STIFFNESS_CHANGE, LOSS_FACTOR = 0.02, 0.05
"""|d ln E / dT| [1/K] and loss factor of a soft polymer: polypropylene between 0 and 60 degrees Celsius."""
PEAK_LINES = 2.0
"""Over the width of a resonance, in the middle of the band."""
LEAST_CHANGE = 0.01
"""Change of a resonance within one sweep, as a share of its peak, from which on it is more than usual noise."""


def unresolved(lines: tuple[float, float], spacing: float, loss_factor: float) -> tuple[str, ...]:
    """Warn where resonances are narrower than the spacing of the lines.

    A record as long as 1/spacing cuts the ringing of such a plate off, too.

    Parameters
    ----------
    lines : (float, float)
        First and last frequency, Hz.
    spacing : float
        Of the lines, Hz.

    Returns
    -------
    tuple of str
        One sentence of advice, or none.
    """
    width = loss_factor * float((lines[0] * lines[1]) ** 0.5)
    if width >= PEAK_LINES * spacing:
        return ()
    return (
        f"lines are {spacing:.2g} Hz apart, resonances of a loss factor of {loss_factor:.2g} about {width:.2g} Hz "
        f"wide: record for {PEAK_LINES / width:.2g} s or longer (sweep.duration, sweep.tail), else the damping "
        "is no better than the lines",
    )


def change_within_sweep(duration: float, ramp_rate: float) -> tuple[str, ...]:
    """Warn how far a plate changes within sweeps of `duration`, s, on a ramp of `ramp_rate`, K/min, if it matters.

    At a resonance, dH/H = (dE/E) / eta of what the temperature is off its mean.
    """
    rate = ramp_rate / 60.0
    by_second = 0.5 * rate * STIFFNESS_CHANGE / LOSS_FACTOR
    change = by_second * duration
    if change < LEAST_CHANGE:
        return ()
    longest = LEAST_CHANGE / by_second
    return (
        f"on a ramp of {ramp_rate:g} K/min a sweep of {duration:g} s spreads over {rate * duration:.2g} K, which "
        f"changes resonances of a soft polymer by {100 * change:.2g} % of their peaks; {longest:.2g} s or less, "
        f"or a slower ramp, keep it below {100 * LEAST_CHANGE:g} %",
    )


def unseen_lag(experiment: Experiment) -> tuple[str, ...]:
    """Warn where the plate may lag behind the temperatures of its sweeps, and nothing recorded would show it."""
    lag = experiment.tolerances.plate_lag
    if not (experiment.unseen_lag and lag):
        return ()
    rate = experiment.protocol.ramp_rate
    return (
        f"temperatures are the air's, on one ramp of {rate:g} K/min: the plate may be {rate / 60.0 * lag:.2g} K "
        f"behind it (tolerances.plate_lag, {lag:g} s). Nothing in the data would show it, and the σ of the laws "
        "contains it; measure up and down, or read a thermometer on the plate",
    )


def change_over_repeats(record: float, repeats: int, ramp_rate: float, sensitivity: float) -> tuple[str, ...]:
    """Warn where the repeats of a sweep, of which the mean is taken, are at temperatures too far apart.

    To second order, that mean is lower at a resonance by the mean square of (dE/E) / eta over the repeats. Model
    updating takes this into account; what it leaves is about the square of it.

    Parameters
    ----------
    record : float
        Sweep and silence, s.
    repeats : int
        One directly after another.
    ramp_rate : float
        K/min.
    sensitivity : float
        |d ln E / dT| / eta of the plate, 1/K.

    Returns
    -------
    tuple of str
        One sentence of advice, or none.
    """
    apart = record * ramp_rate / 60.0
    change = (sensitivity * apart) ** 2 * (repeats**2 - 1) / 12.0
    if change**2 < LEAST_CHANGE:
        return ()
    shorter = float((LEAST_CHANGE**0.5 / change) ** 0.5)
    spread = apart * (repeats - 1)
    return (
        f"on a ramp of {ramp_rate:g} K/min the {repeats} repeats of a sweep spread over {spread:.2g} K: the "
        f"mean over them lowers resonances by about {100 * change:.2g} %. update and gap take this into account "
        f"to second order only: the loss factor may be wrong by {100 * change**2:.2g} %. A ramp of "
        f"{shorter * ramp_rate:.2g} K/min or slower, or shorter records, keep it below {100 * LEAST_CHANGE:g} %",
    )
