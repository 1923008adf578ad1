"""Hits of a hammer test whose temperature is in doubt: noted in their files, and later in the log."""

from collections.abc import Sequence
from pathlib import Path

from app.files.acquisition.events import later_doubts, read_events
from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import is_hammer_folder
from app.files.hdf5_file import Hdf5FileError, opened_hdf5

HITS = "hits"
"""Folder of the accepted ones."""
DOUBT = "doubt"
"""Attribute of a hit, only where the rig doubted the plate's temperature."""


def hit_doubts(folder: Path, files: Sequence[str]) -> dict[str, str]:
    """Return why the temperatures of some hits are in doubt, by the hit as people know it.

    Parameters
    ----------
    folder : Path
        That holds the declaration; nothing is in doubt where it is none of a hammer test that was acquired.
    files : sequence of str
        Of the hits that count, relative to it.

    Raises
    ------
    CampaignFileError
        For a damaged log.
    ResultFileError
        For a hit that cannot be read.
    """
    if not is_hammer_folder(folder):
        return {}
    later, found = later_doubts(read_events(folder)), dict[str, str]()
    for name in files:
        if Path(name).parent != Path(HITS):
            continue
        try:
            with opened_hdf5(folder / name) as file:
                number, point = (int(file.attrs[key]) for key in ("number", "point"))
                doubt = later.get(number, str(file.attrs.get(DOUBT, "")))
                if doubt:
                    found[f"hit {number} (point {point + 1}, {float(file.attrs['temperature']):.1f} °C)"] = doubt
        except Hdf5FileError as error:
            raise ResultFileError(f"{folder / name}: {error}") from error
    return found
