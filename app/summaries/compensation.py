"""What ``flexura compensate`` prints: a table, a record, notes and one line."""

from pathlib import Path
from typing import Any

import numpy as np

from analysis.compensation.knots import PlacedTemperatures
from analysis.compensation.law_band import ContrastBand
from analysis.compensation.outcome import Compensation
from analysis.compensation.settings import Training
from analysis.compensation.tilted import TiltedContrast
from analysis.focusing.performance import area_normalised
from analysis.weather.judged import WeatherJudgement
from app.summaries.table import Table


def weather_table(found: WeatherJudgement) -> Table:
    """Return what is lost by each way of knowing the field of temperatures."""
    rows = tuple(
        (way, f"{mean:.4f}", f"{worst:.4f}", f"{level:.2f}")
        for way, (mean, worst), level in zip(found.ways, found.largest, found.level_error, strict=True)
    )
    count = len(found.names)
    return Table(
        "In the weather",
        ("field known from", "contrast lost, mean", "worst line", "level, ± dB"),
        rows,
        f"at the worst of {len(found.time)} moments, against filters designed for the field itself;\n"
        f"one thermometer: {found.names[0]}; all: {count}, a plane through them; level of third-octave bands",
        words=frozenset({0}),
    )


def weather_note(found: WeatherJudgement) -> str:
    """Say what the weather did to the plate, and what robust filters cost."""
    mean, worst = found.price
    return (
        f"in the weather the plate goes from {found.extent[0, 1]:.1f} to {found.extent[-1, 1]:.1f} °C in "
        f"{found.time[-1]:g} s, up to {found.widest:.1f} K from one place to another; filters robust for tilts of "
        f"{found.across:.1f} K lose {mean:.4f} of the mean contrast on a panel without a tilt, {worst:.4f} at the "
        "worst line"
    )


def weather_record(found: WeatherJudgement) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    return {
        "time_s": found.time.tolist(),
        "plate_c": {
            name: found.extent[:, place].tolist() for place, name in enumerate(("coldest", "mean", "warmest"))
        },
        "readings_c": {name: found.readings[:, place].tolist() for place, name in enumerate(found.names)},
        "contrast_of_known_field": found.known.mean(axis=1).tolist(),
        "ways": {
            way: {
                "loss": float(found.largest[place, 0]),
                "loss_worst_line": float(found.largest[place, 1]),
                "level_db": float(found.level_error[place]),
                "middle_c": found.believed[place, :, 0].tolist(),
                "across_k": found.believed[place, :, 1:].tolist(),
            }
            for place, way in enumerate(found.ways)
        },
        "robust": {
            "across_k": found.across,
            "price": float(found.price[0]),
            "price_worst_line": float(found.price[1]),
        },
    }


def notes(found: Compensation, training: Training) -> list[str]:
    """Return what a user has to know of how the filters were trained, a sentence each; mostly none."""
    said = []
    if found.focusing != "stif":
        said.append(f"the filters followed are those of {found.focusing}; --method stif trains on STIF")
    if found.judged == "left-out" and training.feed != "temperature":
        said.append("the networks use the temperature as input: measured transfers give no log √D")
    if found.placed is not None:
        placed = found.placed
        places = ", ".join(f"{t:g}" for t in placed.temperature)
        said.append(
            f"placed at {places} °C: a spline through the filters there loses {placed.loss:.2g} of contrast at "
            f"the worst line, through {len(placed.equidistant)} equidistant ones {placed.equidistant_loss:.2g}"
        )
    if found.law_band is not None:
        said.append(band_note(found.law_band))
    if found.weather is not None:
        said.append(weather_note(found.weather))
    return said


def band_note(band: ContrastBand) -> str:
    """Say where the band of contrast that the laws' uncertainty leaves is widest."""
    widths = (band.mean[:, 1] - band.mean[:, 0], band.worst[:, 1] - band.worst[:, 0])
    if widths[1].max() == 0.0:
        return "the laws state no uncertainty (sigma 0): what it leaves of the contrast is not known"
    widest = int(np.argmax(widths[1]))
    said = (
        f"uncertainty of the laws: the {band.share:.0%} band of the mean contrast is at most "
        f"{widths[0].max():.2g} wide, that of the worst line {widths[1].max():.2g} "
        f"({band.worst[widest, 0]:.4f} to {band.worst[widest, 1]:.4f} at {band.temperature[widest]:g} °C)"
    )
    if band.outside is None or not band.outside.any():
        return said
    most = int(np.argmax(band.outside))
    return (
        f"{said}; {band.outside[most]:.0%} of the plates drawn at {band.temperature[most]:g} °C lie outside the "
        "box of the panel's twin and are extrapolated: widen [twin] in the panel's file to compute them"
    )


