"""Every kind of file that is read, and the code that reads it for a verb or a window."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from pydantic import BaseModel

from analysis.experiment import Experiment
from analysis.focusing.grid import Grid
from app.files import control, events, latest_repeat, readings
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaign_folder import frozen_protocol, read_protocol
from app.files.campaign_toml import read_experiment
from app.files.experiment_toml import read_acquired_experiment
from app.files.frf_file import load_frf
from app.files.laws_file import effects_in_laws, load_laws, load_updated
from app.files.measurements.guarded import read_columns
from app.files.modal_test_toml import read_modal_test
from app.files.modes_file import load_modes
from app.files.panel_file import read_panel
from app.files.recorded_campaign import read_recording
from app.files.sound_file import opened_sound
from app.files.sweep_file import read_sweep_file
from app.files.tdms_sweep import read_sweep
from app.files.twin_file import read_twin
from app.files.uff58 import read_frfs
from app.report.origin import stamps
from app.sound.temperatures import programme

EXPERIMENTS = (
    "simulated-rig.toml",
    "exciter.toml",
    "paper-protocol.toml",
    "hidden-effect.toml",
    "clamped-disc.toml",
)
PANELS = ("section2-panel.toml",)
SWEEP = "sweeps/0000_up_T+010.0.h5"
TDMS = "recording/sweeps/000.tdms"


@dataclass(frozen=True)
class Reader:
    """How a kind of file is read.

    Attributes
    ----------
    name : str
    files : tuple of str
        Those that are damaged, one at a time; relative to the folder of all.
    read : callable
        Given that folder and the file, returns what was read.
    share : float
        Of all mutations.
    text : bool
    digest : bool
        Whether any change of a byte has to be noticed, or to change nothing that is read.
    """

    name: str
    files: tuple[str, ...]
    read: Callable[[Path, str], object]
    share: float
    text: bool = False
    digest: bool = False


def _tdms(root: Path, name: str) -> object:
    sweep, problems = read_sweep(root / name, name, _declared(root / "recording"))
    return refused(root, problems) if sweep is None else sweep


def _sweep(root: Path, name: str) -> object:
    sweep, problem = read_sweep_file(root / name, name)
    return refused(root, [problem]) if sweep is None else sweep


def refused(root: Path, problems: Sequence[Problem | None]) -> NoReturn:
    """Raise what the reader of a whole campaign raises for one file's problems."""
    raise CampaignFileError(root, [problem for problem in problems if problem is not None])


@lru_cache(maxsize=1)
def _declared(folder: Path) -> Experiment:
    return read_experiment(folder)


def _experiment(root: Path, name: str) -> object:
    declared = read_acquired_experiment(root / name)
    recorded = declared.on("simulated").recorded(declared.sample_rate)
    frozen = frozen_protocol("x", recorded, {}, {"rig": "simulated", **declared.model_dump(mode="json")})
    return declared.protocol.seconds(20.0), declared.sensitivities, frozen


def _panel(root: Path, name: str) -> object:
    panel = read_panel(root / name)
    return panel, Grid.of(panel)


def _twin(root: Path, name: str) -> object:
    twin = read_twin(root / name)
    return twin, twin.experiment(), twin.effects


def _window(root: Path, name: str) -> object:
    from app.view.live.watched import Watched

    window = _live_window(root / "live")
    window._watched, window._logged = Watched(root / "live"), 0  # another window would take ten times as long
    window.look()
    return events.read_events(root / "live")


@lru_cache(maxsize=1)
def _live_window(folder: Path) -> Any:
    from app.view.application import application
    from app.view.live.watched import Watched
    from app.view.live.window import LiveWindow
    from app.view.theme import LIGHT

    application()
    return LiveWindow(Watched(folder), LIGHT)


def _sound(root: Path, name: str) -> object:
    with opened_sound(root / name) as sound:
        return sound.sample_rate, [block.sum() for block in sound.blocks(4096)]


def _programme(root: Path, name: str) -> object:
    course = programme(str(root / name), 10.0)
    return course.time, course.temperature


RESULTS: dict[str, Callable[[Path], object]] = {
    "run/frf.h5": load_frf,
    "run/modes.h5": load_modes,
    "run/laws.h5": lambda path: (load_laws(path), load_updated(path), effects_in_laws(path)),
}


def _result(root: Path, name: str) -> object:
    return RESULTS[name](root / name), stamps(root / "run", [Path(name).name])


MEASUREMENTS = tuple(f"measured/a.{ending}" for ending in ("csv", "mat", "wav", "npz", "lvm", "tdms", "uff"))

READERS = (
    Reader("measurements", MEASUREMENTS, lambda root, name: read_columns(root / name), 0.02),
    Reader(
        "TOML, test", ("measured/test.toml",), lambda root, name: read_modal_test(root / name), 0.03, text=True
    ),
    Reader("TDMS", (TDMS,), _tdms, 0.15),
    Reader("UFF", ("frfs.uff",), lambda root, name: read_frfs(root / name), 0.08, text=True),
    Reader("UFF, binary", ("binary.uff",), lambda root, name: read_frfs(root / name), 0.07),
    Reader("HDF5, results", tuple(RESULTS), _result, 0.2, digest=True),
    Reader(
        "HDF5, sweep",
        (f"imported/{SWEEP}",),
        _sweep,
        0.1,
        digest=True,
    ),
    Reader(
        "HDF5, sweep of an earlier version",
        (f"old/{SWEEP}",),
        _sweep,
        0.005,
        digest=True,
    ),
    Reader(
        "HDF5, last repeat",
        ("live/latest.h5",),
        lambda root, _: latest_repeat.load_latest(root / "live"),
        0.03,
        digest=True,
    ),
    Reader(
        "TOML, recording",
        ("recording/campaign.toml",),
        lambda root, _: read_recording(root / "recording"),
        0.06,
        text=True,
    ),
    Reader("TOML, experiment", EXPERIMENTS, _experiment, 0.06, text=True),
    Reader("TOML, panel", PANELS, _panel, 0.03, text=True),
    Reader("TOML, twin", ("twin.toml",), _twin, 0.03, text=True),
    Reader(
        "JSON, protocol",
        ("imported/protocol.json",),
        lambda root, _: read_protocol(root / "imported"),
        0.04,
        text=True,
        digest=True,
    ),
    Reader(
        "JSON, log",
        ("imported/events.jsonl",),
        lambda root, _: events.read_events(root / "imported"),
        0.035,
        text=True,
    ),
    Reader("WAV", ("sound.wav",), _sound, 0.02),
    Reader("FLAC", ("sound.flac",), _sound, 0.02),
    Reader("CSV, temperatures", ("readings.csv",), _programme, 0.01, text=True),
    Reader("control", (f"live/{control.NAME}",), lambda root, _: control.wished(root / "live"), 0.03, text=True),
    Reader("window", (f"live/{events.NAME}", f"live/{readings.NAME}"), _window, 0.03, text=True),
)


def fingerprint(value: object) -> str:
    """Digest of what was read, the same for the same values."""
    digest = hashlib.sha256()
    _feed(digest.update, value)
    return digest.hexdigest()


def _feed(update: Callable[[bytes], Any], value: object) -> None:
    if isinstance(value, BaseModel):
        update(value.model_dump_json().encode())
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            _feed(update, getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, dict):
        for key in sorted(value):
            update(str(key).encode())
            _feed(update, value[key])
    elif isinstance(value, tuple | list):
        for part in value:
            _feed(update, part)
    else:
        update(repr(value).encode())
