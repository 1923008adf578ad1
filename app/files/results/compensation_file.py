"""``compensation.h5``: networks, their rivals, and the test of both."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.compensation.outcome import Compensation
from analysis.focusing.panel import Panel
from app.files.atomic import atomic_hdf5
from app.files.declarations.panel import panel_of_text
from app.files.hdf5_file import result_file
from app.files.results.filter_files import begin_result
from app.files.values import read_value, write_value


def save_compensation(
    target: Path, panel: Panel, compensation: Compensation, made_from: Mapping[str, Any]
) -> None:
    """Write networks and the test of every method, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        begin_result(file, panel, made_from)
        write_value(file.create_group("compensation"), compensation)


def load_compensation(path: Path) -> tuple[Panel, Compensation]:
    """Read back what `save_compensation` wrote."""
    with result_file(path, "compensate") as file:
        panel = panel_of_text(str(file.attrs["panel"]), str(path))
        return panel, read_value(file["compensation"], Compensation)
