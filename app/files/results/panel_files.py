"""``filters.h5``: focusing filters over temperature, and how well they do.

``compensation.h5``: networks, their rivals, and the test of both.

``radiation.h5``: the sound that a panel radiates with its filters, over temperature.

``studies.h5``: what the figures of the paper show of a panel.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes
from analysis.compensation.outcome import Compensation, NetworkStudy
from analysis.focusing.methods import METHODS, Method, MethodComparison
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.focusing.pareto import ParetoCurve
from analysis.focusing.performance import Aim
from analysis.focusing.played import Played
from analysis.focusing.radiated import Radiation
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError, quoted
from app.files.declarations.panel import panel_of_text
from app.files.hdf5_file import Value, read_value, result_file, write_value
from app.files.provenance import read_stamp, stamp


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


def other_filters(run: Path) -> list[str]:
    """Say that compensation.h5 of a run folder follows other filters than filters.h5 beside it, and which.

    Nothing is said where one of the files is not there, or cannot be read: who uses it says so.
    """
    design, follows = run / "filters.h5", run / "compensation.h5"
    if not (design.is_file() and follows.is_file()):
        return []
    try:
        method = load_method(design)
        with result_file(follows, "compensate") as file:
            followed = str(file["compensation"].attrs["focusing"])
        there, here = load_panel(design).model_dump(mode="json"), load_panel(follows).model_dump(mode="json")
    except ResultFileError:
        return []
    apart = [f"designed by {followed}, there by {method}"] if followed != method else []
    apart += _apart(here, there)
    if not apart:
        return []
    shown = apart[:MOST_APART] + ([f"and {len(apart) - MOST_APART} more"] if len(apart) > MOST_APART else [])
    return [
        f"compensation.h5 follows other filters than those of filters.h5 beside it ({'; '.join(shown)}); make it "
        f"again: flexura compensate {quoted(run)}"
    ]


MOST_APART = 3
"""Differences of two panels that are said."""


def _apart(here: Mapping[str, Any], there: Mapping[str, Any], within: str = "") -> list[str]:
    """Name the keys in which two declarations differ, with both values where these are short."""
    found = []
    for key in dict.fromkeys((*here, *there)):
        one, other, name = here.get(key), there.get(key), f"{within}{key}"
        if isinstance(one, dict) and isinstance(other, dict):
            found += _apart(one, other, f"{name}.")
        elif one != other:
            short = not isinstance(one, dict | list) and not isinstance(other, dict | list)
            found.append(f"{name} {_shown(one)}, there {_shown(other)}" if short else f"another {name}")
    return found


def _shown(value: object) -> str:
    return "not given" if value is None else repr(value) if isinstance(value, str) else str(value)


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


def save_compensation(
    target: Path, panel: Panel, compensation: Compensation, made_from: Mapping[str, Any]
) -> None:
    """Write networks and the test of every method, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    _save(target, panel, "compensation", compensation, made_from)


def load_compensation(path: Path) -> tuple[Panel, Compensation]:
    """Read back what `save_compensation` wrote."""
    return _load(path, "compensate", "compensation", Compensation)


def save_radiation(target: Path, panel: Panel, radiation: Radiation, made_from: Mapping[str, Any]) -> None:
    """Write the sound of a panel, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    _save(target, panel, "radiation", radiation, made_from)


def load_radiation(path: Path) -> tuple[Panel, Radiation]:
    """Read back what `save_radiation` wrote."""
    return _load(path, "radiation", "radiation", Radiation)


def _save(target: Path, panel: Panel, name: str, value: object, made_from: Mapping[str, Any]) -> None:
    """Write a value of a panel under its name."""
    with atomic_hdf5(target) as file:
        begin_result(file, panel, made_from)
        write_value(file.create_group(name), value)


def _load(path: Path, verb: str, name: str, kind: type[Value]) -> tuple[Panel, Value]:
    """Read a value of a panel; errors name the verb that makes the file."""
    with result_file(path, verb) as file:
        panel = panel_of_text(str(file.attrs["panel"]), str(path))
        return panel, read_value(file[name], kind)


@dataclass(frozen=True)
class Surfaces:
    """Taps of the networks over temperature (paper Fig. 16).

    Attributes
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    taps : (T, N, M) ndarray
        V per unit of audio signal.
    sample_rate : float
        Hz.
    """

    temperature: NDArray[np.float64]
    taps: NDArray[np.float64]
    sample_rate: float

    def __post_init__(self) -> None:
        check_shapes(self, temperature="T", taps="T N M")
        check_finite(self, "taps")
        check_range(self, 0.0, np.inf, "sample_rate", unit="Hz", above=True)


@dataclass(frozen=True)
class Studies:
    """What the figures asked for need; None where no figure asked for it."""

    played: Played | None = None
    fixed: Focusing | None = None
    compensation: Compensation | None = None
    surfaces: Surfaces | None = None
    nodes: NetworkStudy | None = None
    spacings: NetworkStudy | None = None


KINDS: Mapping[str, type] = {
    "played": Played,
    "fixed": Focusing,
    "compensation": Compensation,
    "surfaces": Surfaces,
    "nodes": NetworkStudy,
    "spacings": NetworkStudy,
}


def save_studies(target: Path, panel: Panel, studies: Studies, made_from: Mapping[str, Any]) -> None:
    """Write what was computed, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        begin_result(file, panel, made_from)
        for name in KINDS:
            value = getattr(studies, name)
            if value is not None:
                write_value(file.create_group(name), value)


def load_studies(path: Path) -> Studies:
    """Read back what `save_studies` wrote."""
    with result_file(path, "study") as file:
        held: dict[str, Any] = {
            name: read_value(_group(file, name), kind) for name, kind in KINDS.items() if name in file
        }
        return Studies(**held)


def _group(file: h5py.File, name: str) -> h5py.Group:
    group: h5py.Group = file[name]
    return group
