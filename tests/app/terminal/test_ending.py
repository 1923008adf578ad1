"""What a campaign says that a disk ended: what is wrong with it, what to do, and how the rig was left."""

import errno
import os
from pathlib import Path

import pytest

from app.files.disk_room import UnwrittenFileError
from app.terminal.campaign import broken_off

REST = "stopped; the drive is at 0 V and the oven at rest: "


def refusal(number: int, file: Path | None) -> OSError:
    return OSError(number, os.strerror(number), *([] if file is None else [str(file)]))


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS, errno.EIO])
def test_room_is_asked_for_where_it_is_missing_only(tmp_path: Path, number: int) -> None:
    ending = broken_off(refusal(number, tmp_path / "events.jsonl"), (), tmp_path, 0)
    assert ending.line.startswith(f"{REST}{tmp_path} cannot be written: {os.strerror(number)} ({tmp_path}")
    assert ("Make room" in ending.line) is (number in (errno.ENOSPC, errno.EDQUOT))
    assert "Errno" not in ending.line + ending.record["why"]


@pytest.mark.parametrize("kind", [OSError, UnwrittenFileError])
def test_a_folder_that_has_gone_is_put_back(tmp_path: Path, kind: type[OSError]) -> None:
    folder = tmp_path / "campaign"
    error = kind(errno.ENOENT, os.strerror(errno.ENOENT), str(folder / "events.jsonl"))
    said = f"{folder} has gone; put it back, or name another with --out, then run this again"
    assert broken_off(error, (), folder, 0).line == REST + said
    assert broken_off(error, ("the oven",), folder, 0).line == f"stopped: {said}\nNOT AT REST: the oven"
    assert broken_off(error, None, folder, 0).line == f"stopped: {said}"
    folder.mkdir()
    assert "has gone" not in broken_off(error, (), folder, 0).line


def test_a_name_that_is_too_long_is_told_as_such(tmp_path: Path) -> None:
    folder = tmp_path / ("n" * 300)
    with pytest.raises(OSError, match="too long") as raised:
        folder.mkdir()
    line = broken_off(raised.value, (), folder, 0).line
    assert line == (
        f"{REST}{folder}: the name is too long for this disk; name a shorter one with --out, then run this again"
    )


def test_a_file_that_was_not_written_says_how_the_rig_was_left(tmp_path: Path) -> None:
    error = UnwrittenFileError(errno.ENOSPC, "cannot be written (no room); make room", str(tmp_path / "a.h5"))
    line = broken_off(error, (), tmp_path, 0).line
    assert line == f"{REST}{tmp_path / 'a.h5'}: cannot be written (no room); make room"


def test_what_is_no_answer_of_a_disk_is_not_told_as_one(tmp_path: Path) -> None:
    line = broken_off(refusal(errno.ECONNREFUSED, None), (), tmp_path, 0).line
    assert line == f"{REST}Connection refused; run the same command again to continue"
