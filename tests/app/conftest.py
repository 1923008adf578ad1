"""A recorded campaign small enough to be written, and broken, for every test."""

import copy
import importlib.util
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter
from numpy.typing import NDArray
from scipy.signal import chirp, lfilter

from drivers.rig import occupancy

RATE = 51_200.0 / 6
SAMPLES = 1536
TOML = f"""\
format = "recorded-campaign/1"
title = "tiny plate"

[plate]
length_x = 0.24
length_y = 0.19
thickness = 0.003
mass = 0.13

[[patch]]
id = "A1"
role = "actuator"
center = [0.2, 0.155]
size = [0.02, 0.02]
thickness = 0.0005
side = "top"
material = "NCE51"

[[patch]]
id = "S1"
role = "sensor"
center = [0.04, 0.035]
size = [0.02, 0.02]
thickness = 0.0005
side = "top"
material = "NCE51"

[[patch]]
id = "S2"
role = "sensor"
center = [0.2, 0.035]
size = [0.02, 0.02]
thickness = 0.0005
side = "top"
material = "NCE51"

[[string]]
point = [0.03, 0.187]

[acquisition]
module = "NI-9234"
sample_rate = {RATE!r}
input_resistance = 305000.0
input_capacitance = 1.2e-10

[protocol]
sweep = "linear"
band = [100.0, 1500.0]
sweep_duration = 0.15
tail = 0.03
repeats = 2
ramp_rate = 0.4
temperatures = [10.0, 20.0, 30.0]
directions = ["up", "down"]
levels = [1.0]

[oven]
room_temperature = 22.0
"""


@dataclass
class TdmsContent:
    """One file to be: change anything in it before it is written."""

    properties: dict[str, Any]
    groups: dict[str, dict[str, NDArray[Any]]]
    channel_properties: dict[str, dict[str, dict[str, Any]]] = field(default_factory=dict)

    def write(self, path: Path) -> None:
        with TdmsWriter(path) as writer:
            writer.write_segment([RootObject(self.properties)])
            for group, channels in self.groups.items():
                objects = [GroupObject(group)]
                for channel, samples in channels.items():
                    given = self.channel_properties[group][channel]
                    objects.append(ChannelObject(group, channel, samples, given))
                writer.write_segment(objects)


@dataclass
class TinyCampaign:
    """A whole, faultless campaign: six files of two repeats and two sensors."""

    toml: str
    files: dict[str, TdmsContent]

    def write(self, folder: Path) -> Path:
        (folder / "sweeps").mkdir(parents=True)
        (folder / "campaign.toml").write_text(self.toml, encoding="utf-8")
        for name, file in self.files.items():
            file.write(folder / "sweeps" / name)
        return folder


def _tdms(step: int, direction: str, temperature: float) -> TdmsContent:
    rng = np.random.default_rng(step)
    time = np.arange(SAMPLES) / RATE
    drive = np.where(time < 0.15, chirp(time, 100.0, 0.15, 1500.0, phi=-90.0), 0.0)
    groups: dict[str, dict[str, NDArray[Any]]] = {}
    for repeat in ("repeat 1", "repeat 2"):
        groups[repeat] = {"drive": drive.astype(np.float32)}
        for sensor, pole in (("S1", 0.3), ("S2", 0.6)):
            ring = 2 * 0.98 * np.cos(pole)
            response = 0.01 * lfilter([1.0], [1.0, -ring, 0.98**2], drive) + 1e-4 * rng.standard_normal(SAMPLES)
            groups[repeat][sensor] = response.astype(np.float32)
    waveform = {"wf_increment": 1.0 / RATE, "wf_start_offset": 0.0, "wf_samples": SAMPLES, "unit_string": "V"}
    start, end = (temperature - 0.03, temperature + 0.02)
    return TdmsContent(
        properties={
            "oven_temperature_start": start,
            "oven_temperature_end": end,
            "direction": direction,
            "level": 1.0,
            "step": step,
            "start_time": f"2024-03-11T08:{30 + step}:00",
        },
        groups=groups,
        channel_properties={group: {channel: dict(waveform) for channel in groups[group]} for group in groups},
    )


