"""Who writes a folder, and whether it is still there."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.files.folder_lock import folder_lock, is_abandoned, is_being_written

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nobody says who is gone")

HOLD = "import sys; from pathlib import Path; from app.files.folder_lock import folder_lock\n" + (
    "with folder_lock(Path(sys.argv[1])): print('held', flush=True); sys.stdin.read()"
)


@pytest.fixture
def holder(tmp_path: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Start another process that holds the lock of ``tmp_path/campaign``."""
    command = [sys.executable, "-c", HOLD, str(tmp_path / "campaign")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == b"held\n"
        yield child
        child.kill()


def test_a_killed_writer_is_known_at_once(tmp_path: Path, holder: "subprocess.Popen[bytes]") -> None:
    folder = tmp_path / "campaign"
    assert (is_being_written(folder), is_abandoned(folder)) == (True, False)
    os.kill(holder.pid, signal.SIGKILL)
    os.waitid(os.P_PID, holder.pid, os.WEXITED | os.WNOWAIT)  # nobody has asked for its end yet: it has a number
    assert is_abandoned(folder)
    holder.wait(10.0)
    assert (is_being_written(folder), is_abandoned(folder)) == (False, True)


def test_who_takes_the_folder_again_is_there_and_leaves_nothing(
    tmp_path: Path, holder: "subprocess.Popen[bytes]"
) -> None:
    holder.kill()
    holder.wait(10.0)
    with folder_lock(tmp_path / "campaign"):
        assert not is_abandoned(tmp_path / "campaign")
    assert list(tmp_path.iterdir()) == []
    assert not is_abandoned(tmp_path / "campaign")


@pytest.mark.parametrize(
    ("change", "abandoned"),
    [
        ({"begun": 1}, True),  # its number was given to a later process: this one
        ({"system": "another computer"}, False),
        ({"system": ""}, False),
        ({"process": None}, False),
    ],
)
def test_a_number_used_again_is_not_the_writer(tmp_path: Path, change: dict[str, object], abandoned: bool) -> None:
    lock = tmp_path / "campaign.lock"
    with folder_lock(tmp_path / "campaign"):
        owner = json.loads(lock.read_text())
    lock.write_text(json.dumps(owner | change))
    assert is_abandoned(tmp_path / "campaign") is abandoned


@pytest.mark.parametrize("found", [b"", b"\x00\xff", b"[]", b"{" * 100_000])
def test_a_lock_of_another_origin_says_nothing(tmp_path: Path, found: bytes) -> None:
    (tmp_path / "campaign.lock").write_bytes(found)
    assert not is_abandoned(tmp_path / "campaign")
