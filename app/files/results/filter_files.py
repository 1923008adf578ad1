"""``filters.h5``: focusing filters over temperature, and how well they do."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py

from analysis.checked_fields import check_ascending
from analysis.focusing.methods import METHODS, Method, MethodComparison
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.focusing.pareto import ParetoCurve
from analysis.focusing.performance import Aim
from app.files.atomic import atomic_hdf5
from app.files.declarations.panel import panel_of_text
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp, stamp
from app.files.values import read_value, write_value


def save_focusing(
    target: Path,
    panel: Panel,
    focusing: Focusing,
    comparison: MethodComparison,
    made_from: Mapping[str, Any],
    uncorrected: Aim | None = None,
    pareto: ParetoCurve | None = None,
) -> None:
    """Write filters over temperature and the comparison of methods, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    uncorrected : Aim, optional
        What filters reach that were designed with the laws of a twin without its effects.
    pareto : ParetoCurve, optional
        Contrast against evenness of the sound, of filters that aim at sound.
    """
    with atomic_hdf5(target) as file:
        begin_result(file, panel, made_from)
        if uncorrected is not None:
            write_value(file.create_group("uncorrected"), uncorrected)
        if pareto is not None:
            write_value(file.create_group("pareto"), pareto)
        write_value(file.create_group("focusing"), focusing)
        write_value(file.create_group("comparison"), comparison)


def load_focusing(path: Path) -> tuple[Panel, Focusing, MethodComparison]:
    """Read back what `save_focusing` wrote."""
    with result_file(path, "focus") as file:
        panel = panel_of_text(str(file.attrs["panel"]), str(path))
        focusing = read_value(file["focusing"], Focusing)
        check_ascending(focusing, "temperature", "bank.temperature")  # of a result: splines and exports need it
        return panel, focusing, read_value(file["comparison"], MethodComparison)


def load_uncorrected(path: Path) -> Aim | None:
    """Read what filters reach that lack the correction; None where none was made."""
    with result_file(path, "focus") as file:
        return read_value(file["uncorrected"], Aim) if "uncorrected" in file else None


def load_pareto(path: Path) -> ParetoCurve | None:
    """Read contrast against evenness of the sound; None where the aim is the field."""
    with result_file(path, "focus") as file:
        return read_value(file["pareto"], ParetoCurve) if "pareto" in file else None


def load_method(path: Path) -> Method:
    """Read only how the filters were designed: by STIF or by a rival of it."""
    with result_file(path, "focus") as file:
        found = str(file["focusing"].attrs["method"])
        for method in METHODS:
            if method == found:
                return method
        raise ValueError(f"focusing: method {found!r}: {', '.join(METHODS)}")


def made_from_transfers(path: Path) -> bool:
    """Whether the filters were designed from measured transfers, not from a twin."""
    with result_file(path, "focus") as file:
        return bool(read_stamp(file)["settings"].get("measured", False))


def load_panel(path: Path) -> Panel:
    """Read only the panel a result was made for."""
    with result_file(path, "focus") as file:
        return panel_of_text(str(file.attrs["panel"]), str(path))


def begin_result(file: h5py.File, panel: Panel, made_from: Mapping[str, Any]) -> None:
    """Stamp a result file with what it was made from, and the panel it holds for.

    Parameters
    ----------
    file : h5py.File
        Open for writing.
    made_from : mapping
        Provenance.
    """
    stamp(file, made_from)
    file.attrs["panel"] = panel.model_dump_json()
