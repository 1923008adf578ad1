"""Which campaign and which results a folder stands for."""

from dataclasses import dataclass
from pathlib import Path

from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import is_campaign_folder, is_hammer_folder, is_recorded_campaign
from app.files.declarations.plate import declares_plate
from app.files.results.run_folder import MADE_BY, is_test_run


@dataclass(frozen=True)
class Viewed:
    """What there is to look at.

    Attributes
    ----------
    campaign : Path or None
        A campaign folder, Flexura's own or a recorded one, a hammer test, or a declared plate with FRFs.
    run : Path or None
        Where its results gather.
    """

    campaign: Path | None
    run: Path | None

    @property
    def name(self) -> str:
        """For the window's title."""
        folder = self.campaign or self.run
        return "" if folder is None else folder.name


def viewed(folder: Path) -> Viewed:
    """Take a campaign with the results beside it, or a run folder, of a campaign or a test, alone.

    Raises
    ------
    ResultFileError
        If the folder is neither.
    """
    folder = folder.resolve()
    if (
        is_hammer_folder(folder)
        or is_campaign_folder(folder)
        or is_recorded_campaign(folder)
        or declares_plate(folder)
    ):
        beside = folder.with_name(folder.stem + "-run")
        return Viewed(folder, next((run for run in (beside, folder) if holds_results(run)), None))
    if is_test_run(folder) or holds_results(folder):
        return Viewed(None, folder)
    held = "does not exist" if not folder.exists() else "holds neither a campaign nor results"
    raise ResultFileError(f"{folder}: {held}; name a campaign, or the run folder of flexura identify or update")


def holds_results(folder: Path) -> bool:
    """Whether a folder holds the result of any stage."""
    return any((folder / name).is_file() for name in MADE_BY)