def record(found: Compensation, seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    trained = found.trained
    return {
        "methods": {
            name: {
                "contrast": float(found.contrast[m].mean()),
                "contrast_worst_line": float(found.contrast[m].min()),
                "contrast_area_normalised": float(area_normalised(found.contrast[m], found.target_share).mean()),
                "contrast_loss": float(found.largest_loss[m]),
                "contrast_loss_band_mean": float(found.contrast_loss[m].mean(axis=1).max()),
                "phase_error_deg": float(found.phase_error[m]),
                "level_ripple_db": float(found.level_ripple[m]),
                "peak_drive": float(found.peak_drive[m].max()),
                "bytes": int(found.size[m]),
                "multiplications_per_update": int(found.update_cost[m]),
                "relative_error_max_percent": _largest(found, m),
                "relative_error_mean_percent": float(found.relative_error[m].mean()),
                "left_out_max_percent": float(found.left_out[m].max()),
                "seconds": float(found.seconds[m]),
            }
            for m, name in enumerate(found.methods)
        },
        "judged": found.judged,
        "best": found.best,
        "recommended": found.recommended,
        "focusing": found.focusing,
        "taps": found.filters.taps.shape[2],
        "latency_ms": 1e3 * found.filters.delay / found.filters.sample_rate,
        "temperatures": len(found.temperature),
        "temperature_range_c": [float(found.temperature[0]), float(found.temperature[-1])],
        "training_temperatures_c": found.training_temperature.tolist(),
        "actuators": found.relative_error.shape[2],
        "network": {
            "nodes": trained.settings.nodes,
            "parameters_determined": trained.gamma.tolist(),
            "log_evidence": trained.log_evidence.tolist(),
            "training_error_percent": trained.training_error.tolist(),
            "epochs": trained.epochs.tolist(),
            "seed": trained.settings.seed,
        },
        "contrast_direct_mean": float(found.contrast_direct.mean()),
        "placed": None if found.placed is None else _placed_record(found.placed),
        "law_band": None if found.law_band is None else _band_record(found.law_band),
        "across": None if found.tilted is None else _tilted_record(found.tilted),
        "weather": None if found.weather is None else weather_record(found.weather),
        "seconds": seconds,
    }


def _placed_record(placed: PlacedTemperatures) -> dict[str, Any]:
    return {
        "temperatures_c": placed.temperature.tolist(),
        "equidistant_c": placed.equidistant.tolist(),
        "spline_contrast_loss": placed.loss,
        "spline_contrast_loss_equidistant": placed.equidistant_loss,
    }


def _band_record(band: ContrastBand) -> dict[str, Any]:
    return {
        "share": band.share,
        "draws": band.draws,
        "temperatures_c": band.temperature.tolist(),
        "contrast": band.nominal[:, 0].tolist(),
        "contrast_band": band.mean.tolist(),
        "contrast_worst_line": band.nominal[:, 1].tolist(),
        "contrast_worst_line_band": band.worst.tolist(),
        "share_outside_twin": None if band.outside is None else band.outside.tolist(),
    }


def _tilted_record(tilted: TiltedContrast) -> list[dict[str, Any]]:
    target, middle = tilted.loss(tilted.fed_target), tilted.loss(tilted.fed_mean)
    return [
        {
            "difference_k": float(difference),
            "temperatures_c": tilted.temperature[g].tolist(),
            "contrast_uniform": float(tilted.uniform[g, :, 0].mean()),
            "contrast_fed_target_temperature": float(tilted.fed_target[g, ..., 0].mean()),
            "contrast_fed_mean_temperature": float(tilted.fed_mean[g, ..., 0].mean()),
            "loss_fed_target_temperature": float(target[g, 0]),
            "loss_worst_line_fed_target_temperature": float(target[g, 1]),
            "loss_fed_mean_temperature": float(middle[g, 0]),
            "loss_worst_line_fed_mean_temperature": float(middle[g, 1]),
        }
        for g, difference in enumerate(tilted.difference)
    ]


def tables(found: Compensation) -> list[Table]:
    """Return a table of the methods, and of what differences of temperature and a weather cost, if judged."""
    latency = 1e3 * found.filters.delay / found.filters.sample_rate
    caption = (
        f"{found.focusing}, {found.filters.taps.shape[2]} taps, {latency:.1f} ms; all temperatures and lines\n"
        "relative error: of energy, eq. (13); 0.01 % is 1 % of amplitude"
    )
    share = found.target_share
    rows = tuple(
        (figure, *values)
        for figure, values in (
            ("contrast, mean", [f"{c.mean():.3f}" for c in found.contrast]),
            ("contrast, worst line", [f"{c.min():.3f}" for c in found.contrast]),
            ("contrast lost, mean", [f"{c.mean(axis=1).max():.4f}" for c in found.contrast_loss]),
            ("contrast lost, worst", [f"{c:.4f}" for c in found.largest_loss]),
            ("contrast by area, mean", [f"{area_normalised(c, share).mean():.3f}" for c in found.contrast]),
            ("phase error, °", [f"{c:.1f}" for c in found.phase_error]),
            ("level ripple, dB", [f"{c:.1f}" for c in found.level_ripple]),
            ("peak drive, V", [f"{c.max():.3g}" for c in found.peak_drive]),
            ("kilobytes", [f"{c / 1e3:.0f}" for c in found.size]),
            ("multiplications, 10³", [f"{c / 1e3:.0f}" for c in found.update_cost]),
            ("time, s", [f"{c:.2f}" for c in found.seconds]),
            ("relative error, %", [_percent(_largest(found, m)) for m in range(len(found.methods))]),
        )
    )
    title = "Filters between the training temperatures" if found.judged == "everywhere" else "Filters left out"
    headings = ("", *(name.replace("-", "-\n") for name in found.methods))
    methods = Table(title, headings, rows, caption, words=frozenset({0}))
    across = () if found.tilted is None else (_across(found.tilted),)
    return [methods, *across, *(() if found.weather is None else (weather_table(found.weather),))]


def _across(tilted: TiltedContrast) -> Table:
    rows = tuple(
        (f"{difference:g}", *(f"{x:.3f}" for x in (*at_target, *at_mean)))
        for difference, at_target, at_mean in zip(
            tilted.difference, tilted.loss(tilted.fed_target), tilted.loss(tilted.fed_mean), strict=True
        )
    )
    return Table(
        "One side warmer than the other",
        ("K across", "fed the target's: mean", "worst line", "fed the middle's: mean", "worst line"),
        rows,
        "contrast lost against the uniform panel at most, whichever side is the warmer one;\n"
        f"{tilted.temperature.shape[1]} temperatures in the middle of the panel",
    )


def summary(found: Compensation, target: Path, seconds: float) -> str:
    """Return one line for people.

    Parameters
    ----------
    target : Path
        File it was written to.
    seconds : float
        It took, s.
    """
    t = found.temperature
    if found.judged == "left-out":
        return (
            f"{len(found.training_temperature)} temperatures measured; left out one by one from {t[0]:g} to "
            f"{t[-1]:g} °C, the networks lose at most {found.largest_loss[0]:.2g} of contrast (relative error "
            f"{_percent(_largest(found, 0))} % of energy); loses least: {found.best}, "
            f"recommended: {found.recommendation}; {seconds:.1f} s; {target}"
        )
    return (
        f"{len(found.training_temperature)} training temperatures, judged at {len(t)} from {t[0]:g} to {t[-1]:g} "
        f"°C: the networks lose at most {found.largest_loss[0]:.2g} of contrast (relative error "
        f"{_percent(_largest(found, 0))} % of energy); loses least: {found.best}, "
        f"recommended: {found.recommendation}; {seconds:.1f} s; {target}"
    )


def _largest(found: Compensation, method: int) -> float:
    return float(found.relative_error[method].max())


def _percent(value: float) -> str:
    """Two digits, and no exponent for large ones: 0.014, 2.1, 16, 230."""
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"
