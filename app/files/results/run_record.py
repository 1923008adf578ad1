"""``run.json``: the stages of a run, what each was made from and with, what it gave and how long it took."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError

from app.files.atomic import write_json
from app.files.parsed_text import parse_json, read_text
from app.files.provenance import provenance, sha256

SCHEMA = "flexura-run/1"
NAME = "run.json"
LARGEST_RECORD = 20_000_000
"""Bytes: the SHA-256 of every sweep stands in it three times."""
State = Literal["made", "up to date", "failed", "not run", "stopped"]
WHOLE = ("made", "up to date")


@dataclass(frozen=True)
class StageRecord:
    """One stage.

    Attributes
    ----------
    state : str
        ``made``, ``up to date``, ``failed``, ``not run`` (a stage that it needs failed) or ``stopped``.
    said : str
        What was found, or why there is nothing, in one line.
    good : bool
        Whether the result is good enough, as the exit status of the stage's own verb says.
    inputs : mapping of str to str
        SHA-256 of every file that the stage read, by name.
    settings : mapping
    versions : mapping
        Of Flexura, Python and libraries.
    results : mapping of str to str
        SHA-256 of the files made, by name in the run folder.
    notes : tuple of str
    seconds : float
        That it took when it was made.
    seed : int or None
        Where randomness was involved.
    """

    state: State
    said: str = ""
    good: bool = True
    inputs: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, Any] = field(default_factory=dict)
    results: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    seed: int | None = None

    @property
    def whole(self) -> bool:
        """Whether its result stands."""
        return self.state in WHOLE

    def holds(self, folder: Path, inputs: Mapping[str, str], settings: Mapping[str, Any]) -> bool:
        """Whether its results stand in a folder as made, from the same files and options, by this version.

        Parameters
        ----------
        folder : Path
            Of the results.
        inputs, settings : mapping
            Those of now.
        """
        same = (dict(self.inputs), self.settings, self.versions) == (dict(inputs), settings, versions())
        return self.whole and same and bool(self.results) and self.results == hashed(folder, self.results)


@dataclass(frozen=True)
class RunRecord:
    """A run.

    Attributes
    ----------
    campaign : str
        As typed.
    stages : mapping of str to StageRecord
    found : tuple of (str, str)
        Rows of the table at the end: what, and what is said of it.
    """

    campaign: str
    stages: Mapping[str, StageRecord] = field(default_factory=dict)
    found: tuple[tuple[str, str], ...] = ()

    def __repr__(self) -> str:
        """Stages and their states in one line: hashes of a campaign would fill screens."""
        return f"<RunRecord: {', '.join(f'{name} {stage.state}' for name, stage in self.stages.items())}>"

    def with_stage(self, name: str, stage: StageRecord) -> "RunRecord":
        """Return a record with one stage as it is now."""
        return replace(self, stages={**self.stages, name: stage})

    def record(self) -> dict[str, Any]:
        """Return what the file holds."""
        return {"schema": SCHEMA, **asdict(self)}


def versions() -> dict[str, Any]:
    """Return the versions that a result depends on, as in its provenance."""
    made_from = provenance({})
    return {name: made_from[name] for name in ("flexura", "python", "packages")}


def hashed(folder: Path, names: Mapping[str, str] | tuple[str, ...]) -> dict[str, str]:
    """Return the SHA-256 of those of some files in a folder that are there."""
    return {name: sha256(folder / name) for name in names if (folder / name).is_file()}


def read_run_record(run: Path, campaign: str) -> RunRecord:
    """Read the record in a run folder; an empty one where none can be read: all is then made again."""
    try:
        held = parse_json(read_text(run / NAME, LARGEST_RECORD))
        if not isinstance(held, dict) or held.pop("schema", None) != SCHEMA:
            return RunRecord(campaign)
        read = TypeAdapter(RunRecord).validate_python(held)
    except (OSError, ValueError, ValidationError):
        return RunRecord(campaign)
    return replace(read, campaign=campaign)


def write_run_record(run: Path, record: RunRecord) -> None:
    """Write it, whole or not at all."""
    write_json(run / NAME, record.record())