def tiny_campaign() -> TinyCampaign:
    """Make one."""
    legs = [("up", 10.0), ("up", 20.0), ("up", 30.0), ("down", 30.0), ("down", 20.0), ("down", 10.0)]
    files = {f"{n:03d}.tdms": _tdms(n, direction, temperature) for n, (direction, temperature) in enumerate(legs)}
    return TinyCampaign(TOML, files)


@pytest.fixture(scope="session")
def _template() -> TinyCampaign:
    return tiny_campaign()


@pytest.fixture
def tiny(_template: TinyCampaign) -> TinyCampaign:
    """Hand out a campaign to break; each test has its own."""
    return copy.deepcopy(_template)


@pytest.fixture
def run_flexura(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Call the command line in this process: (exit status, stdout, stderr)."""
    from app.main import main

    def run(*words: object) -> tuple[int, str, str]:
        try:
            main([str(word) for word in words])
            status = 0
        except SystemExit as leaving:
            status = int(leaving.code or 0)
        said = capsys.readouterr()
        return status, said.out, said.err

    return run


@pytest.fixture(scope="session")
def cut_recording() -> Callable[[Path, tuple[int, ...]], None]:
    """Cut the sweeps at a few temperatures out of the shipped recording into a folder."""
    example = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"

    def cut(folder: Path, temperatures: tuple[int, ...]) -> None:
        (folder / "sweeps").mkdir(parents=True)
        for file in sorted((example / "sweeps").iterdir()):
            temperature = re.search(r"_\+(\d\d)\.0C", file.name)
            if temperature and int(temperature[1]) in temperatures:
                shutil.copy(file, folder / "sweeps")
        text = (example / "campaign.toml").read_text(encoding="utf-8")
        listed = ", ".join(f"{t:.1f}" for t in temperatures)
        text = re.sub(r"temperatures = \[[^]]*\]", f"temperatures = [{listed}]", text)
        (folder / "campaign.toml").write_text(text, encoding="utf-8")

    return cut


@pytest.fixture(scope="session")
def change_samples() -> Callable[[Path, Callable[[str, NDArray[Any]], NDArray[Any]]], None]:
    """Rewrite a recorded sweep with the repeats (R, M) of every channel, given by its name, changed."""

    def rewrite(path: Path, change: Callable[[str, NDArray[Any]], NDArray[Any]]) -> None:
        recorded = TdmsFile.read(path)
        groups = recorded.groups()
        names = [channel.name for channel in groups[0].channels()]
        changed = {name: change(name, np.stack([group[name][:] for group in groups])) for name in names}
        content = TdmsContent(
            properties=dict(recorded.properties),
            groups={
                group.name: {name: changed[name][r].astype(np.float32) for name in names}
                for r, group in enumerate(groups)
            },
            channel_properties={
                group.name: {name: dict(group[name].properties) for name in names} for group in groups
            },
        )
        content.write(path)

    return rewrite


@pytest.fixture(autouse=True)
def _rigs_of_this_test(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no test meet the rig of another that runs at the same time."""
    monkeypatch.setattr(occupancy, "lock_folder", lambda: tmp_path)


@dataclass(frozen=True)
class SmallRun:
    """A run of a panel small enough to be reduced in seconds: laws.h5, filters.h5 and compensation.h5."""

    folder: Path
    panel: Path
    module: Any

    def laws_alone(self, folder: Path) -> Path:
        """Make a run folder that holds the same laws and nothing else."""
        made: Path = self.module.write_laws(folder, self.module.laws())
        return made


@pytest.fixture(scope="session")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> SmallRun:
    """Focus and compensate on the panel of `test_focus_compensate`."""
    from click.testing import CliRunner

    from app.main import flexura

    spec = importlib.util.spec_from_file_location(
        "small_panel", Path(__file__).with_name("test_focus_compensate.py")
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    root = tmp_path_factory.mktemp("small")
    (root / "panel.toml").write_text(module.PANEL, encoding="utf-8")
    made = SmallRun(root / "run", root / "panel.toml", module)
    made.laws_alone(made.folder)
    for verb in ("focus", "compensate"):
        words = [verb, str(made.folder), "--panel", str(made.panel), "--quiet"]
        done = CliRunner().invoke(flexura, words)
        assert done.exit_code == 0, done.output
    return made
