"""Which file of a folder declares a later date of a panel: recognised by its name, before anything is read."""

from pathlib import Path

from app.files.bad_file import ResultFileError
from app.files.campaign_kind import DECLARATION, PROTOCOL

FRF = "frf.h5"
"""In a run folder; the others are in campaign folders."""
DRIVE, RESPONSE = "drive.wav", "response.wav"
"""Sound that the panel played and what it answered, as `flexura thermometer` takes them."""
KINDS = (FRF, DECLARATION, PROTOCOL, "plate.toml", DRIVE)


def declared_date(folder: Path) -> str:
    """Return the name of that file; ResultFileError for a folder that is no date."""
    found = next((kind for kind in KINDS if (folder / kind).is_file()), None)
    if found is None:
        raise ResultFileError(
            f"{folder}: no date of a panel; allowed: a run folder with frf.h5 (make it with: flexura identify), "
            f"a campaign folder, or a folder with {DRIVE} and {RESPONSE}"
        )
    if found == DRIVE and not (folder / RESPONSE).is_file():
        raise ResultFileError(f"{folder}: holds {DRIVE} and no {RESPONSE}; record what the panel answered, too")
    return found
