"""What ``flexura radiation`` prints: a table, a record, notes and one line."""

from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.focusing.panel import Panel
from analysis.focusing.radiated import DEGREES, RadiatedSound, Radiation
from analysis.focusing.sound_aim import RESPONSE_TOLERANCE
from analysis.radiation.radiator import Radiator
from app.summaries.numbers import span
from app.summaries.table import Table

LOST_LEVEL = 1.0
"""dB of the level wanted at the listeners that may be missing at some temperature before it is said."""


def record(panel: Panel, found: Radiation, seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints.

    Parameters
    ----------
    seconds : float
        It took, s.

    Returns
    -------
    dict
        Of values that JSON holds; null where there is no number.
    """
    return {
        "aim": panel.filters.aim,
        "mounting": panel.sound.mounting,
        "sound_speed": panel.sound.sound_speed,
        "density": panel.sound.density,
        "listeners": [
            {"name": one.name, "position_m": list(one.position), "zone": one.zone, "played_to": bool(loud)}
            for one, loud in zip(panel.listeners, found.loud, strict=True)
        ],
        "level_definition": "dB of the sound wanted: the target moving alone, by sound.level and curve",
        "temperatures_c": found.temperature.tolist(),
        "reference_temperature_c": found.reference_temperature,
        "third_octaves_hz": found.middles.tolist(),
        "polar_degrees": DEGREES.tolist(),
        "acoustic_contrast_definition": (
            f"dB, each actuator {100 * RESPONSE_TOLERANCE:g} % off, independent of the others"
        ),
        "acoustic_contrast_bound_db": [] if found.zone_bound is None else found.zone_bound.mean(axis=1).tolist(),
        "following": _sound(found, found.following),
        "kept": _sound(found, found.kept),
        "seconds": seconds,
    }


def _sound(found: Radiation, sound: RadiatedSound) -> dict[str, Any]:
    zones, lines = sound.zones, found.line_levels(sound)
    said = {
        "ripple_db": found.ripple(sound),
        "level_db": lines.mean(axis=(1, 2)),
        "level_lowest_line_db": lines.min(axis=(1, 2)),
        "level_highest_line_db": lines.max(axis=(1, 2)),
        "third_octave_level_db": found.levels(sound),
        "group_delay_spread_s": found.delay_spread(sound),
        "contrast": sound.contrast.mean(axis=1),
        "contrast_worst_line": sound.contrast.min(axis=1),
        "contrast_area_normalised": found.area_contrast(sound).mean(axis=1),
        "acoustic_contrast_db": np.full(len(lines), np.nan) if zones is None else zones.mean(axis=1),
        "acoustic_contrast_worst_line_db": np.full(len(lines), np.nan) if zones is None else zones.min(axis=1),
        "power_w": sound.power.mean(axis=1),
        "target_share_of_power": np.nanmean(sound.target_share, axis=1),
        "target_share_of_power_worst_line": np.nanmin(sound.target_share, axis=1),
        "radiation_efficiency": np.nanmean(sound.efficiency, axis=1),
        "directivity_index_db": sound.directivity.mean(axis=1),
        "polar_db": sound.polar,
        "peak_drive": sound.peak.max(axis=1),
        "level_at_rated_drive_db_spl": found.rated_level(sound),
    }
    if sound.pressure_sigma is not None and sound.power_sigma is not None:
        said["pressure_sigma_db"] = _sigma_db(found, sound, sound.pressure_sigma)
        said["power_sigma_w"] = np.sqrt(np.mean(sound.power_sigma**2, axis=1))
    return {name: _plain(np.asarray(values).tolist()) for name, values in said.items()}


def _plain(value: Any) -> Any:
    """Return lists of numbers, with None for those that are not finite."""
    if isinstance(value, list):
        return [_plain(part) for part in value]
    return value if np.isfinite(value) else None


def _sigma_db(found: Radiation, sound: RadiatedSound, sigma: Real) -> Real:
    """Return σ (T,) of the level at the first listener played to, dB, root mean square over the lines."""
    first = int(np.argmax(found.loud))
    share = sigma[:, first] / np.maximum(np.abs(sound.pressure[:, first]), 1e-30)
    return np.asarray(20.0 / np.log(10.0) * np.sqrt(0.5 * np.mean(share**2, axis=1)))


def table(panel: Panel, found: Radiation) -> Table:
    """Return a table of the temperatures; it leads with what the aim wants."""
    zones = found.following.zones is not None
    who = ", ".join(name for name, loud in zip(found.names, found.loud, strict=True) if loud)
    heard = ["ripple", "dB", "line"]
    motion = ["mean", "worst"]
    between = ["zones dB", "bound"] if zones else []
    first = [*motion, *heard] if panel.filters.aim == "field" else [*between, *heard, *motion]
    rest = between if panel.filters.aim == "field" else []
    unit = "V" if panel.patch else "N"
    headings = ("°C", *first, *rest, "area", "share", f"peak {unit}", "SPL", "ripple", "mean")
    sound, kept = found.following, found.kept
    lines, contrast, bound = found.line_levels(sound), sound.zones, found.zone_bound
    rows = []
    for t, temperature in enumerate(found.temperature):
        cells = {
            "heard": [f"{found.ripple(sound)[t]:.2f}", f"{lines[t].mean():.1f}", f"{lines[t].min():.1f}"],
            "motion": [f"{sound.contrast[t].mean():.3f}", f"{sound.contrast[t].min():.3f}"],
            "zones": []
            if contrast is None or bound is None
            else [f"{contrast[t].mean():.1f}", f"{bound[t].mean():.1f}"],
        }
        order = ("motion", "heard", "zones") if panel.filters.aim == "field" else ("zones", "heard", "motion")
        level = found.rated_level(sound)[t]
        row = (
            f"{temperature:.4g}",
            *(cell for part in order for cell in cells[part]),
            f"{found.area_contrast(sound)[t].mean():.3f}",
            f"{np.nanmean(sound.target_share[t]):.2f}",
            f"{sound.peak[t].max():.3g}",
            f"{level:.0f}" if np.isfinite(level) else "-",
            f"{found.ripple(kept)[t]:.2f}",
            f"{kept.contrast[t].mean():.3f}",
        )
        rows.append(row)
    return Table(
        f"sound at {who}, {panel.sound.mounting}; aim: {panel.filters.aim}",
        headings,
        tuple(rows),
        "mean, worst: contrast; ripple: half the span of third-octave levels, dB of the sound wanted; "
        "line: softest; share: of the power from the target; SPL: dB re 20 µPa of the band at rated drive; "
        f"right: with the filters of {found.reference_temperature:g} °C",
    )


def notes(panel: Panel, found: Radiation) -> list[str]:
    """Return what a user has to know of the sound, a sentence each."""
    said, sound = [], found.following
    if not panel.sound.listener:
        said.append("no [[sound.listener]] is declared in the panel's file: judged at 1 m in front of its middle")
    if panel.sound.mounting == "box":
        limit = Radiator(np.array(panel.plate.bounds), np.ones(2), panel.sound.air, "box").box_limit
        said.append(
            f"mounting box: sources radiate into the whole space, which holds below {limit:.0f} Hz; above it the "
            "pressure in front is underestimated, by 6 dB at most"
        )
    missing = -found.line_levels(sound).mean(axis=(1, 2))
    worst = int(missing.argmax())
    if panel.filters.aim != "field" and missing[worst] > LOST_LEVEL:
        said.append(
            f"at {found.temperature[worst]:g} °C the sound is {missing[worst]:.1f} dB below the one wanted, so "
            "that no actuator exceeds its rating: lower sound.level by as much for one level at all temperatures"
        )
    if sound.pressure_sigma is not None:
        sigma = _sigma_db(found, sound, sound.pressure_sigma)
        worst = int(sigma.argmax())
        said.append(
            f"the noise of the transfers makes levels uncertain by {sigma[worst]:.2g} dB (standard deviation, at "
            f"{found.temperature[worst]:g} °C); its mean is subtracted from the powers"
            if sigma[worst] > 0.0
            else "the transfers have no variance: what their noise makes of the sound is not known"
        )
    return said


def summary(panel: Panel, found: Radiation, target: Path | None, seconds: float) -> str:
    """Return one line for people.

    Parameters
    ----------
    target : Path or None
        File it was written to.
    seconds : float
        It took, s.
    """
    own, kept = found.ripple(found.following), found.ripple(found.kept)
    mean = found.following.contrast.mean(axis=1)
    zones, bound = found.following.zones, found.zone_bound
    between = ""
    if zones is not None and bound is not None:
        worst = int(zones.mean(axis=1).argmin())
        between = f", {zones[worst].mean():.1f} dB between zones (bound {bound[worst].mean():.1f} dB)"
    return (
        f"{span(found.temperature, 'g')} °C: third-octave ripple up to ± {own.max():.1f} dB at the listeners, "
        f"up to ± {kept.max():.1f} dB with the filters of {found.reference_temperature:g} °C{between}; "
        f"contrast {span(mean, '.2f')} (aim {panel.filters.aim}); {seconds:.1f} s"
        f"{'' if target is None else f'; {target}'}"
    )
