"""Any campaign on disk: Flexura's own folder, a recorded one, or a declared plate with FRFs of other programs."""

from pathlib import Path
from typing import TYPE_CHECKING

from app.files.bad_file import quoted
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.kind import DECLARATION, PROTOCOL, is_campaign_folder, is_recorded_campaign
from app.files.declarations.plate import FORMAT as OF_PLATE
from app.files.declarations.plate import NAME as PLATE
from app.files.declarations.plate import declares_plate

if TYPE_CHECKING:
    from analysis.recordings.frf_campaign import AnyCampaign


def load_campaign(path: Path) -> "AnyCampaign":
    """Read the campaign in folder `path`, whichever form it has; of a plate with FRFs also its declaration.

    Raises
    ------
    CampaignFileError
        If the folder is no campaign, or for everything that is wrong with the one it is.
    """
    if is_campaign_folder(path):
        from app.files.campaigns.folder import read_campaign_folder

        return read_campaign_folder(path)
    if is_recorded_campaign(path):
        from app.files.campaigns.recorded import read_recorded_campaign

        return read_recorded_campaign(path)
    if declares_plate(path):
        from app.plate_frfs.given_campaign import read_plate

        return read_plate(path)
    raise not_a_campaign(path)


WITH_FRFS = (".uff", ".unv", ".uf", ".bunv", ".mat", ".npz", ".csv", ".gz", ".lvm")
"""Endings of files that mostly hold FRFs or signals of other programs."""
TEXTS = (".txt", ".dat", ".asc", ".tsv")
"""Of those that may."""


def not_a_campaign(path: Path) -> CampaignFileError:
    """Say what a path lacks to be a campaign."""
    allowed = f"a folder with {DECLARATION} (recorded), {PROTOCOL} (imported) or {PLATE} (FRFs)"
    if not path.exists():
        return CampaignFileError(path, [Problem("", "", "does not exist", allowed)])
    if declares_plate(path):
        takes = f"flexura update {quoted(path)} takes it as it is"
        message = f"declares a plate with FRFs or modes of other programs; {takes}"
        return CampaignFileError(path, [Problem("", "", message, "")])
    from app.files.declarations.modal_test import NAME as TEST
    from app.files.declarations.modal_test import declares_test

    if declares_test(path):
        test = path if path.is_file() else path / TEST
        message = (
            f"declares a modal test; flexura identify {quoted(path)} finds its modes; for E, nu and eta say what "
            f"plate it is: flexura new plate {quoted(test)}"
        )
        return CampaignFileError(path, [Problem("", "", message, "")])
    if not path.is_dir():
        return _no_folder(path, allowed)
    listed = sorted(child.name for child in path.iterdir())
    if "frf.h5" in listed:
        message = f"a run folder, no campaign; to start from its FRFs: flexura new plate {quoted(path / 'frf.h5')}"
        return CampaignFileError(path, [Problem("", "", message, "")])
    frfs = [name for name in listed if Path(name).suffix.lower() in WITH_FRFS]
    if frfs:
        onward = f"flexura new plate {quoted(path / frfs[0])}"
        message = f"holds {frfs[0]}, but no {PLATE}; say what plate it is: {onward}"
        return CampaignFileError(path, [Problem("", "", message, "")])
    held = ", ".join(listed[:6]) + (", ..." if len(listed) > 6 else "") if listed else "nothing"
    return CampaignFileError(path, [Problem("", "", f"not a campaign; it holds {held}", allowed)])


def _no_folder(path: Path, allowed: str) -> CampaignFileError:
    """Say what a file is that was named for a campaign, and what takes it."""
    from app.files.campaigns.channels import FORMAT
    from app.files.settings_toml import read_table

    if path.suffix.lower() in (*WITH_FRFS, *TEXTS, ".h5", ".hdf5"):
        message = f"FRFs alone; say what plate they are of: flexura new plate {quoted(path)}"
        if path.suffix.lower() in (".csv", *TEXTS):
            message += f"; of a table of modes: flexura update {quoted(path)} --plate PLATE.toml"
        return CampaignFileError(path, [Problem("", "", message, "")])
    if path.suffix.lower() != ".toml":
        return CampaignFileError(path, [Problem("", "", "a file, not a campaign", allowed)])
    try:
        declared = read_table(path).get("format")
    except CampaignFileError as error:
        return error
    known = {
        "experiment/1": f"an experiment, not yet a campaign; flexura acquire {quoted(path)} makes one of it",
        FORMAT: f"declares a recorded campaign; name its folder: {path.parent}",
    }
    if declared in known:
        return CampaignFileError(path, [Problem("", "", known[str(declared)], "")])
    kinds = f'"flexura-test/1" of a modal test, "{OF_PLATE}" of a plate with FRFs; or name {allowed}'
    return CampaignFileError(path.parent, [Problem(path.name, "format", repr(declared), kinds)])
