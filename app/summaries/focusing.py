"""What ``flexura focus`` prints: a table, a record, notes and one line."""

from pathlib import Path
from typing import Any

from analysis.arrays import Real
from analysis.focusing.design import peak_drive
from analysis.focusing.methods import MethodComparison
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel, PanelSound
from analysis.focusing.pareto import ParetoCurve
from analysis.focusing.performance import Aim, area_normalised, decibels
from analysis.radiation.measures import ripple
from app.summaries.numbers import span
from app.summaries.table import Table

CAPTION = (
    "contrast: mean and worst line; uncut: worst line before the filters are cut to taps; area: normalised by "
    "area; dB of the displacement asked for, ripple in dB, phase in degrees; peak: any audio within ±1"
)
SOUND_CAPTION = (
    "± sound: third-octave ripple at the listeners, and level, dB of the sound wanted; contrast: mean and worst "
    "line; uncut: worst line of filters before they are cut; area: normalised by area; peak: any audio within ±1"
)
LEAST_CONTRAST = 5e-4
"""Gain of contrast below which filters are said to gain nothing: half of the last digit that is printed."""
WORST_LINE = 0.03
"""Contrast that taps may lose on the worst line before it is said."""


def record(
    panel: Panel,
    focusing: Focusing,
    comparison: MethodComparison,
    uncorrected: Aim | None,
    seconds: float,
    pareto: ParetoCurve | None = None,
) -> dict[str, Any]:
    """Return what ``--json`` prints: figures over the band at every temperature.

    Parameters
    ----------
    uncorrected : Aim or None
        What filters reach that were designed with the laws of a twin without its effects.
    seconds : float
        It took, s.

    Returns
    -------
    dict
        Of values that JSON holds; temperatures in degrees Celsius.
    """
    energy, share = focusing.energy, focusing.target_share
    said = {
        "aim": panel.filters.aim,
        "method": focusing.method,
        "regularisation": focusing.regularisation,
        "tolerance": focusing.tolerance,
        "reference_temperature_c": focusing.reference_temperature,
        "design": panel.filters.design,
        "outside_weight": panel.filters.kappa,
        "latency_ms": 1e3 * focusing.bank.delay / focusing.bank.sample_rate,
        "contrast_definition": "eq. (9), literal; area-normalised: d/(d + o) of mean energy densities",
        "spot_error_definition": "share of the plate's length Lx",
        "temperatures_c": focusing.temperature.tolist(),
        "without_compensation": _means(focusing.fixed, share),
        "direct": _means(focusing.direct, share),
        "uncut": _means(focusing.uncut, share),
        "fir": {
            "taps": focusing.bank.taps.shape[-1],
            "delay_samples": focusing.bank.delay,
            "energy_before_first_tap": float(energy.before.max()),
            "energy_inside_min": float(energy.inside.min()),
            "energy_after_last_tap": float(energy.after.max()),
            "pre_ringing": float(energy.pre_ringing.max()),
            "peak_drive": peak_drive(focusing.bank.taps).max(axis=1).tolist(),
            "drive_limit": [float(x) if x < float("inf") else None for x in panel.limits],
        },
        "rank_changes": focusing.rank_changes.tolist(),
        "comparison": {
            method: {"contrast": float(c.mean()), "spot_error": float(s.mean())}
            for method, c, s in zip(comparison.methods, comparison.contrast, comparison.spot_error, strict=True)
        },
        "seconds": seconds,
    }
    if pareto is not None:
        said["pareto"] = {
            "temperature_c": pareto.temperature,
            "recommended": pareto.recommended,
            "on_the_front": pareto.front.tolist(),
            **{name: getattr(pareto, name).tolist() for name in CURVE},
        }
    return said if uncorrected is None else said | {"with_uncorrected_laws": _means(uncorrected, share)}


CURVE = ("evenness", "outside_weight", "contrast", "worst", "ripple", "level", "drive")
"""What is said of every design between contrast and evenness."""
FOCUSED_CONTRAST = 0.5
"""Mean contrast below which more of the energy is outside the target than in it: no taps make up for actuators
that cannot move the target alone. Panels with placed actuators reach 0.6 and more over their band."""


