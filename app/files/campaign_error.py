"""What is wrong with a campaign on disk: every problem found, each with its file, key, value and cure."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from app.files.bad_file import Misplaced

LINES_SHOWN = 40


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    Attributes
    ----------
    file : str
        Relative to the campaign's folder; empty for the folder itself.
    key : str
        Key, property or channel; empty where the whole file is meant.
    seen : str
        What is there.
    allowed : str
        What would be right; empty where `seen` is a sentence that says so.
    remedy : str
        What to do next; empty where it follows from `allowed`.
    """

    file: str
    key: str
    seen: str
    allowed: str
    remedy: str = ""

    def __str__(self) -> str:
        place = f"{self.file}: " if self.file else ""
        if not self.allowed:
            return f"{place}{self.key}: {self.seen}" if self.key else f"{place}{self.seen}"
        value = f"{self.key} = {self.seen}" if self.key else self.seen
        return f"{place}{value}; allowed: {self.allowed}" + (f" ({self.remedy})" if self.remedy else "")


class SignalProblem(Problem):
    """Samples that are no measurement, in a file that is whole: the sweep can be left out."""


class CampaignFileError(ValueError):
    """A campaign cannot be read; the message lists everything found wrong with it.

    What is wrong in the same way in several files, or in several repeats, is one line.

    Attributes
    ----------
    folder : Path
    problems : tuple of Problem
    misplaced : Misplaced, optional
        The geometry declared, where that is wrong.
    """

    def __init__(self, folder: Path, problems: Sequence[Problem], misplaced: Misplaced | None = None) -> None:
        self.folder = folder
        self.misplaced = misplaced
        self.problems = tuple(problems)
        lines = _grouped(self.problems)
        place = "" if folder == Path() and all(problem.file for problem in problems) else f"{folder}: "
        if len(lines) == 1:
            text = f"{place}{lines[0]}"
        else:
            kinds = f", {len(lines)} of them different" if len(lines) < len(problems) else ""
            text = f"{place}{len(problems)} problems{kinds}"
            text += "".join(f"\n  {line}" for line in lines[:LINES_SHOWN])
            if len(lines) > LINES_SHOWN:
                text += f"\n  ... and {len(lines) - LINES_SHOWN} more"
        super().__init__(text)


def _grouped(problems: Sequence[Problem]) -> list[str]:
    """Return a line for every different problem; of more than can be shown, one of each key first."""
    groups: dict[tuple[str, ...], list[Problem]] = {}
    for problem in problems:
        same = (_any_repeat(problem.key), problem.seen, problem.allowed, problem.remedy)
        groups.setdefault(same, []).append(problem)
    so_far: Counter[str] = Counter()

    def turn(group: Sequence[Problem]) -> int:
        key = _any_repeat(group[0].key)
        so_far[key] += 1
        return so_far[key]

    different = list(groups.values())
    return [_line(group) for group in (sorted(different, key=turn) if len(different) > LINES_SHOWN else different)]


def _line(alike: Sequence[Problem]) -> str:
    first = alike[0]
    files = len({problem.file for problem in alike}) - 1
    repeats = len({problem.key for problem in alike}) - 1
    more = f" and {files} more file{'s' * (files > 1)}" if files else ""
    also = f" (also in {repeats} more repeat{'s' * (repeats > 1)})" if repeats else ""
    return f"{replace(first, file=first.file + more)}{also}"


def _any_repeat(key: str) -> str:
    return re.sub(r"\brepeat \d+", "repeat", key)
