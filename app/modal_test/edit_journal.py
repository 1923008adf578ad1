"""The journal of changes by hand beside a run: every change, what was taken back, and the files before and after.

``edits/journal.jsonl`` has a line for each change, undo and redo: its date (UTC), what was done, and the number of
the state that the run's files are in since. ``edits/N`` holds the files of state N; 0 is what was identified.
"""

import json
import os
import shutil
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from app.files.atomic import atomic_path, force_folder_to_disk
from app.files.bad_file import ResultFileError
from app.files.parsed_text import parse_json, read_bytes
from app.files.provenance import sha256
from app.terminal.end_signals import held_back

FOLDER, JOURNAL = "edits", "journal.jsonl"
FILES = (
    "transfers.h5",
    "stabilization.h5",
    "modes.csv",
    "modes.uff",
    "frfs.uff",
    "rebuilt.uff",
    "modes.h5",
)
"""Of a run; the last decides which state it is in."""
LARGEST_JOURNAL = 10_000_000
"""Bytes of a journal."""


class EditJournal:
    """The journal of one run; one that is not of the files that are there now counts as none.

    Parameters
    ----------
    run : Path
        Run folder of a test.
    """

    def __init__(self, run: Path) -> None:
        self._run, self._folder = run, run / FOLDER
        self.lines = _lines(self._folder / JOURNAL)
        self.position = int(self.lines[-1]["state"]) if self.lines else 0
        if not self._same(self.position):
            self.lines, self.position = [], 0

    @property
    def undone(self) -> str | None:
        """What an undo would take back; None for nothing."""
        return self._made(self.position) if self.position else None

    @property
    def redone(self) -> str | None:
        """What a redo would make again; None for nothing."""
        return self._made(self.position + 1) if self._there(self.position + 1) else None

    def begin(self) -> None:
        """Keep the files as they are, before a change."""
        if not self.lines:
            forget_edits(self._run)
            self._keep(0)

    def made(self, what: str) -> None:
        """Keep the files as they are after a change; states beyond it, which were taken back, are gone."""
        number = self.position + 1
        while self._there(number):
            shutil.rmtree(self._folder / str(number))
            number += 1
        self._keep(self.position + 1)
        self._note("made", what, self.position + 1)

    def undo(self) -> str:
        """Take the last change back; return which. ResultFileError where there is none."""
        what = self.undone
        if what is None:
            raise ResultFileError(f"{self._run}: no change by hand that could be undone")
        self._restore(self.position - 1)
        self._note("undone", what, self.position - 1)
        return what

    def redo(self) -> str:
        """Make the change again that was taken back last; return which. ResultFileError where there is none."""
        what = self.redone
        if what is None:
            raise ResultFileError(f"{self._run}: no change by hand that could be made again")
        self._restore(self.position + 1)
        self._note("made again", what, self.position + 1)
        return what

    def _made(self, state: int) -> str | None:
        """Change by which a state came about, the last time."""
        return next(
            (str(o["what"]) for o in reversed(self.lines) if o["did"] == "made" and o["state"] == state), None
        )

    def _there(self, state: int) -> bool:
        return bool(self.lines) and (self._folder / str(state) / FILES[-1]).is_file()

    def _same(self, state: int) -> bool:
        """Whether the run's modes are those of a state: it was not identified anew, nor copied over."""
        with suppress(OSError):
            return sha256(self._folder / str(state) / FILES[-1]) == sha256(self._run / FILES[-1])
        return False

    def _keep(self, state: int) -> None:
        folder = self._folder / str(state)
        folder.mkdir(parents=True, exist_ok=True)
        for name in FILES:
            if (self._run / name).is_file():
                _put(self._run / name, folder / name)
        force_folder_to_disk(folder)

    def _restore(self, state: int) -> None:
        with held_back():
            for name in FILES:
                if (self._folder / str(state) / name).is_file():
                    _put(self._folder / str(state) / name, self._run / name)
        force_folder_to_disk(self._run)

    def _note(self, did: str, what: str, state: int) -> None:
        line = {"date": datetime.now(UTC).isoformat(timespec="seconds"), "did": did, "what": what, "state": state}
        self.lines.append(line)
        self.position = state
        text = "".join(json.dumps(one, ensure_ascii=False) + "\n" for one in self.lines)
        with atomic_path(self._folder / JOURNAL) as path:
            path.write_text(text, encoding="utf-8")


def forget_edits(run: Path) -> None:
    """Remove the journal of a run that is made anew."""
    if (run / FOLDER / JOURNAL).exists() or (run / FOLDER / "0").exists():
        shutil.rmtree(run / FOLDER)


def _put(source: Path, target: Path) -> None:
    """Put a file in the place of another, whole or not at all: a second name of it where the disk can do that.

    Results are never written in place, so that the other name keeps its content; tables may be, by people.
    """
    with atomic_path(target) as path:
        path.unlink(missing_ok=True)
        try:
            if source.suffix == ".csv":
                raise OSError("people edit it")
            os.link(source, path)
        except OSError:
            shutil.copyfile(source, path)


def _lines(file: Path) -> list[dict[str, Any]]:
    """Read a journal; none where it is not there or is damaged."""
    try:
        found = [parse_json(line) for line in read_bytes(file, LARGEST_JOURNAL).splitlines()]
        good = all(isinstance(o["state"], int) and o["state"] >= 0 and o["what"] and o["did"] for o in found)
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return found if good else []
