"""Which file of a folder declares a later date of a panel: recognised by its name, before anything is read."""

from pathlib import Path

from app.files.bad_file import ResultFileError
from app.files.campaign_kind import DECLARATION, PROTOCOL

FRF = "frf.h5"
"""In a run folder; the others are in campaign folders."""
KINDS = (FRF, DECLARATION, PROTOCOL, "plate.toml")


def declared_date(folder: Path) -> str:
    """Return the name of that file; ResultFileError for a folder that is no date."""
    found = next((kind for kind in KINDS if (folder / kind).is_file()), None)
    if found is None:
        raise ResultFileError(
            f"{folder}: no date of a panel; allowed: a run folder with frf.h5 (make it with: flexura identify), "
            "or a campaign folder"
        )
    return found
