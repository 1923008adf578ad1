"""Options of ``flexura run``: the table [run] of a campaign's declaration, or of a TOML file of its own."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Declared, Temperature
from analysis.recordings.grid_frequency import MAINS_RANGE
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.channels import RUN, run_table
from app.files.campaigns.kind import DECLARATION
from app.files.settings_toml import checked

Stage = Literal["import", "identify", "update", "gap", "focus", "compensate", "report"]
FocusMethod = Literal["stif", "time-reversal", "modal-control", "none"]
Hertz = Annotated[float, Field(ge=0.0, le=100_000.0)]
Difference = Annotated[float, Field(ge=0.1, le=60.0)]
COMMAND_LINE = Path("--set")
"""What messages call the file of options that were typed."""


class IdentifyOptions(Declared):
    """``[run.identify]``."""

    damping: Literal["hysteretic", "viscous"] = "hysteretic"
    method: Literal["auto", "peak-picking"] = "auto"
    band: Annotated[tuple[Hertz, Hertz] | None, Field(description="Hz, ascending")] = None
    actuator: Annotated[str | None, Field(description="id of what drove, of several in turn")] = None

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if self.band is not None and not self.band[0] < self.band[1]:
            raise ValueError(f"band {list(self.band)} Hz: the first must be below the second")
        return self


class FocusOptions(Declared):
    """``[run.focus]``: the panel, and settings of the filters that replace the panel's own."""

    panel: Annotated[str | None, Field(description="a panel's file")] = None
    temperatures: Annotated[tuple[Temperature, ...], Field(description="degrees Celsius")] = ()
    method: FocusMethod = "stif"
    regularisation: Literal["tikhonov", "truncation"] | None = None
    tolerance: Annotated[float | None, Field(ge=1e-6, le=0.9)] = None
    aim: Literal["field", "volume", "listeners"] | None = None
    zone: Annotated[str | None, Field(max_length=40, description="of listeners")] = None
    design: Literal["field", "inverse-fft"] | None = None
    taps: Annotated[int | None, Field(ge=16, le=16_384)] = None
    sample_rate: Annotated[float | None, Field(ge=1_000.0, le=400_000.0, description="Hz")] = None
    delay: Annotated[int | None, Field(ge=0, description="samples")] = None
    outside_weight: Annotated[float | None, Field(ge=1.0, le=1e4)] = None
    thermometer_error: Annotated[float | None, Field(ge=0.0, le=30.0, description="degrees Celsius")] = None
    level: Annotated[float | None, Field(ge=-80.0, le=20.0, description="dB")] = None

    def changes(self) -> dict[str, Any]:
        """Return the settings of the filters."""
        return self.model_dump(exclude={"panel", "temperatures", "method"})


class CompensateOptions(Declared):
    """``[run.compensate]``: training temperatures and networks."""

    spacing: Annotated[float, Field(ge=0.5, le=30.0, description="K")] = 5.0
    place: Annotated[int | None, Field(ge=4, le=40)] = None
    across: tuple[Difference, ...] = ()
    weather: Annotated[str | None, Field(description="a weather's file, in which filters are judged")] = None
    device: str = "cpu"
    nodes: Annotated[int | None, Field(ge=1, le=100)] = None
    restarts: Annotated[int, Field(ge=1, le=100)] = 1
    feed: Literal["rigidity", "temperature"] = "rigidity"
    scale: Literal["global", "tap"] = "global"
    start: Literal["warm", "random"] = "warm"
    split: Literal["none", "matlab"] = "none"
    seed: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _one_choice(self) -> Self:
        if self.place is not None and "spacing" in self.model_fields_set:
            raise ValueError("place and spacing each choose the training temperatures: name one of them")
        return self

    def training(self) -> dict[str, Any]:
        """Return the settings of the networks, without nodes that were not chosen."""
        chosen = self.model_dump(include={"nodes", "restarts", "feed", "scale", "start", "split", "seed"})
        return {name: value for name, value in chosen.items() if value is not None}


class ReportOptions(Declared):
    """``[run.report]``."""

    pictures: bool = False


class RunSettings(Declared):
    """``[run]``."""

    mains: Annotated[float, Field(ge=MAINS_RANGE[0], le=MAINS_RANGE[1], description="Hz")] = 50.0
    without: Annotated[tuple[Stage, ...], Field(description="stages left out")] = ()
    campaign: Annotated[str | None, Field(description="folder that a recording is imported into")] = None
    effects: Annotated[str | None, Field(description="a folder of *.py, an effect each")] = None
    identify: IdentifyOptions = IdentifyOptions()
    focus: FocusOptions = FocusOptions()
    compensate: CompensateOptions = CompensateOptions()
    report: ReportOptions = ReportOptions()


class RunFile(Declared):
    """A file with that table, whatever else it holds."""

    run: RunSettings


@dataclass(frozen=True)
class RunOptions:
    """Options of a run, and the folder that their paths are relative to.

    Attributes
    ----------
    settings : RunSettings
    folder : Path
        Of the file they were read from; the current one where there was none.
    """

    settings: RunSettings = field(default_factory=RunSettings)
    folder: Path = field(default_factory=Path)

    def path(self, named: str | None) -> Path | None:
        """Return a path that the options name."""
        return None if named is None else self.folder / named


def read_run_options(campaign: Path, file: Path | None, typed: Sequence[str]) -> RunOptions:
    """Read the options of a run.

    Parameters
    ----------
    campaign : Path
        Whose declaration holds them, unless a file is named.
    file : Path or None
        A TOML file with a table [run].
    typed : sequence of str
        ``KEY=VALUE`` each, with keys as in the table, ``focus.taps=128``; they replace what was read. Paths in
        them are relative to the current folder.

    Raises
    ------
    CampaignFileError
        For a file without such a table, and with every key or value that is not allowed.
    """
    source = file if file is not None else campaign / DECLARATION
    table: Mapping[str, Any] | None = None
    if file is not None or source.is_file():
        table = run_table(source)
    if table is None and file is not None:
        problem = Problem(file.name, RUN, "nothing", "a table [run] of options", "the key is missing")
        raise CampaignFileError(file.parent, [problem])
    read = RunOptions() if table is None else RunOptions(_checked(source, table), source.parent)
    if not typed:
        return read
    given: dict[str, Any] = {}
    for one in typed:
        _put(given, one)
    _checked(COMMAND_LINE, given)  # alone, so that a message names the right place
    _absolute(given)
    whole = _merged({} if table is None else dict(table), given)
    return RunOptions(_checked(COMMAND_LINE, whole), read.folder)


def run_options_of(table: Mapping[str, Any]) -> RunOptions:
    """Return options given as a table [run]; CampaignFileError with every key or value that is not allowed."""
    return RunOptions(_checked(Path("options"), table))


def _checked(path: Path, table: Mapping[str, Any]) -> RunSettings:
    return checked(path, {RUN: table}, RunFile).run


def _put(given: dict[str, Any], typed: str) -> None:
    """Put one typed option into a table; CampaignFileError where it is none."""
    key, equals, text = typed.partition("=")
    if not equals or not key.strip():
        problem = Problem(str(COMMAND_LINE), "", repr(typed), "KEY=VALUE, for example focus.taps=128")
        raise CampaignFileError(Path(), [problem])
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, KeyError):  # a word without quotes
        value = text
    *tables, last = key.strip().split(".")
    place = given
    for name in tables:
        place = place.setdefault(name, {})
        if not isinstance(place, dict):
            problem = Problem(str(COMMAND_LINE), key, "below a value", "one key for one value")
            raise CampaignFileError(Path(), [problem])
    place[last] = value


def _absolute(given: dict[str, Any]) -> None:
    """Make typed paths independent of the folder of the file that is read."""
    of_focus, of_compensate = given.get("focus", {}), given.get("compensate", {})
    for table, key in ((given, "campaign"), (given, "effects"), (of_focus, "panel"), (of_compensate, "weather")):
        if key in table:
            table[key] = str(Path(table[key]).absolute())


def _merged(below: dict[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return two tables as one; of a key in both, the value of `above`."""
    found = dict(below)
    for key, value in above.items():
        old = found.get(key)
        found[key] = _merged(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return found
