"""What the stages of one run share.

What is asked of a run: the campaign, the folder, the stages and their options.

SHA-256 of all that a stage reads, found without reading the campaign itself.
"""

import difflib
import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from app.files.acquisition.events import NAME as EVENTS
from app.files.campaigns.channels import declaration_digest
from app.files.campaigns.folder import SWEEPS, sweep_paths
from app.files.campaigns.kind import DECLARATION, PROTOCOL, is_campaign_folder, is_recorded_campaign
from app.files.campaigns.loading import load_campaign
from app.files.declarations.run_settings import RunOptions, RunSettings, Stage
from app.files.provenance import sha256
from app.files.results.run_folder import beside

if TYPE_CHECKING:
    from analysis.focusing.panel import Panel
    from analysis.recordings.frf_campaign import AnyCampaign
    from app.chain.models_ahead import ModelsAhead, WantedModel
    from app.report.written import DrawnParts
    from app.stages.update import Updating

STAGES: tuple[Stage, ...] = get_args(Stage)
"""In the order of the work."""


def chosen_stages(
    first: Stage | None = None,
    last: Stage | None = None,
    only: Sequence[Stage] = (),
    without: Sequence[Stage] = (),
) -> tuple[Stage, ...]:
    """Return the stages asked for, in the order of the work.

    Parameters
    ----------
    first, last : str, optional
        Begin with this one, end with this one.
    only : sequence of str
        These alone; empty for all.
    without : sequence of str
        Not these.

    Returns
    -------
    tuple of str

    Raises
    ------
    ValueError
        For a name that is no stage, and where nothing is left.
    """
    for names in (only, without):
        if isinstance(names, str):
            raise ValueError(f"{names!r}: a list of stages is wanted, such as [{names!r}]")
    for name in (*((first,) if first else ()), *((last,) if last else ()), *only, *without):
        if name not in STAGES:
            close = difflib.get_close_matches(str(name), STAGES, 1)
            meant = f"did you mean {close[0]}? " if close else ""
            raise ValueError(f"{name!r} is no stage; {meant}allowed: {', '.join(STAGES)}")
    begin = 0 if first is None else STAGES.index(first)
    end = len(STAGES) if last is None else STAGES.index(last) + 1
    found = tuple(one for one in STAGES[begin:end] if (not only or one in only) and one not in without)
    if not found:
        raise ValueError(f"no stage is left to run; allowed: one or more of {', '.join(STAGES)}")
    return found


@dataclass(frozen=True)
class RunRequest:
    """A run.

    Attributes
    ----------
    campaign : Path
        Recorded, imported or acquired, complete or not.
    out : Path or None
        Run folder; None for ``NAME-run`` beside the campaign.
    stages : tuple of str
        Of `STAGES`, in their order.
    options : RunOptions
    force : bool
        Make stages again that are up to date.
    in_place : bool
        Read a recording where it stands, even where it was imported before.
    """

    campaign: Path
    out: Path | None = None
    stages: tuple[Stage, ...] = STAGES
    options: RunOptions = field(default_factory=RunOptions)
    force: bool = False
    in_place: bool = False

    @property
    def run(self) -> Path:
        """The run folder."""
        return self.out or beside(self.campaign)

    @property
    def imported(self) -> Path | None:
        """Folder that a recorded campaign is imported into; None for what is read where it stands."""
        if not is_recorded_campaign(self.campaign) or self.in_place:
            return None
        named = self.options.path(self.options.settings.campaign)
        return named or self.run.resolve().parent / f"{self.campaign.resolve().name}-campaign"


@dataclass(frozen=True)
class Made:
    """What a stage came to.

    Attributes
    ----------
    said : str
        In one line.
    notes : tuple of str
        Important for the use of the result.
    good : bool
        Whether it is good enough, as the exit status of the stage's verb.
    seed : int or None
        Where randomness was involved.
    """

    said: str
    notes: tuple[str, ...] = ()
    good: bool = True
    seed: int | None = None


