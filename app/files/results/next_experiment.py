"""``next-experiment.toml``: the campaign that a plan asks for, as an experiment file for `flexura acquire`."""

import re
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from analysis.experiment import Protocol
from analysis.gap.plan.measurement import Measurement, Reach
from analysis.protocol.objections import ALIAS_FREE_SHARE
from app.files.atomic import write_text
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import read_protocol
from app.files.campaigns.kind import is_campaign_folder
from app.files.declarations.experiment import (
    AcquiredExperiment,
    read_acquired_experiment,
    read_declared_experiment,
)
from app.files.settings_toml import read_table, toml_text

NAME = "next-experiment.toml"
LASER_SENSITIVITY = 20.0
"""V per m/s of a further sensor, to be replaced by its own: 50 mm/s per volt, a usual range of lasers."""
MOVE_SHARE = 0.4
"""Share of the tolerance by which the temperature may move between two readings."""


def rig_table(campaign: Path, experiment: Path | None) -> dict[str, Any] | None:
    """Return the experiment's file by which a campaign was acquired, as a table.

    Parameters
    ----------
    campaign : Path
        Its folder.
    experiment : Path or None
        The file, where it is named: it alone has what a simulated plate is made of.

    Returns
    -------
    dict or None
        None for a campaign that was recorded by another program, and for a simulated one without its file.

    Raises
    ------
    CampaignFileError
        For a file that is no experiment.
    """
    if experiment is not None:
        read_declared_experiment(experiment)
        return read_table(experiment)
    if not is_campaign_folder(campaign):
        return None
    acquired = read_protocol(campaign)[0].get("acquired")
    if not isinstance(acquired, Mapping) or acquired.get("rig") == "simulated":
        return None
    return deepcopy({key: value for key, value in acquired.items() if key != "simulation"})


def reach_of(experiment: AcquiredExperiment) -> Reach:
    """Return what the rig of an experiment can do."""
    oven, limits, programme = experiment.oven, experiment.limits, experiment.programme
    rated = experiment.exciter.rated_force if experiment.exciter else limits.patch_voltage
    level = experiment.cards.output_range
    if rated is not None:
        level = min(level, rated / experiment.drive_gain)
    low, high = max(oven.minimum, limits.coldest), min(oven.maximum, limits.hottest)
    if experiment.simulation is not None:
        known = experiment.simulation.laws.temperature
        low, high = max(low, known[0]), min(high, known[-1])
    sweep = experiment.sweep
    beyond = sweep.frequency_range[1] / sweep.band[1]
    return Reach(
        level=level,
        temperatures=(low + programme.lead, high - programme.lead),
        rate=oven.max_rate,
        highest=ALIAS_FREE_SHARE * experiment.sample_rate / beyond**1.1,
    )


def write_next_experiment(target: Path, table: Mapping[str, Any], chosen: Measurement) -> str:
    """Write the experiment of a planned campaign, and read it back as `flexura acquire` would.

    Parameters
    ----------
    table : mapping
        Of `rig_table`.
    chosen : Measurement
        With an experiment.

    Returns
    -------
    str
        What has to be filled in before it can be run; empty where nothing has.

    Raises
    ------
    ValueError
        For a measurement that is no campaign.
    """
    if chosen.experiment is None:
        raise ValueError(f"{chosen.key} is no campaign: there is no experiment to write")
    changed = deepcopy(dict(table))
    protocol = chosen.experiment.protocol
    changed["title"] = f"{changed['title']}: {chosen.key.replace('_', ' ')}"
    changed["sweep"] |= {"band": list(protocol.band), "levels": list(protocol.levels)}
    changed["programme"] |= _programme(changed["programme"], protocol)
    wanted = []
    if chosen.key == "further_sensor" and chosen.place is not None:
        wanted = _with_sensor(changed, chosen.place)
    if chosen.mass and chosen.place is not None and changed.get("simulation"):
        effects = changed["simulation"].setdefault("effects", {})
        effects.setdefault("mass_at_place", {"mass": chosen.mass, "x": chosen.place[0], "y": chosen.place[1]})
    lines = [f"{chosen.words} Planned by flexura gap --plan.", *wanted]
    write_text(target, toml_text(changed, "\n".join(lines)))
    try:
        read_acquired_experiment(target)
    except CampaignFileError as error:
        return f"{target.name} has to be completed: {error}"
    return " ".join(wanted)


def _programme(table: Mapping[str, Any], protocol: Protocol) -> dict[str, Any]:
    """Return what changes of a programme; set-points are evenly spaced in it."""
    lowest, highest, count = protocol.temperatures[0], protocol.temperatures[-1], len(protocol.temperatures)
    every = (highest - lowest) / (count - 1) if count > 1 else table["every"]
    changed: dict[str, Any] = {
        "lowest": lowest,
        "highest": highest,
        "every": round(every, 6),
        "legs": list(protocol.directions),
        "ramp_rate": protocol.ramp_rate,
    }
    tolerance = float(table.get("tolerance", 0.5))
    most = MOVE_SHARE * tolerance * 60.0 / protocol.ramp_rate
    if float(table.get("poll_interval", 5.0)) > most:
        changed["poll_interval"] = round(float(np.floor(10.0 * most) / 10.0), 1)
    return changed


def _with_sensor(table: dict[str, Any], place: tuple[float, float]) -> list[str]:
    """Declare a further sensor and its terminal; say what is assumed of it."""
    taken = {one["id"] for one in table.get("sensor") or ()}
    name = next(f"further{k}" for k in range(1, len(taken) + 2) if f"further{k}" not in taken)
    table["sensor"] = [
        *(table.get("sensor") or ()),
        {"id": name, "kind": "velocity", "point": list(place), "sensitivity": LASER_SENSITIVITY},
    ]
    responses = list(table["cards"]["responses"])
    table["cards"]["responses"] = [*responses, _next_terminal(responses[-1])]
    return [
        f"Sensor {name}: put in its kind, its sensitivity ({LASER_SENSITIVITY:g} V per m/s is assumed) and its "
        "terminal (the last of cards.responses)."
    ]


def _next_terminal(name: str) -> str:
    """Return the terminal after one, by its number."""
    found = re.search(r"(\d+)$", str(name))
    return f"{name[: found.start()]}{int(found.group()) + 1}" if found else f"{name} 2"
