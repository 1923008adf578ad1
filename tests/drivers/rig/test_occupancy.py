"""One process at a time has a rig, and is named to the next; a killed one has it no more."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import pytest

from drivers.ni.wiring import Wiring
from drivers.rig import occupancy
from drivers.rig.occupancy import RigInUse, in_use, occupied

ROOT = Path(__file__).resolve().parents[3]
HOLD = """
import sys
from pathlib import Path
from drivers.rig import occupancy
occupancy.lock_folder = lambda: Path(sys.argv[1])
with occupancy.occupied(sys.argv[2:], "flexura acquire, campaign elsewhere"):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(occupancy, "lock_folder", lambda: tmp_path)
    return tmp_path


@contextmanager
def another_process(folder: Path, *places: str) -> Iterator["subprocess.Popen[bytes]"]:
    command = [sys.executable, "-c", HOLD, str(folder), *places]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        assert child.stdout.readline().strip() == b"held"
        try:
            yield child
        finally:
            child.kill()


@pytest.mark.parametrize(
    "wanted", [("oven at COM3",), ("cards cDAQ1", "oven at COM3"), ("oven at COM3", "cards cDAQ2")]
)
def test_another_process_is_named(folder: Path, wanted: tuple[str, ...]) -> None:
    with another_process(folder, "oven at COM3", "cards cDAQ1") as child:
        with (
            pytest.raises(RigInUse, match="campaign elsewhere, since 2") as caught,
            occupied(wanted, "flexura safe"),
        ):
            raise AssertionError("must not be reached")
        assert f"in use by process {child.pid} (flexura acquire" in str(caught.value)
        assert "flexura safe" in caught.value.next_step
        assert str(child.pid) in (in_use(wanted) or "")
        assert in_use(["oven at COM4"]) is None


def test_a_killed_process_has_it_no_more(folder: Path) -> None:
    with another_process(folder, "oven at COM3") as child:
        child.kill()
        child.wait(60.0)
        with occupied(["oven at COM3"], "flexura safe"):
            assert "flexura safe" in next(folder.glob("*.lock")).read_text()
    assert in_use(["oven at COM3"]) is None


def test_what_was_taken_is_given_back_where_the_rest_is_another_s(folder: Path) -> None:
    with another_process(folder, "cards cDAQ1"):
        with pytest.raises(RigInUse), occupied(["oven at COM3", "cards cDAQ1"], "flexura acquire"):
            pass
        assert in_use(["oven at COM3"]) is None


def test_the_same_process_cannot_have_it_twice() -> None:
    mine = occupied(["oven at COM3"], "one thread")
    with mine, pytest.raises(RigInUse, match=f"process {os.getpid()} "), occupied(["oven at COM3"], "another"):
        pass


@pytest.mark.skipif(sys.platform != "linux", reason="needs the names of Linux's abstract sockets")
def test_a_lock_file_that_was_removed_still_locks(folder: Path) -> None:
    with another_process(folder, "oven at COM3"):
        for file in folder.glob("*.lock"):
            file.unlink()
        for _ in range(2):  # the first one must not leave a lock of its own
            assert in_use(["oven at COM3"]) == "the oven at COM3 is in use by another process"
    assert in_use(["oven at COM3"]) is None


def test_without_such_names_the_file_locks(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(occupancy, "take_name", lambda name: None)
    with another_process(folder, "oven at COM3") as child:
        assert f"process {child.pid} " in (in_use(["oven at COM3"]) or "")


def test_a_file_removed_before_it_is_locked_is_opened_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(occupancy, "take_name", lambda name: None)
    opened = occupancy._open
    calls: list[Path] = []

    def open_and_lose(path: Path) -> BinaryIO:
        file = opened(path)
        calls.append(path)
        if len(calls) == 1:
            path.unlink()
        return file

    monkeypatch.setattr(occupancy, "_open", open_and_lose)
    with occupied(["oven at COM3"], "one"):
        assert in_use(["oven at COM3"]) is not None


def test_another_temporary_folder_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    seen = set()
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        for variable in ("TMPDIR", "TEMP", "TMP"):
            monkeypatch.setenv(variable, str(tmp_path / name))
        monkeypatch.setattr(tempfile, "tempdir", None)
        seen.add(occupancy.lock_folder())
    assert len(seen) == 1
    assert not seen.pop().is_relative_to(tmp_path)


def test_a_device_in_use_is_known_in_every_spelling(folder: Path) -> None:
    held = ("oven at socket://localhost:502", "oven at COM3", "cards cDAQ1 at localhost:31763")
    with another_process(folder, *held):
        for other in (
            "oven at socket://127.0.0.1:502",
            "oven at socket://[::1]:502",
            "oven at socket://[::ffff:127.0.0.1]:0502",
            r"oven at \\.\COM3",
            "cards cdaq1 at 127.0.0.1:31763",
        ):
            assert "campaign elsewhere" in (in_use([other]) or ""), other
        assert in_use(["oven at socket://127.0.0.1:503", "oven at COM4"]) is None


def test_a_rig_whose_places_are_one_device_can_be_used() -> None:
    with occupied(["oven at socket://localhost:502", "oven at socket://127.0.0.1:502"], "flexura acquire"):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="Windows' locks are not inherited")
def test_a_child_that_inherits_the_locks_holds_the_rig(folder: Path) -> None:
    with occupied(["oven at COM3", "cards cDAQ1"], "flexura acquire, campaign mine") as held:
        command = [sys.executable, "-c", "import sys; sys.stdin.read()"]
        child = subprocess.Popen(command, stdin=subprocess.PIPE, pass_fds=held.filenos())
    with child:
        for place in ("oven at COM3", "cards cDAQ1"):
            assert "campaign mine" in (in_use([place]) or "")
        child.kill()
    assert in_use(["oven at COM3", "cards cDAQ1"]) is None


def test_a_child_that_does_not_inherit_them_does_not(folder: Path) -> None:
    with occupied(["oven at COM3"], "flexura acquire"):
        child = subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE)
    with child:
        assert in_use(["oven at COM3"]) is None
        child.kill()


def test_a_file_with_nonsense_is_another_process(folder: Path) -> None:
    with another_process(folder, "oven at COM3"):
        next(folder.glob("*.lock")).write_bytes(b"[" * 9000)
        assert in_use(["oven at COM3"]) == "the oven at COM3 is in use by another process"


def test_where_nothing_can_be_locked_the_rig_can_still_be_used(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(occupancy, "lock_folder", lambda: Path("/nowhere/at/all"))
    monkeypatch.setattr(occupancy, "take_name", lambda name: None)
    with occupied(["oven at COM3"], "flexura safe"):
        assert "oven at COM3 cannot be locked" in caplog.text


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="needs links that are not followed")
def test_a_link_is_not_followed(folder: Path) -> None:
    with occupied(["oven at COM3"], "flexura safe"):
        name = next(folder.glob("*.lock"))
    name.unlink()
    precious = folder / "precious"
    precious.write_text("precious")
    name.symlink_to(precious)
    with occupied(["oven at COM3"], "flexura safe"):
        pass
    assert precious.read_text() == "precious"


def test_cards_are_their_chassis() -> None:
    wiring = Wiring(
        output="cDAQ1Mod2/ao0",
        drive_input="cDAQ1Mod1/ai0",
        responses=("cDAQ1Mod1/ai1", "Dev3/ai0"),
        sample_rate=8500.0,
    )
    assert wiring.places == ("Dev3", "cDAQ1")
    assert wiring.model_copy(update={"grpc": "LAB:31763"}).places == ("Dev3 at lab:31763", "cDAQ1 at lab:31763")