def notes(panel: Panel, focusing: Focusing) -> list[str]:
    """Return what a user has to know before trusting the filters."""
    found = []
    wanted = panel.filters.reference_temperature
    if focusing.reference_temperature != wanted:
        found.append(
            f"the laws do not reach {wanted:g} °C: the filter kept without compensation is that of "
            f"{focusing.reference_temperature:g} °C"
        )
    changes = focusing.rank_changes
    if focusing.regularisation == "truncation" and changes.any():
        worst = int(changes.argmax())
        found.append(
            f"truncation at {focusing.tolerance:g}: the rank changes on {int(changes.max())} lines between "
            f"{focusing.temperature[worst]:g} and {focusing.temperature[worst + 1]:g} °C; the filters jump there "
            "and cannot be interpolated well (tikhonov does not jump)"
        )
    drop = focusing.uncut.contrast.min(axis=1) - focusing.direct.contrast.min(axis=1)
    if drop.max() > WORST_LINE:
        worst = int(drop.argmax())
        remedy = "more taps or another delay"
        if panel.filters.design != "field":
            remedy = "more taps, another delay, or --design field"
        found.append(
            f"the taps lose {drop[worst]:.2f} of contrast on the worst line at "
            f"{focusing.temperature[worst]:g} °C; {remedy} keep more"
        )
    limits, peak = panel.limits, peak_drive(focusing.bank.taps)
    if (peak >= 0.999 * limits).any():
        actuator = int((peak / limits).max(axis=0).argmax())
        found.append(
            f"actuator {actuator + 1} is held at its limit of {limits[actuator]:g} V (rated field times "
            "thickness): level or contrast is lost; ask for less displacement, or declare the patch's rated_field"
        )
    given_up = panel.filters.aim != "field" and panel.sound.field_weight < PanelSound().field_weight
    return [*found, *([] if given_up else _unfocused(focusing))]


def _unfocused(focusing: Focusing) -> list[str]:
    """Say where filters do not focus, and what helps."""
    contrast = focusing.direct.contrast.mean(axis=1)
    worst = int(contrast.argmin())
    if contrast[worst] >= FOCUSED_CONTRAST:
        return []
    remedy = "take --method stif"
    if focusing.method == "stif":
        remedy = (
            "move the actuators, use more of them, or lower the band: docs/guide/filters.md, "
            "examples/place_actuators.py"
        )
    off = focusing.direct.spot_error[worst].mean()
    return [
        f"at {focusing.temperature[worst]:g} °C the filters do not focus: mean contrast {contrast[worst]:.2f}, "
        f"more energy outside the target than in it; the largest amplitude is {off:.0%} of the plate's length "
        f"off the target's centre. For contrast above {FOCUSED_CONTRAST:g} {remedy}"
    ]


def tradeoff(panel: Panel, curve: ParetoCurve | None) -> list[str]:
    """Say which design between contrast and an even sound is recommended, where sound is aimed at."""
    if curve is None:
        return []
    best = curve.recommended
    weight, uneven, contrast = curve.outside_weight[best], curve.ripple[best], curve.contrast[best]
    same = curve.evenness[best] == 1.0 and weight == panel.filters.kappa
    advice = "these filters are of it" if same else f"take --outside-weight {weight:g}"
    if curve.evenness[best] < 1.0:
        advice = "its sound follows the field's own in part: more sound_weight or more taps make these more even"
    return [
        f"contrast against evenness at {curve.temperature:g} °C: recommended is an outside weight of {weight:g}, "
        f"with contrast {contrast:.3f} and ripple ± {uneven:.2f} dB at {100 * curve.drive[best]:.0f} % of the "
        f"rated drive; {advice}"
    ]


def correction(focusing: Focusing, lost: Aim | None) -> list[str]:
    """Say what the twin's effects are worth for the filters, where that was tried."""
    if lost is None:
        return []
    own, without = focusing.direct.contrast.mean(axis=1), lost.contrast.mean(axis=1)
    worst = int((own - without).argmax())
    gain = float(own[worst] - without[worst])
    worth = "is worth nothing for them"
    if gain >= LEAST_CONTRAST:
        worth = f"is worth up to {gain:.3f}, at {focusing.temperature[worst]:g} °C"
    reached = span(without, ".3f")
    return [f"filters from the uncorrected laws.h5 reach contrast {reached} here; the correction {worth}"]


