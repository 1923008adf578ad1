"""Declarations, recorded and acquired campaigns, and what a campaign under way leaves in its folder."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from analysis.experiment import Experiment
from analysis.focusing.energy import Grid
from analysis.recordings.frf import campaign_frf
from app.blind_trial.outcome import read_outcome
from app.blind_trial.trial import Trial, begin
from app.files.acquisition import events
from app.files.acquisition.hammer_folder import hit_doubts, open_hammer_folder
from app.files.campaigns.channels import RecorderLayout, read_declaration
from app.files.campaigns.folder import Source, frozen_protocol, read_protocol, read_sweep_file
from app.files.campaigns.recorded import read_recording
from app.files.campaigns.tdms_sweep import read_sweep
from app.files.declarations.experiment import read_acquired_experiment
from app.files.declarations.hammer_experiment import read_hammer_experiment
from app.files.declarations.instruments import declared_instruments
from app.files.declarations.panel import read_panel, read_weather
from app.files.results.twin_file import read_twin
from app.fleet.fleet_run import fleet_members
from app.plate_frfs.given_campaign import read_plate
from app.plate_frfs.plate_of_modes import read_plate_of_modes
from app.stages.acquire_hammer import interrupted_at
from app.terminal.cluster import _address_in
from drivers.hammer.judged_hit import HammerProgress, HitJudge
from tests.fuzz.reader import Reader, refused

EXPERIMENTS = (
    "simulated-rig.toml",
    "exciter.toml",
    "paper-protocol.toml",
    "hidden-effect.toml",
    "clamped-disc.toml",
)
HAMMERS = ("hammer-rig.toml",)
PANELS = ("section2-panel.toml",)
WEATHERS = ("warming-car.toml",)
INSTRUMENTS = ("instruments/modbus-map.toml", "instruments/scpi.toml")
SWEEP = "sweeps/0000_up_T+010.0.h5"
HIT = "hammered/hits/00000_point001.h5"
TDMS = ("recording/sweeps/000.tdms", "recorder/sweeps/log.tdms")
TRIAL = Trial(Path("trial"), 2, 7, ("null", "single"))
"""Relative to the folder of all."""


def _tdms(root: Path, name: str) -> object:
    sweep, problems = read_sweep(root / name, name, *_declared((root / name).parents[1]))
    return refused(root, problems) if sweep is None else sweep


def _sweep(root: Path, name: str) -> object:
    sweep, problem = read_sweep_file(root / name, name)
    return refused(root, [problem]) if sweep is None else sweep


@lru_cache(maxsize=len(TDMS))
def _declared(folder: Path) -> tuple[Experiment, RecorderLayout]:
    return read_declaration(folder)


def _experiment(root: Path, name: str) -> object:
    declared = read_acquired_experiment(root / name)
    recorded = declared.on("simulated").recorded(declared.sample_rate)
    frozen = frozen_protocol("x", recorded, {}, {"rig": "simulated", **declared.model_dump(mode="json")})
    return declared.protocol.seconds(20.0), declared.sensitivities, frozen


def _hammer(root: Path, name: str) -> object:
    declared = read_hammer_experiment(root / name)
    return declared.struck(), declared.channels, declared.units, declared.volts, declared.model_dump(mode="json")


def _hammered(root: Path, name: str) -> object:
    declared = read_hammer_experiment(root / HAMMERS[0])
    judge = HitJudge(declared.hammer.test(), declared.volts, declared.channels, 5.0)
    acquired = declared.model_dump(mode="json") | {"rig": "simulated"}
    folder = open_hammer_folder(root / "hammered", declared, acquired, Source("mine.toml", "0" * 64), judge)
    progress = HammerProgress.of(len(declared.mallet.places), 5, folder.kept(), folder.events())
    doubts = hit_doubts(root / "hammered", [HIT.removeprefix("hammered/")])
    return progress, doubts, [folder.measured(hit) for hit in progress.valid], interrupted_at(root / "hammered")


def _panel(root: Path, name: str) -> object:
    panel = read_panel(root / name)
    return panel, Grid.of(panel)


def _weather(root: Path, name: str) -> object:
    weather = read_weather(root / name)
    points = np.array([one.point for one in weather.thermometer])
    return [
        (around.air_at(10.0), around.sun_at(10.0), around.lit_at(points))
        for around in (weather.front, weather.back)
    ]


def _twin(root: Path, name: str) -> object:
    twin = read_twin(root / name)
    return twin, twin.experiment(), twin.effects


def _instruments(root: Path, name: str) -> object:
    declared = declared_instruments(str(root / name))
    return declared, declared.places


def _trial(root: Path, name: str) -> object:
    trial = Trial(root / TRIAL.folder, TRIAL.count, TRIAL.seed, TRIAL.kinds)
    return begin(trial), [read_outcome(trial.truth(a), trial.run(a)) for a in trial.assignments]


def _window(root: Path, name: str) -> object:
    from app.watch.watched import Watched

    window = _live_window(root / "live")
    window._watched, window._logged = Watched(root / "live"), 0  # another window would take ten times as long
    window.look()
    return events.read_events(root / "live")


@lru_cache(maxsize=1)
def _live_window(folder: Path) -> Any:
    from app.view.application import application
    from app.view.live.window import LiveWindow
    from app.view.theme import LIGHT
    from app.watch.watched import Watched

    application()
    return LiveWindow(Watched(folder), LIGHT)


TRIAL_FILES = (
    str(TRIAL.folder / "trial.json"),
    *(str(TRIAL.truth(a)) for a in TRIAL.assignments),
    *(str(TRIAL.run(a) / "gap.json") for a in TRIAL.assignments),
)
CAMPAIGNS = (
    Reader("TDMS", TDMS, _tdms, 0.1),
    Reader("HDF5, sweep", (f"imported/{SWEEP}",), _sweep, 0.06, digest=True),
    Reader("HDF5, sweep of an earlier version", (f"old/{SWEEP}",), _sweep, 0.005, digest=True),
    Reader(
        "HDF5, last repeat",
        ("live/latest.h5",),
        lambda root, _: events.load_latest(root / "live"),
        0.02,
        digest=True,
    ),
    Reader(
        "TOML, recording",
        ("recording/campaign.toml", "recorder/campaign.toml"),
        lambda root, name: read_recording((root / name).parent),
        0.05,
        text=True,
    ),
    Reader(
        "plate with FRFs",
        ("plate/plate.toml", "plate/frfs.uff"),
        lambda root, _: campaign_frf(read_plate(root / "plate")),
        0.02,
        text=True,
    ),
    Reader(
        "plate with modes",
        ("modal/plate.toml", "modal/modes.csv"),
        lambda root, _: read_plate_of_modes(root / "modal"),
        0.02,
        text=True,
    ),
    Reader("TOML, experiment", EXPERIMENTS, _experiment, 0.05, text=True),
    Reader("TOML, hammer test", HAMMERS, _hammer, 0.05, text=True),
    Reader("hammer test", ("hammered/hammer.json", "hammered/events.jsonl"), _hammered, 0.02, text=True),
    Reader("HDF5, hit", (HIT,), _hammered, 0.02, digest=True),
    Reader("TOML, instruments", INSTRUMENTS, _instruments, 0.03, text=True),
    Reader("TOML, panel", PANELS, _panel, 0.03, text=True),
    Reader("TOML, weather", WEATHERS, _weather, 0.03, text=True),
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
        0.03,
        text=True,
    ),
    Reader("list of campaigns", ("fleet.txt",), lambda root, name: fleet_members([root / name]), 0.02, text=True),
    Reader("JSON, scheduler", ("scheduler.json",), lambda root, name: _address_in(root / name), 0.01, text=True),
    Reader("JSON, blind trial", TRIAL_FILES, _trial, 0.02, text=True),
    Reader(
        "control",
        (f"live/{events.CONTROL}",),
        lambda root, _: events.requested(root / "live"),
        0.03,
        text=True,
    ),
    Reader("window", (f"live/{events.NAME}", f"live/{events.READINGS}"), _window, 0.03, text=True),
)
