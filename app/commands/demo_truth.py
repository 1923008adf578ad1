"""True laws and effects of the demo's simulated plates, compared with the results."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.files.shipped import shipped

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from rich.table import Table

    from analysis.experiment import Experiment
    from analysis.material import Material
    from app.summaries.gap import Record

EXPERIMENT = shipped("simulated-rig.toml")
PUZZLE = shipped("hidden-effect.toml")


def laws_beside(run: Path) -> "tuple[np.ndarray[Any, np.dtype[np.float64]], Material, Material]":
    """Temperatures of the acquired campaign, °C, and the laws there: put into the plate, and found."""
    import numpy as np

    from app.files.best_twin import best_twin
    from app.files.experiment_toml import read_acquired_experiment

    experiment = read_acquired_experiment(EXPERIMENT)
    if experiment.simulation is None:
        raise ValueError(f"{EXPERIMENT} simulates nothing")
    laws = best_twin(run, "report").twin.laws
    if laws is None:
        raise ValueError(f"{run}: too few temperatures for laws")
    temperature = np.array(experiment.protocol.recorded().temperatures)
    low, high = laws.temperature_range
    temperature = temperature[(temperature >= low) & (temperature <= high)]
    return temperature, experiment.simulation.laws.laws().at(temperature), laws.at(temperature)


def laws_table(run: Path) -> "Table":
    """Table of the laws found in the acquired campaign and those of the simulated plate."""
    import numpy as np
    from rich.table import Table

    temperature, put_in, found = laws_beside(run)
    table = Table(title="The simulated plate: laws put in, laws found", header_style="bold")
    for heading in ("T [°C]", "E put in [GPa]", "found", "ν put in", "found", "η put in [%]", "found"):
        table.add_column(heading, justify="right")
    columns = (
        (put_in.youngs_modulus, found.youngs_modulus, 1e9, ".4f"),
        (put_in.poisson_ratio, found.poisson_ratio, 1.0, ".4f"),
        (put_in.loss_factor, found.loss_factor, 0.01, ".3f"),
    )
    for t, degrees in enumerate(temperature):
        row = [f"{value[t] / unit:{form}}" for *pair, unit, form in columns for value in pair]
        table.add_row(f"{degrees:.0f}", *row)
    off = {
        "E": f"{100 * np.abs(found.youngs_modulus / put_in.youngs_modulus - 1.0).max():.3f} %",
        "ν": f"{np.abs(found.poisson_ratio - put_in.poisson_ratio).max():.5f}",
        "η": f"{100 * np.abs(found.loss_factor / put_in.loss_factor - 1.0).max():.3f} %",
    }
    table.caption = "largest difference: " + ", ".join(f"{name} {value}" for name, value in off.items())
    return table


def effects_beside(run: Path) -> "tuple[dict[str, dict[str, float]], Record]":
    """Effects hidden in the last campaign's plate, and the result of `flexura gap`."""
    from app.files.gap_file import load_gap

    return puzzle_experiment()[1], load_gap(run / "gap.h5")[1]


def puzzle_experiment() -> "tuple[Experiment, dict[str, dict[str, float]]]":
    """Read the declaration of the last campaign, and the effects hidden in its plate."""
    from app.files.experiment_toml import read_acquired_experiment

    experiment = read_acquired_experiment(PUZZLE)
    if experiment.simulation is None:
        raise ValueError(f"{PUZZLE} simulates nothing")
    return experiment.recorded(experiment.sample_rate), experiment.simulation.effects


def put_in() -> "Iterator[tuple[str, str]]":
    """Yield the effects hidden in the last campaign's plate, with values and units."""
    from app.summaries.with_sigma import with_sigma
    from simulation.effects.library import LIBRARY

    experiment, effects = puzzle_experiment()
    for name, values in effects.items():
        card = LIBRARY[name].card(experiment)
        units = {parameter.name: parameter.unit for parameter in card.parameters}
        yield name, ", ".join(f"{key} {with_sigma(value, 0.0, units[key])}" for key, value in values.items())


def effects_table(run: Path) -> "Table":
    """Table of the effects hidden in the last campaign's plate and those named by `flexura gap`."""
    from rich.table import Table

    from app.files.gap_file import load_gap
    from app.summaries.gap import estimate, gap_closed, named, verdict_words

    gap = load_gap(run / "gap.h5")[1]
    table = Table(title="The plate with something hidden: what it is, what was found", header_style="bold")
    for heading in ("", "effect", "values"):
        table.add_column(heading)
    for name, values in put_in():
        table.add_row("put in", name, values)
    for effect in gap["effects"]:
        values = ", ".join(f"{key} {estimate(found)}" for key, found in effect["parameters"].items())
        table.add_row("found", named(effect), values)
    closed = gap_closed(gap["gap"]["held_out"])
    table.caption = verdict_words(gap["verdict"]) + (
        f"; {closed} of the gap closes on held-out data" if closed else ""
    )
    return table
