"""Which campaign, or later date of a panel, a folder holds: recognised by names, before anything is read."""

from pathlib import Path

from app.files.bad_file import ResultFileError

PROTOCOL = "protocol.json"
"""In a folder of Flexura's own form."""
DECLARATION = "campaign.toml"
"""In a recorded one."""
HAMMER_TEST = "hammer.json"
"""In a folder of hits that were recorded."""
EXPORTS = (".uff", ".unv", ".mat", ".csv", ".nc")
"""Endings of files that FRFs of any of them are written to."""


def is_campaign_folder(folder: Path) -> bool:
    """Whether a folder claims to be a campaign of Flexura's own form."""
    return (folder / PROTOCOL).is_file()


def is_recorded_campaign(folder: Path) -> bool:
    """Whether a folder claims to be a recorded campaign."""
    return (folder / DECLARATION).is_file()


def is_hammer_folder(folder: Path) -> bool:
    """Whether a folder claims to be a hammer test that was acquired."""
    return (folder / HAMMER_TEST).is_file()


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
