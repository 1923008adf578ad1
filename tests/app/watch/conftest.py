"""A finished campaign of a simulated rig, and others made of parts of its log."""

import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from app.files.acquisition.campaign_folder import campaign_log
from app.files.campaigns.folder import Source
from app.files.declarations.experiment import read_acquired_experiment
from app.stages.acquire import acquire_campaign
from drivers.ni.modules import NI_9211, NI_9234, NI_9260
from drivers.rig.campaign import unobserved
from drivers.rig.session import Session
from drivers.rig.simulated import simulated_parts
from tests.app.test_kill_acquire import plate

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "simulated-rig.toml"


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six sweeps, made in a second."""
    example = read_acquired_experiment(EXAMPLE)
    programme = example.programme.model_copy(
        update={"lowest": 24.0, "highest": 34.0, "every": 2.0, "ramp_rate": 2.0, "lead": 2.0, "soak_before": 60.0}
    )
    sweep = example.sweep.model_copy(update={"duration": 0.5, "taper": 0.05, "tail": 0.2})
    experiment = example.model_copy(update={"programme": programme, "sweep": sweep})
    folder = tmp_path_factory.mktemp("watched") / "campaign"
    parts = simulated_parts(
        experiment.cards, experiment.oven, plate, modules={1: NI_9234, 2: NI_9260, 3: NI_9211}, seed=3
    )
    session = Session(parts.rig(), experiment.limits, campaign_log(folder))
    acquired = {**experiment.model_dump(mode="json"), "rig": "simulated"}
    acquire_campaign(session, experiment, folder, Source("mine.toml", "0" * 64), acquired, unobserved)
    return folder


Campaign = Callable[..., Path]


@pytest.fixture
def campaign(finished: Path, tmp_path: Path) -> Campaign:
    """Return a function that makes a campaign with the first events of the finished one, and others after them."""

    def make(
        name: str, events: int | None = 6, *, readings: int | None = 20, more: Sequence[dict[str, Any]] = ()
    ) -> Path:
        folder = tmp_path / name
        shutil.copytree(finished, folder)
        for file, count in (("events.jsonl", events), ("readings.csv", readings)):
            lines = (finished / file).read_text(encoding="utf-8").splitlines(keepends=True)[:count]
            (folder / file).write_text("".join(lines), encoding="utf-8")
        if events is not None:
            done = sum('"finished"' in line for line in (folder / "events.jsonl").read_text().splitlines())
            for path in sorted((folder / "sweeps").iterdir())[done:]:
                path.unlink()
        for event in more:
            add(folder, event)
        return folder

    return make


def add(folder: Path, event: dict[str, Any]) -> None:
    """Append an event to a log, dated as the one before it unless it has a date."""
    lines = (folder / "events.jsonl").read_text(encoding="utf-8").splitlines()
    dated = {"time": 0.0, "date": json.loads(lines[-1])["date"]} | event
    (folder / "events.jsonl").write_text("\n".join([*lines, json.dumps(dated)]) + "\n", encoding="utf-8")


def age(folder: Path, seconds: float) -> None:
    """Make everything in a folder look older."""
    for path in folder.rglob("*"):
        found = path.stat()
        os.utime(path, (found.st_atime - seconds, found.st_mtime - seconds))
