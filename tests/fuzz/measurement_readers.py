"""Signals, FRFs, sounds, tables, drawings and meshes of other programs."""

from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from analysis.focusing.energy import Grid
from analysis.focusing.panel import Panel
from analysis.material import MaterialBox
from app.files.basis_cache import reducing
from app.files.declarations.modal_test import read_modal_test
from app.files.declarations.panel import read_panel
from app.files.measurements.guarded import read_columns
from app.files.results.panel_files import load_panel
from app.files.sound_file import opened_sound
from app.files.uff.frfs import read_frfs
from app.modal_test.declared_test import declared_frfs
from app.modal_test.new_declaration import points_of_table
from app.sound.listening import ListeningPanel, recorded
from app.sound.temperatures import programme
from app.stages.panel.inputs import measured_panel
from simulation.shell.shell_plate import ShellPlate
from tests.fuzz.reader import Reader

FILES = ("csv", "mat", "wav", "npz", "lvm", "tdms", "uff", "h5", "nc", "nc4", "sdynpy.npz", "v73.mat", "D.uff")
FILES_OF_EXTRAS = ("xlsx", "mf4")
MEASURED = tuple(f"measured/a.{ending}" for ending in FILES)
DRAWINGS = ("drawn/splines.dxf", "drawn/lines.dxf", "drawn/plate.svg")
MESHES = ("drawn/ascii.msh", "drawn/binary.msh", "drawn/entities.msh", "drawn/blocks.e")
FILTERS = "panel/filters.h5"


def _drawn(root: Path, name: str) -> object:
    """Read the panel that names a drawing, as ``flexura focus --panel`` does."""
    panel = read_panel((root / name).with_suffix(".toml"))
    return panel, Grid.of(panel)


def _meshed(root: Path, name: str) -> object:
    panel = read_panel((root / name).with_suffix(".toml"))
    with reducing(MaterialBox((1e9, 2e9), (0.3, 0.4), (0.01, 0.1)), panel.filters.edges):
        return panel, ShellPlate.of(panel.plate, panel.patch, degree=1).space.mesh


def _transfers(root: Path, name: str) -> object:
    measured = measured_panel(_panel(root / FILTERS), root / name, ())
    return measured.transfers, measured.grid


@lru_cache(maxsize=1)
def _panel(path: Path) -> Panel:
    return load_panel(path)


def _sound(root: Path, name: str) -> object:
    with opened_sound(root / name) as sound:
        return sound.sample_rate, [block.sum() for block in sound.blocks(4096)]


def _heard(root: Path, name: str) -> object:
    """Read a recording of four patches, as ``flexura thermometer`` does; of the twin it asks only their number."""
    twin = SimpleNamespace(reduced=SimpleNamespace(capacitance=np.ones(4)))
    panel = ListeningPanel(cast("Any", twin), cast("Any", None), 3)
    with opened_sound(root / "heard/drive.wav") as drive, opened_sound(root / "heard/response.wav") as response:
        return recorded(drive, response, panel, ("A0", "A1", "A2", "A3"), 360.0)


def _programme(root: Path, name: str) -> object:
    course = programme(str(root / name), 10.0)
    return course.time, course.temperature


MEASUREMENTS = (
    Reader("measurements", MEASURED, lambda root, name: read_columns(root / name), 0.02),
    Reader(
        "measurements of extras",
        tuple(f"measured/a.{ending}" for ending in FILES_OF_EXTRAS),
        lambda root, name: read_columns(root / name),
        0.01,
    ),
    Reader("CSV, points", ("measured/points.csv",), lambda root, name: points_of_table(root / name), 0.005, True),
    Reader(
        "TOML, test", ("measured/test.toml",), lambda root, name: read_modal_test(root / name), 0.02, text=True
    ),
    Reader(
        "modal test",
        ("measured/a.csv", "measured/test.toml"),
        lambda root, _: declared_frfs(root / "measured", lambda stage, share: None),
        0.005,
        text=True,
    ),
    Reader("UFF", ("frfs.uff",), lambda root, name: read_frfs(root / name), 0.06, text=True),
    Reader("UFF, binary", ("binary.uff",), lambda root, name: read_frfs(root / name), 0.05),
    Reader("UFF, measured transfers", ("panel/scan.uff",), _transfers, 0.015, text=True),
    Reader("HDF5, measured transfers", ("panel/scan.h5",), _transfers, 0.02, digest=True),
    Reader("HDF5, transfers of others", ("panel/others.h5",), _transfers, 0.005),
    Reader("drawings", DRAWINGS, _drawn, 0.025, text=True),
    Reader("meshes", MESHES, _meshed, 0.02, text=True),
    Reader("WAV", ("sound.wav",), _sound, 0.015),
    Reader("FLAC", ("sound.flac",), _sound, 0.015),
    Reader("WAV, panel that listens", ("heard/drive.wav", "heard/response.wav"), _heard, 0.02),
    Reader("CSV, temperatures", ("readings.csv",), _programme, 0.02, text=True),
)
