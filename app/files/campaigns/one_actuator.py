"""A recording in which several actuators drove the plate, one after the other: which one drove, and one alone.

Every sweep's file names its actuator in the root property ``actuator``, or ``[sweeps]`` does. Of the others,
patches are held at 0 V, as the output of an amplifier at rest holds them, and forces do not act.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from nptdms import TdmsFile

from analysis.experiment import Experiment
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.channels import ACTUATOR, RecorderLayout
from app.files.campaigns.tdms_file import said_by_nptdms


def actuators(table: Mapping[str, Any]) -> list[str]:
    """Names of all that a declaration, unchecked, says drives the plate."""
    patches = [p for p in _tables(table, "patch") if p.get("role") == "actuator"]
    return [str(one.get("id")) for one in (*patches, *_tables(table, "drive"))]


def driven_by(path: Path, table: Mapping[str, Any], actuator: str | None) -> Mapping[str, Any]:
    """Return the declaration with only the actuator named, if one is; the others are shorted or left out.

    Parameters
    ----------
    path : Path
        File of the declaration, for messages.
    table : mapping
        Its keys and values, unchecked.
    actuator : str or None
        Identifier; None leaves the declaration as it is.

    Raises
    ------
    CampaignFileError
        For an actuator that is not declared.
    """
    if actuator is None:
        return table
    names = actuators(table)
    if actuator not in names:
        allowed = ", ".join(names) or "an actuator, of which the file declares none"
        raise CampaignFileError(path.parent, [Problem(path.name, "--actuator", repr(actuator), allowed)])
    patches = [
        one | {"role": "shorted"} if one.get("role") == "actuator" and one.get("id") != actuator else one
        for one in _tables(table, "patch")
    ]
    drives = [one for one in _tables(table, "drive") if one.get("id") == actuator]
    changed = {"patch": patches, "drive": drives}
    return {**table, **{key: value for key, value in changed.items() if key in table}}


def source_of(
    name: str, properties: Mapping[str, Any], experiment: Experiment
) -> tuple[int | None, list[Problem]]:
    """Return which of an experiment's inputs drove a sweep, or what is wrong with the name of it.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    properties : mapping
        Of its root.

    Returns
    -------
    source : int or None
    problems : list of Problem
    """
    names = [one.id for one in experiment.inputs]
    if len(names) == 1:
        return 0, []
    named = properties.get(ACTUATOR)
    return (names.index(named), []) if named in names else (None, [_unnamed(name, named, names)])


def _unnamed(name: str, named: object, names: Sequence[str]) -> Problem:
    seen = repr(named) if named else "nothing"
    return Problem(name, ACTUATOR, seen, " or ".join(names), "which one drove?")


def sweeps_of(
    files: Sequence[Path], actuator: str, names: Sequence[str], recorder: RecorderLayout
) -> tuple[list[Path], list[Problem]]:
    """Choose the files of the sweeps that one of several actuators drove.

    A file that cannot be read counts as one of them: its reader says why.

    Parameters
    ----------
    names : sequence of str
        All actuators declared.
    recorder : RecorderLayout
        What is declared of files that have a layout of their own.

    Returns
    -------
    chosen : list of Path
    problems : list of Problem
        Files that name none of `names`.
    """
    chosen, problems = [], []
    for path in files:
        named = _actuator_of(path, recorder)
        if named is None or named == actuator:
            chosen.append(path)
        elif named not in names:
            problems.append(_unnamed(f"sweeps/{path.name}", named, names))
    return chosen, problems


def _actuator_of(path: Path, recorder: RecorderLayout) -> str | None:
    try:
        with path.open("rb") as file, said_by_nptdms():  # a handle: see `app.files.campaigns.tdms_file`
            properties = TdmsFile.read_metadata(file).properties
        return str(recorder.properties(path.name, properties).get(ACTUATOR, ""))
    except Exception:  # noqa: BLE001 (on damaged bytes npTDMS raises what it runs into)
        return None


def _tables(table: Mapping[str, Any], key: str) -> list[dict[str, Any]]:
    found = table.get(key, [])
    return [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []
