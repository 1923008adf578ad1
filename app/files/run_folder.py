"""The run folder: where the results of one campaign gather, one file per stage."""

from pathlib import Path

from app.files.bad_file import ResultFileError

MADE_BY = {
    "frf.h5": "identify or flexura update",
    "modes.h5": "identify",
    "laws.h5": "update",
    "gap.h5": "gap",
    "filters.h5": "focus",
    "compensation.h5": "compensate",
}


def run_folder(campaign: Path, out: Path | None) -> Path:
    """Return the folder for a campaign's results: `out`, or ``NAME-run`` beside the campaign; made if need be.

    Raises ResultFileError where it cannot be made or written.
    """
    campaign = campaign.resolve()
    folder = out or campaign.with_name(campaign.stem + "-run")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".write-test.part"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise ResultFileError(
            f"{folder}: cannot be written ({error.strerror}); name another with --out"
        ) from error
    return folder


def run_file(run: Path, name: str) -> Path:
    """Path of one stage's result in a run; ResultFileError naming the verb that makes it if it is missing."""
    path = run / name
    if not path.is_file():
        raise ResultFileError(f"{run}: holds no {name}; make it with: flexura {MADE_BY[name]}")
    return path
