"""A campaign of four sweeps from the simulated rig, and what one undisturbed run makes of it."""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from app.chain.work import STAGES
from app.main import main

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


@dataclass(frozen=True)
class RunOnce:
    """A campaign, a panel and their run folder; each test has copies of its own."""

    campaign: Path
    panel: Path
    run: Path

    @property
    def words(self) -> list[str]:
        """Return what is typed, but for other options."""
        return ["run", str(self.campaign), "--out", str(self.run), "--set", f"focus.panel={self.panel}"]

    def record(self) -> dict[str, Any]:
        """Return what run.json holds."""
        found: dict[str, Any] = json.loads((self.run / "run.json").read_text(encoding="utf-8"))
        return found

    def states(self) -> dict[str, str]:
        """Return the states of the stages in run.json."""
        return {name: stage["state"] for name, stage in self.record()["stages"].items()}


def said_of(message: str) -> dict[str, str]:
    """Return the lines of the stages on the error stream, by stage."""
    pairs = (line.partition(": ") for line in message.splitlines())
    return {stage: said for stage, _, said in pairs if stage in STAGES}


def skipped(message: str) -> set[str]:
    """Return the stages that are said to be up to date."""
    return {stage for stage, said in said_of(message).items() if said.startswith("up to date")}


def typed(*words: object) -> int:
    """Type a command; its exit status."""
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)


@pytest.fixture(scope="session")
def campaign_of_four(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a campaign of four sweeps."""
    folder = tmp_path_factory.mktemp("recorded") / "plate"
    assert typed("acquire", EXAMPLES / "quick-rig.toml", "--out", folder, "--quiet") == 0
    return folder


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory, campaign_of_four: Path) -> RunOnce:
    """Run all but gap once; not to be changed."""
    folder = tmp_path_factory.mktemp("whole")
    shutil.copytree(campaign_of_four, folder / "plate")
    shutil.copy(EXAMPLES / "quick-panel.toml", folder / "panel.toml")
    made = RunOnce(folder / "plate", folder / "panel.toml", folder / "plate-run")
    assert typed(*made.words, "--without", "gap", "--quiet") == 0
    return made


@pytest.fixture
def copied(whole: RunOnce, tmp_path: Path) -> Callable[[], RunOnce]:
    """Copy it, to be changed."""

    def copy() -> RunOnce:
        folder = shutil.copytree(whole.run.parent, tmp_path / "copy")
        return RunOnce(folder / "plate", folder / "panel.toml", folder / "plate-run")

    return copy


@pytest.fixture
def once(copied: Callable[[], RunOnce]) -> RunOnce:
    """Return a copy."""
    return copied()


@pytest.fixture
def fresh(campaign_of_four: Path, tmp_path: Path) -> RunOnce:
    """Return the campaign and the panel without results."""
    shutil.copytree(campaign_of_four, tmp_path / "plate")
    shutil.copy(EXAMPLES / "quick-panel.toml", tmp_path / "panel.toml")
    return RunOnce(tmp_path / "plate", tmp_path / "panel.toml", tmp_path / "plate-run")
