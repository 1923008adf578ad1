"""What is asked of a run: the campaign, the folder, the stages and their options."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

from app.files.campaigns.kind import is_recorded_campaign
from app.files.declarations.run_settings import RunOptions, Stage
from app.files.results.run_folder import beside

STAGES: tuple[Stage, ...] = get_args(Stage)
"""In the order of the work."""


def chosen_stages(
    first: Stage | None = None,
    last: Stage | None = None,
    only: Sequence[Stage] = (),
    without: Sequence[Stage] = (),
) -> tuple[Stage, ...]:
    """Return the stages asked for, in the order of the work.

    Parameters
    ----------
    first, last : str, optional
        Begin with this one, end with this one.
    only : sequence of str
        These alone; empty for all.
    without : sequence of str
        Not these.

    Returns
    -------
    tuple of str

    Raises
    ------
    ValueError
        For a name that is no stage, and where nothing is left.
    """
    for names in (only, without):
        if isinstance(names, str):
            raise ValueError(f"{names!r}: a list of stages is wanted, such as [{names!r}]")
    for name in (*((first,) if first else ()), *((last,) if last else ()), *only, *without):
        if name not in STAGES:
            close = difflib.get_close_matches(str(name), STAGES, 1)
            meant = f"did you mean {close[0]}? " if close else ""
            raise ValueError(f"{name!r} is no stage; {meant}allowed: {', '.join(STAGES)}")
    begin = 0 if first is None else STAGES.index(first)
    end = len(STAGES) if last is None else STAGES.index(last) + 1
    found = tuple(one for one in STAGES[begin:end] if (not only or one in only) and one not in without)
    if not found:
        raise ValueError(f"no stage is left to run; allowed: one or more of {', '.join(STAGES)}")
    return found


@dataclass(frozen=True)
class RunRequest:
    """A run.

    Attributes
    ----------
    campaign : Path
        Recorded, imported or acquired, complete or not.
    out : Path or None
        Run folder; None for ``NAME-run`` beside the campaign.
    stages : tuple of str
        Of `STAGES`, in their order.
    options : RunOptions
    force : bool
        Make stages again that are up to date.
    in_place : bool
        Read a recording where it stands, even where it was imported before.
    """

    campaign: Path
    out: Path | None = None
    stages: tuple[Stage, ...] = STAGES
    options: RunOptions = field(default_factory=RunOptions)
    force: bool = False
    in_place: bool = False

    @property
    def run(self) -> Path:
        """The run folder."""
        return self.out or beside(self.campaign)

    @property
    def imported(self) -> Path | None:
        """Folder that a recorded campaign is imported into; None for what is read where it stands."""
        if not is_recorded_campaign(self.campaign) or self.in_place:
            return None
        named = self.options.path(self.options.settings.campaign)
        return named or self.run.resolve().parent / f"{self.campaign.resolve().name}-campaign"
