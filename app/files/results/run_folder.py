"""The run folder: where the results of one campaign gather, one file per stage."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from app.files.bad_file import ResultFileError, quoted
from app.files.disk_room import RESULTS, require_room

MADE_BY = {
    "frf.h5": "identify or flexura update",
    "transfers.h5": "identify",
    "stabilization.h5": "identify",
    "modes.h5": "identify",
    "laws.h5": "update",
    "laws-corrected.h5": "gap",
    "gap.h5": "gap",
    "filters.h5": "focus",
    "compensation.h5": "compensate",
    "radiation.h5": "radiation",
    "studies.h5": "study all",
}
FIRST = ("frf.h5", "laws.h5")
LATER = ("gap.h5", "filters.h5", "compensation.h5", "radiation.h5", "studies.h5")
"""Results that other commands start from, and those that can be written to another folder."""
OF_RUN = tuple(name for name in LATER if name != "gap.h5")
"""Results that are made from the run folder; those before them are made from the campaign."""


@contextmanager
def run_folder(campaign: Path, out: Path | None, needed: float = RESULTS) -> Iterator[Path]:
    """Yield the folder for a campaign's results: `out`, or ``NAME-run`` beside the campaign; made if need be.

    Where the block raises, folders made here that are empty go.

    Parameters
    ----------
    needed : float
        Bytes that are going to be written, roughly.

    Raises
    ------
    ResultFileError
        Where it cannot be made or written, or its disk has not that much room.
    """
    folder = out or beside(campaign)
    made: list[Path] = []
    with suppress(OSError):  # a name that is too long, or a folder without permission: reported below
        made = [one for one in (folder, *folder.parents) if not one.exists()]
    try:
        writable_folder(folder, "--out")
        require_room(folder, needed, "--out")
        yield folder
    except BaseException:
        with suppress(OSError):  # one holds something, or was never made
            for one in made:
                one.rmdir()
        raise


RESULT_ENDINGS = ".c .csv .flac .h .h5 .html .json .mat .nc .npz .onnx .pdf .png .svg .tdms .uff .unv .wav"
"""How names of results end; a folder called so would hold a file called otherwise."""


def writable_folder(folder: Path, option: str) -> Path:
    """Return a folder, made if need be; ResultFileError, naming the option, where it cannot be made or written."""
    if folder.suffix.lower() in RESULT_ENDINGS.split() and not folder.exists():
        raise ResultFileError(
            f"{folder}: {option} names a folder, and {folder.suffix} ends the name of a file; "
            "the files in it have names of their own"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".write-test.part"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise ResultFileError(
            f"{folder}: cannot be written ({error.strerror}); name another with {option}"
        ) from error
    return folder


def run_file(run: Path, name: str, verb: str) -> Path:
    """Path of one stage's result in a run.

    Parameters
    ----------
    run : Path
        The run folder.
    name : str
        Of the file.
    verb : str
        Of the command that asks, for messages.

    Raises
    ------
    ResultFileError
        Where it is missing: with what to type for `verb` if `run` is a campaign whose own run folder holds it or
        a folder of later results, else with the verb that makes it.
    """
    path = run / name
    if path.is_file():
        return path
    if name == "frf.h5" and (run / "laws.h5").is_file():
        raise ResultFileError(
            f"{run}: holds laws and no FRFs, as of modes alone (flexura update MODES.csv --plate PLATE.toml); "
            f"flexura {verb} needs FRFs"
        )
    own = beside(run)
    if (own / name).is_file():
        typed = run.parent / own.name if run.name not in ("", "..") else own
        raise ResultFileError(
            f"{run}: holds no {name}; the results of this campaign are in {typed}: flexura {verb} {quoted(typed)}"
        )
    later = [other for other in LATER if (run / other).is_file()]
    if later and name in FIRST:
        raise ResultFileError(
            f"{run}: holds {later[0]} but no {name}, like a folder named with --out: name the run folder that "
            f"holds {name}, and this one with --out; or make it with: flexura {MADE_BY[name]}"
        )
    if not run.exists():
        raise ResultFileError(f"{run}: does not exist; make it with: flexura {MADE_BY[name]}")
    made_from = f" {quoted(run)}" if name in OF_RUN else ""
    raise ResultFileError(f"{run}: holds no {name}; make it with: flexura {MADE_BY[name]}{made_from}")


def is_test_run(run: Path) -> bool:
    """Whether a run folder is that of a modal test, not of a campaign."""
    return (run / "transfers.h5").is_file() and not (run / "frf.h5").is_file()


def beside(campaign: Path) -> Path:
    """Return the folder for a campaign's or a test's results where none is named: ``NAME-run`` beside it."""
    campaign = campaign.resolve()
    return campaign.parent / f"{campaign.stem}-run"