def table(panel: Panel, focusing: Focusing) -> Table:
    """Return a table of the temperatures."""
    latency = 1e3 * focusing.bank.delay / focusing.bank.sample_rate
    unit = "V" if panel.patch else "N"
    name = panel.filters.design if panel.filters.aim == "field" else panel.filters.aim
    heard = panel.filters.aim != "field"
    motion = (
        ("mean", "worst", "uncut", "area")
        if heard
        else ("mean", "worst", "uncut", "area", "dB", "ripple", "phase")
    )
    headings = ("°C", *(("± sound", "dB") if heard else ()), *motion, f"peak {unit}")
    direct, drive = focusing.direct, peak_drive(focusing.bank.taps)
    normalised = area_normalised(direct.contrast, focusing.target_share)
    rows = tuple(
        (
            f"{temperature:.4g}",
            *(_sound(panel, focusing, t) if heard else ()),
            *_both(direct.contrast[t]),
            f"{focusing.uncut.contrast[t].min():.3f}",
            f"{normalised[t].mean():.3f}",
            *(() if heard else _movement(direct, t)),
            f"{drive[t].max():.3g}",
            *_both(focusing.fixed.contrast[t]),
        )
        for t, temperature in enumerate(focusing.temperature)
    )
    return Table(
        f"{focusing.method}, {name}: {focusing.bank.taps.shape[2]} taps, {latency:.1f} ms",
        (*headings, f"{focusing.reference_temperature:g} °C's", "worst"),
        rows,
        SOUND_CAPTION if heard else CAPTION,
    )


def _sound(panel: Panel, focusing: Focusing, t: int) -> tuple[str, str]:
    """Third-octave ripple and mean level at the listeners played to."""
    if focusing.direct.sound is None:
        return "", ""
    sound = focusing.direct.sound[t][panel.loud]
    return f"{ripple(sound, focusing.frequency).max():.2f}", f"{decibels(sound).mean():.1f}"


def _movement(direct: Aim, t: int) -> tuple[str, str, str]:
    """Level, ripple and phase of the target's displacement."""
    return f"{direct.level[t].mean():.1f}", f"{direct.level_ripple[t]:.1f}", f"{direct.phase_error[t]:.1f}"


def summary(panel: Panel, focusing: Focusing, target: Path, seconds: float) -> str:
    """Return one line for people.

    Parameters
    ----------
    target : Path
        File it was written to.
    seconds : float
        It took, s.
    """
    t = focusing.temperature
    direct, fixed = focusing.direct.contrast.mean(axis=1), focusing.fixed.contrast.mean(axis=1)
    heard = ""
    if panel.filters.aim != "field" and focusing.direct.sound is not None:
        uneven = ripple(focusing.direct.sound[:, panel.loud], focusing.frequency).max()
        heard = f"third-octave ripple at most ± {uneven:.2f} dB at the listeners, "
    return (
        f"{temperatures_in_words(t)}: {heard}contrast {span(direct, '.2f')} with "
        f"their own filters, worst line {focusing.direct.contrast.min():.2f}; down to {fixed.min():.2f} with "
        f"those of {focusing.reference_temperature:g} °C ({focusing.regularisation}, tolerance "
        f"{focusing.tolerance:g}); {seconds:.1f} s; {target}"
    )


def _both(line: Real) -> tuple[str, str]:
    """Mean and worst of a figure over the band."""
    return f"{line.mean():.3f}", f"{line.min():.3f}"


def temperatures_in_words(t: Real) -> str:
    """Say how many temperatures (T,), °C, ascending, there are, and from where to where."""
    return f"{t[0]:g} °C" if len(t) == 1 else f"{len(t)} temperatures, {t[0]:g} to {t[-1]:g} °C"


def _means(aim: Aim, target_share: float) -> dict[str, list[float]]:
    normalised = area_normalised(aim.contrast, target_share)
    return {
        "contrast": aim.contrast.mean(axis=1).tolist(),
        "contrast_worst_line": aim.contrast.min(axis=1).tolist(),
        "contrast_area_normalised": normalised.mean(axis=1).tolist(),
        "level_db": aim.level.mean(axis=1).tolist(),
        "level_ripple_db": aim.level_ripple.tolist(),
        "phase_error_deg": aim.phase_error.tolist(),
        "spot_error": aim.spot_error.mean(axis=1).tolist(),
    }
