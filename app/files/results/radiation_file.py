"""``radiation.h5``: the sound that a panel radiates with its filters, over temperature."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.focusing.panel import Panel
from analysis.focusing.radiated import Radiation
from app.files.atomic import atomic_hdf5
from app.files.declarations.panel import panel_of_text
from app.files.hdf5_file import result_file
from app.files.results.filter_files import begin_result
from app.files.values import read_value, write_value


def save_radiation(target: Path, panel: Panel, radiation: Radiation, made_from: Mapping[str, Any]) -> None:
    """Write the sound of a panel, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        begin_result(file, panel, made_from)
        write_value(file.create_group("radiation"), radiation)


def load_radiation(path: Path) -> tuple[Panel, Radiation]:
    """Read back what `save_radiation` wrote."""
    with result_file(path, "radiation") as file:
        panel = panel_of_text(str(file.attrs["panel"]), str(path))
        return panel, read_value(file["radiation"], Radiation)
