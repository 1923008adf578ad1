"""Which of its two forms a campaign's folder has: recognised by the names in it, before anything is read."""

from pathlib import Path

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
