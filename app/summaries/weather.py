"""Filters in a weather: a table, a record and a note."""

from typing import Any

from analysis.weather.judgement import WeatherJudgement
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
