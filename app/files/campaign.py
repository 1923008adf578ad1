"""Any campaign on disk: Flexura's own folder, or a recorded one as it came from the recorder."""

from pathlib import Path
from typing import TYPE_CHECKING

from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaign_kind import DECLARATION, PROTOCOL, is_campaign_folder, is_recorded_campaign

if TYPE_CHECKING:
    from analysis.campaign import Campaign


def load_campaign(path: Path) -> "Campaign":
    """Read the campaign in folder `path`, whichever of the two forms it has.

    Raises
    ------
    CampaignFileError
        If the folder is no campaign, or for everything that is wrong with the one it is.
    """
    if is_campaign_folder(path):
        from app.files.campaign_folder import read_campaign_folder

        return read_campaign_folder(path)
    if is_recorded_campaign(path):
        from app.files.recorded_campaign import read_recorded_campaign

        return read_recorded_campaign(path)
    raise not_a_campaign(path)


def not_a_campaign(path: Path) -> CampaignFileError:
    """Say what a path lacks to be a campaign."""
    allowed = f"a folder with {DECLARATION} (recorded) or {PROTOCOL} (imported)"
    if not path.exists():
        return CampaignFileError(path, [Problem("", "", "does not exist", allowed)])
    from app.files.modal_test_toml import declares_test

    if declares_test(path):
        message = f"declares a modal test, which has no temperatures; flexura identify {path} finds its modes"
        return CampaignFileError(path, [Problem("", "", message, "")])
    if not path.is_dir():
        return _no_folder(path, allowed)
    listed = sorted(child.name for child in path.iterdir())
    held = ", ".join(listed[:6]) + (", ..." if len(listed) > 6 else "") if listed else "nothing"
    return CampaignFileError(path, [Problem("", "", f"not a campaign; it holds {held}", allowed)])


def _no_folder(path: Path, allowed: str) -> CampaignFileError:
    """Say what a file is that was named for a campaign, and what takes it."""
    from app.files.campaign_toml import FORMAT
    from app.files.settings_toml import read_table

    if path.suffix.lower() != ".toml":
        return CampaignFileError(path, [Problem("", "", "a file, not a campaign", allowed)])
    try:
        declared = read_table(path).get("format")
    except CampaignFileError as error:
        return error
    known = {
        "experiment/1": f"an experiment, not yet a campaign; flexura acquire {path} makes one of it",
        FORMAT: f"declares a recorded campaign; name its folder: {path.parent}",
    }
    if declared in known:
        return CampaignFileError(path, [Problem("", "", known[str(declared)], "")])
    kinds = f'"flexura-test/1" of a modal test; or name {allowed}'
    return CampaignFileError(path.parent, [Problem(path.name, "format", repr(declared), kinds)])
