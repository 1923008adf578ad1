"""Campaigns of a tenth of a second, in any process: what is tested with them is who does them, and how often.

Truth and verdict follow from the campaign's random numbers, so that each is what it is wherever it is made.
Workers are killed by themselves, once at each of `KILLS`: while a model is built, in the midst of a campaign's
files, and when its verdict is written and not yet in its place.
"""

import copy
import os
import signal
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any

from app.blind_trial.assignments import Assignment
from app.files.atomic import write_json
from app.files.parsed_text import parse_json, read_text
from tests.app.blind_trial.test_outcome import TRUTH, VERDICT

KILLS = ("model", "0003 made", "0007 judged")
PLACES = ("make_campaign", "judge_campaign", "prepare_twin", "prepare_specimen")


def install(deaths: Path, patch: Any = setattr) -> None:
    """Put them into this process.

    Parameters
    ----------
    deaths : Path
        Folder in which each kill leaves a mark; without it nobody is killed.
    patch : callable
        `setattr`, or a test's own that takes it back.
    """
    import app.blind_trial.trial as trial

    quick = Quick(deaths)
    for name in PLACES:
        patch(trial, name, getattr(quick, name))


class Quick:
    """The stages of a trial."""

    def __init__(self, deaths: Path) -> None:
        self.deaths = deaths

    def die_once(self, where: str) -> None:
        """Kill this process, the first time that one comes here."""
        if where in KILLS and self.deaths.is_dir():
            try:
                (self.deaths / where).touch(exist_ok=False)
            except FileExistsError:
                return
            os.kill(os.getpid(), signal.SIGKILL)

    def prepare_twin(self, kind: Any) -> None:
        """Die, as a model is built."""
        self.die_once("model")

    def prepare_specimen(self, kind: Any) -> None:
        """Nothing is to be made."""

    def make_campaign(
        self, assignment: Assignment, kind: Any, stream: str, seed: int, truth: Path, folder: Path, built: Any
    ) -> None:
        """Write a truth and files that follow from the campaign's random numbers."""
        rng = assignment.rng(stream, seed)
        size = float(rng.uniform(5.0, 90.0))
        told = copy.deepcopy(TRUTH) | {
            "number": assignment.number,
            "kind": "single",
            "untold": {},
            "ablated": None,
        }
        write_json(truth, told | {"size_sigma": {"point_mass": size}})
        folder.mkdir()
        for part in range(4):
            (folder / f"{part}.txt").write_text(f"{size}")
            time.sleep(0.03)
            if part == 1:
                self.die_once(f"{assignment.name} made")

    def judge_campaign(self, folder: Path, run: Path, without: Collection[str]) -> None:
        """Write a verdict that follows from what is in the campaign's files, all of them."""
        sizes = {read_text(one) for one in sorted(folder.iterdir())}
        assert len(sizes) == 1
        assert len(list(folder.iterdir())) == 4
        closure = parse_json(sizes.pop()) / 100.0
        gap = {"held_out": {"closure": closure}, "held_out_also": []}
        effects = [VERDICT["effects"][0] | {"equivalent": []}]
        write_json(run / "gap.json", copy.deepcopy(VERDICT) | {"gap": gap, "effects": effects})
        self.die_once(f"{folder.name} judged")
