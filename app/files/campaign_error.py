"""What is wrong with a campaign on disk: every problem found, each with its file, key, value and cure."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

SHOWN = 40


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

    Attributes
    ----------
    folder : Path
    problems : tuple of Problem
    """

    def __init__(self, folder: Path, problems: Sequence[Problem]) -> None:
        self.folder = folder
        self.problems = tuple(problems)
        lines = [str(problem) for problem in self.problems]
        if len(lines) == 1:
            text = f"{folder}: {lines[0]}"
        else:
            text = f"{folder}: {len(lines)} problems"
            text += "".join(f"\n  {line}" for line in lines[:SHOWN])
            if len(lines) > SHOWN:
                text += f"\n  ... and {len(lines) - SHOWN} more"
        super().__init__(text)