@dataclass
class Work:
    """One run at work.

    Attributes
    ----------
    request : RunRequest
    run : Path
        Run folder, there.
    models : ModelsAhead
        Set, as `parts` is, before the first stage is made.
    parts : DrawnParts
        Of the report.
    plain : Updating or None
        The twin without effects, fitted by the update stage for the gap stage, too.
    in_place : bool
        Whether a recording turned out to be read where it stands.
    broken : set of str
        Stages that failed in this run.
    """

    request: RunRequest
    run: Path
    models: "ModelsAhead" = field(init=False)
    parts: "DrawnParts" = field(init=False)
    plain: "Updating | None" = None
    in_place: bool = False
    broken: set[Stage] = field(default_factory=set)

    @property
    def settings(self) -> RunSettings:
        """Options of the stages."""
        return self.request.options.settings

    @property
    def folder(self) -> Path:
        """Campaign that stages read: the one imported, where there is one of this recording."""
        imported = self.request.imported
        if imported is None or self.in_place or not is_import_of(imported, self.recorded):
            return self.request.campaign
        return imported

    @cached_property
    def recorded(self) -> dict[str, str]:
        """SHA-256 of the files of the campaign as it was given."""
        return campaign_hashes(self.request.campaign)

    def place(self, stage: Stage) -> Path:
        """Return the folder that a stage's results are in."""
        return self.request.imported or self.run if stage == "import" else self.run

    @property
    def effects(self) -> Path | None:
        """Folder of a user's own effects."""
        return self.request.options.path(self.settings.effects)

    @property
    def panel(self) -> Path | None:
        """File of the panel; None for the paper's section 2."""
        return self.request.options.path(self.settings.focus.panel)

    @property
    def weather(self) -> Path | None:
        """File of the weather in which filters are judged; None without one."""
        return self.request.options.path(self.settings.compensate.weather)

    @cached_property
    def hashes(self) -> dict[str, str]:
        """SHA-256 of the campaign's files, taken before it is read: what comes later makes results out of date."""
        return campaign_hashes(self.folder)

    @cached_property
    def campaign(self) -> "AnyCampaign":
        """The campaign; CampaignFileError where it cannot be read."""
        from app.files.campaigns.loading import load_campaign

        assert self.hashes  # noqa: S101 (taken first)
        return load_campaign(self.folder)

    def renew(self) -> None:
        """Forget what was read: the campaign has been imported."""
        for name in ("recorded", "hashes", "campaign"):
            self.__dict__.pop(name, None)

    def models_wanted(self) -> "tuple[WantedModel, ...]":
        """Return the reduced models that are not in the cache and that the stages asked for will need."""
        from app.chain.models_ahead import EFFECTS, PANEL, PLATE, WantedModel
        from app.twins.campaign_twin import twin_is_built
        from app.twins.panel_twin import panel_is_reduced

        wanted, found = set(self.request.stages), []
        experiment = self.campaign.experiment
        if {"update", "gap"} & wanted and not twin_is_built(experiment):
            found.append(WantedModel(PLATE, experiment.model_dump_json()))
        panel = self._panel_ahead() if {"focus", "compensate"} & wanted else None
        if panel is not None and not panel_is_reduced(panel):
            found.append(WantedModel(PANEL, panel.model_dump_json()))
        if "gap" in wanted:  # made quickly where it is in the cache
            found.append(WantedModel(EFFECTS, experiment.model_dump_json()))
        return tuple(found)

    def _panel_ahead(self) -> "Panel | None":
        """Return the panel whose model can be built before the plate is updated.

        None where it cannot be read, which the stage says, and where it declares the measured plate: it then gets
        what is found about that.
        """
        from app.files.bad_file import ResultFileError
        from app.stages.panel.inputs import panel_of
        from app.stages.panel.laws import MeasuredPlate

        try:
            panel, _ = panel_of(self.panel, self.settings.focus.changes())
        except ResultFileError:
            return None
        return None if MeasuredPlate(self.campaign.experiment).is_that_of(panel) else panel


TOLD = (b'"missing"', b'"temperature in doubt"')
"""Events that decide what is made of a campaign's sweeps; a running campaign writes others all the time."""


def campaign_hashes(campaign: Path) -> dict[str, str]:
    """SHA-256 of a campaign's files as they are now, by name, sweeps named as in `Campaign.hashes`.

    Parameters
    ----------
    campaign : Path
        Recorded, imported or acquired.

    Returns
    -------
    dict
        Also of meshes and drawings that a declaration names, and of events that put temperatures in doubt.
    """
    if is_campaign_folder(campaign):
        found = {PROTOCOL: sha256(campaign / PROTOCOL)}
        found |= {f"{SWEEPS}/{path.name}": sha256(path) for path in sweep_paths(campaign)}
        return found | _told(campaign / EVENTS)
    declaration = campaign / DECLARATION
    if not declaration.exists():  # a plate with FRFs: only its reader knows which files it names
        return dict(load_campaign(campaign).hashes) | _told(campaign / EVENTS)
    found = {DECLARATION: declaration_digest(declaration)} | _named_in(declaration)
    folder = campaign / SWEEPS
    files = sorted(folder.iterdir()) if folder.is_dir() else []
    return found | {
        f"{SWEEPS}/{path.name}": sha256(path)
        for path in files
        if path.suffix.lower() == ".tdms" and not path.name.startswith(".")
    }


def is_import_of(folder: Path, recorded: Mapping[str, str]) -> bool:
    """Whether a folder is a campaign that was imported from files as they are now, by their SHA-256."""
    try:
        source = json.loads((folder / PROTOCOL).read_text(encoding="utf-8"))["source"]
        return bool(source) and all(recorded.get(name) == digest for name, digest in source.items())
    except (OSError, ValueError, KeyError, TypeError, AttributeError):  # its reader says what is wrong with it
        return False


def file_hashes(path: Path) -> dict[str, str]:
    """SHA-256 of a TOML file and of the meshes and drawings that it names; empty where it is not there."""
    return {path.name: sha256(path)} | _named_in(path) if path.is_file() else {}


def effect_hashes(folder: Path | None) -> dict[str, str]:
    """SHA-256 of a user's own effects, by file."""
    if folder is None or not folder.is_dir():
        return {}
    return {f"effect {path.name}": sha256(path) for path in sorted(folder.glob("[!_]*.py"))}


def _told(events: Path) -> dict[str, str]:
    try:
        lines = [line for line in events.read_bytes().splitlines() if any(kind in line for kind in TOLD)]
    except OSError:
        return {}
    return {EVENTS: hashlib.sha256(b"\n".join(lines)).hexdigest()} if lines else {}


def _named_in(path: Path) -> dict[str, str]:
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):  # the reader says what is wrong
        return {}
    found = {}
    for text in _texts(table):
        with suppress(OSError, ValueError):  # a title may be too long for a name, or hold what no name may
            if (path.parent / text).is_file():
                found[text] = sha256(path.parent / text)
    return found


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str) and value.strip():
        yield value
    elif isinstance(value, dict):
        for one in value.values():
            yield from _texts(one)
    elif isinstance(value, list):
        for one in value:
            yield from _texts(one)
