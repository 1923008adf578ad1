"""What ``flexura render`` prints: a record, notes and one line."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from app.files.exports.shipment import Shipment

if TYPE_CHECKING:  # a run is told to be of another kind before what computes is imported
    from app.sound.rendering import Rendering
    from app.sound.trace import TraceMoment


def record(sent: Shipment, done: "Rendering", moments: "Sequence[TraceMoment]", block: int) -> dict[str, Any]:
    """Return what ``--json`` prints; null for a contrast of silence.

    Parameters
    ----------
    block : int
        Samples per block, which add to the latency.

    Returns
    -------
    dict
        Of JSON values.
    """
    return {
        "sound": str(done.sound),
        "trace": str(done.trace),
        "heard": [str(path) for path in done.heard],
        "loudest_pa": done.loudest,
        "method": sent.method,
        "seconds": done.seconds,
        "changes": done.changes,
        "largest_v": dict(zip(sent.names, done.largest.tolist(), strict=True)),
        "rated_v": {
            name: rated if math.isfinite(rated) else None
            for name, rated in zip(sent.names, sent.panel.limits.tolist(), strict=True)
        },
        "latency_samples": block + sent.filters.delay,
        "processing_seconds": done.processing,
        "real_time_factor": done.real_time_factor,
        "moments": [
            {
                "time_s": m.time,
                "temperature_c": m.temperature,
                "filters_c": m.filters,
                "contrast_mean": m.following.mean,
                "contrast_worst": m.following.worst,
                "contrast_sound": None if math.isnan(m.following.sound) else m.following.sound,
                "kept_mean": m.kept.mean,
            }
            for m in moments
        ],
    }


def notes(channels: int, moments: "Sequence[TraceMoment]") -> list[str]:
    """Return notes on the sound, which had so many channels."""
    found = [] if channels == 1 else [f"the mean of its {channels} channels is played"]
    silent = sum(math.isnan(m.following.sound) for m in moments)
    if silent:
        found.append(f"at {silent} of {len(moments)} moments the sound is silent in the panel's band")
    return found


def beyond_rated(sent: Shipment, done: "Rendering") -> list[str]:
    """Return a note where an actuator would get more volts than it is rated for: audio beyond ±1 can do that."""
    shares = done.largest / sent.panel.limits
    worst = int(shares.argmax())
    if shares[worst] <= 1.0:
        return []
    volts, rated = done.largest[worst], sent.panel.limits[worst]
    level = math.floor(1e3 * rated / volts) / 1e3
    return [
        f"{sent.names[worst]} would get {volts:.4g} V; it is rated for {rated:.4g} V: play this sound at "
        f"{level:g} of its level or less (the filters are made for audio within ±1)"
    ]


def heard_at(sent: Shipment, done: "Rendering") -> list[str]:
    """Say what is in the files of the sound at the listeners; nothing where there are none."""
    if not done.heard:
        return []
    names = ", ".join(one.name for one in sent.panel.listeners)
    low, high = sent.panel.filters.edges
    level = 20.0 * math.log10(max(done.loudest, 1e-9) / math.sqrt(2.0) / 2e-5)
    return [
        f"{done.heard[0].name}: pascals (1 Pa per unit) at {names}, up to {done.loudest:.3g} Pa, "
        f"{level:.0f} dB SPL of a sine as large; known from {low:g} to {high:g} Hz; "
        f"{done.heard[2].name}: at the ears of a rigid sphere that looks straight at the panel's plane"
    ]


def followed(sent: Shipment, length: float, seconds: float) -> list[str]:
    """Say what of a weather was played and what the filters followed.

    Parameters
    ----------
    length, seconds : float
        Of the weather, and of the sound.
    """
    part = f"; the sound ends after {seconds:.0f} of {length:g} s of the weather" if seconds < length else ""
    if sent.family is None:
        what = "the middle of the panel only; flexura compensate --weather makes filters that follow its tilt"
    else:
        what = f"the middle of the panel and its tilt, up to {sent.family.across:.1f} K"
    return [f"filters follow {what}{part}"]


def summary(sent: Shipment, done: "Rendering", moments: "Sequence[TraceMoment]") -> str:
    """Return one line for people.

    Parameters
    ----------
    moments : sequence of TraceMoment
        At least one.
    """
    t = [m.temperature for m in moments]
    used, kept = [m.following.mean for m in moments], [m.kept.mean for m in moments]
    return (
        f"{done.seconds:.1f} s at {min(t):.1f} to {max(t):.1f} °C, {done.changes} changes of the filters "
        f"({sent.method}): contrast {min(used):.3f} to {max(used):.3f}, with the first filters kept down to "
        f"{min(kept):.3f}; up to {done.largest.max():.4g} V; {done.real_time_factor:.0f} times real time on one "
        f"core; {done.sound}"
    )
