"""A disk that refuses one write of ``flexura run`` or ``gap --plan``, or all from one on: said in a sentence."""

import errno
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from app.files.hdf5_file import opened_hdf5
from app.files.provenance import sha256
from app.stages import gap
from tests.app.conftest import TinyCampaign

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
Flexura = Callable[..., tuple[int, str, str]]


@dataclass
class Disk:
    """Refuses calls that force bytes to it: number `first` of them, or all from there on where it is full."""

    first: int = 0
    full: bool = False
    calls: int = 0
    refused: bool = field(default=False)

    def fsync(self, _: int) -> None:
        self.calls += 1
        if self.first and (self.calls == self.first or (self.full and self.calls > self.first)):
            self.refused = True
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def arm(self, first: int, *, full: bool) -> None:
        self.first, self.full, self.calls, self.refused = first, full, 0, False


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    """Return a disk in place of this computer's."""
    made = Disk()
    monkeypatch.setattr(os, "fsync", made.fsync)
    return made


def results(folder: Path) -> dict[str, str]:
    """Digest every file but the record, which has seconds in it, and the locks, which are empty."""
    return {
        str(one.relative_to(folder)): sha256(one)
        for one in folder.rglob("*")
        if one.is_file() and one.name != "run.json" and not one.name.endswith(".lock")
    }


@pytest.mark.slow
@pytest.mark.parametrize("full", [False, True])
def test_a_run_says_what_was_not_written_and_goes_on_from_there(
    full: bool, tiny: TinyCampaign, tmp_path: Path, run_flexura: Flexura, disk: Disk
) -> None:
    folder = tiny.write(tmp_path / "tiny")
    words = ("run", folder, "--until", "identify", "--set", "identify.method=peak-picking", "--out")
    assert run_flexura(*words, tmp_path / "whole" / "run")[0] == 0
    whole, calls = results(tmp_path / "whole"), disk.calls
    assert calls > 20
    for number in range(1, calls + 1):
        place = tmp_path / str(number)
        disk.arm(number, full=full)
        status, out, err = run_flexura(*words, place / "run")
        assert disk.refused
        assert status in (1, 2), err
        assert status == 1 or out == ""
        said = [line for line in err.splitlines() if os.strerror(errno.ENOSPC) in line]
        assert len(said) == 1, err
        assert said[0].startswith("Error: " if status == 2 else ("import: FAILED: ", "identify: FAILED: "))
        assert "Traceback" not in err
        there = results(place)
        if said[0].startswith("import: "):  # what follows is then made of the recording, where it stands
            there = {name: digest for name, digest in there.items() if not name.startswith("run/")}
        assert there.items() <= whole.items()
        disk.arm(0, full=False)
        status, _, err = run_flexura(*words, place / "run")
        assert status == 0, err
        assert results(place) == whole
        shutil.rmtree(place)


@pytest.mark.slow
def test_a_plan_that_is_not_written_leaves_the_one_before(
    campaign_of_four: Path, tmp_path: Path, run_flexura: Flexura, disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Computed once: what is refused comes after the computation."""
    run, known = tmp_path / "run", dict[str, Any]()
    monkeypatch.setattr(gap, "compute", _remembered(gap.compute, "compute", known))
    words = ("gap", campaign_of_four, "--plan", "--experiment", EXAMPLES / "quick-rig.toml", "--out", run)
    status, _, err = run_flexura(*words)
    assert status == 0, err
    whole = results(run)
    assert {"next-experiment.toml", "gap.json", "twin.toml", "gap.h5"} <= whole.keys()
    for name in whole.keys() - {"laws.h5"}:  # which is the result of `update`, and stays
        (run / name).write_text("old", encoding="utf-8")
    old, before = results(run), disk.calls
    assert run_flexura(*words)[0] == 0
    calls = disk.calls - before
    assert calls >= 10
    for name in whole.keys() - {"laws.h5"}:
        (run / name).write_text("old", encoding="utf-8")
    for number in range(1, calls + 1):
        for full in (False, True):
            disk.arm(number, full=full)
            status, out, err = run_flexura(*words)
            assert disk.refused
            assert (status, out) == (2, ""), err
            (message,) = [line for line in err.splitlines() if line.startswith("Error: ")]
            assert os.strerror(errno.ENOSPC) in message
            assert "Traceback" not in err
            there = results(run)
            assert there.keys() == whole.keys()
            changed = {name for name in there if there[name] != old[name]}
            assert all(there[name] == whole[name] for name in changed - {"gap.h5", "gap.json"})
            if "gap.h5" in changed:  # with the seconds that it took
                with opened_hdf5(run / "gap.h5") as file:
                    assert len(file)
            if "gap.json" in changed:
                assert json.loads((run / "gap.json").read_text(encoding="utf-8"))["plan"]["next"]
    disk.arm(0, full=False)
    assert run_flexura(*words)[0] == 0


def _remembered(true: Callable[..., Any], name: str, known: dict[str, Any]) -> Callable[..., Any]:
    def asked(*given: Any, **named: Any) -> Any:
        if name not in known:
            known[name] = true(*given, **named)
        return known[name]

    return asked
