"""All stages of every campaign that is meant, by one executor; what several need is made once, before.

Every task returns its result as a value: a campaign that cannot be read, or whose stages fail, is told in the
fleet's report and stops no other. A campaign whose results are up to date costs a look at its files, so that the
same command goes on after an interruption.
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from analysis.progress import Progress
from app.chain.models_ahead import BUILD, PANEL, WantedModel, silent
from app.chain.run_chain import RunListener, run_chain
from app.chain.work import RunRequest, Work
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.kind import is_campaign_folder, is_recorded_campaign
from app.files.declarations.plate import declares_plate
from app.files.disk_room import told
from app.files.parsed_text import read_text
from app.files.results.run_record import StageRecord

LISTS = (".txt", ".list")
LARGEST_LIST_FILE = 10_000_000
"""Bytes of a list: `MOST_CAMPAIGNS` paths of a thousand characters."""
MOST_CAMPAIGNS = 9999
"""Campaigns of a fleet: the page shows each."""


@dataclass(frozen=True)
class FleetMember:
    """One piece: the name of its campaign's folder, and the campaign."""

    name: str
    campaign: Path


MODEL_MEMORY = 1.6e9
"""Bytes that a campaign takes at most, while the model of a panel is built."""
DECIDES = ("plate", "patch", "drive", "sensor", "string", "cable")
"""Of an experiment, beside the band, what a model of its plate is made from."""


@dataclass(frozen=True)
class RunMember:
    """What a run of one campaign came to.

    Attributes
    ----------
    name : str
    campaign, run : Path
    stages : mapping of str to StageRecord
        Those asked for.
    failure : str
        Why there are none, in one sentence.
    """

    name: str
    campaign: Path
    run: Path
    stages: Mapping[str, StageRecord] = field(default_factory=dict)
    failure: str = ""

    @property
    def good(self) -> bool:
        """Whether all stages have a result that is good enough."""
        return not self.failure and all(one.whole and one.good for one in self.stages.values())

    @property
    def said(self) -> str:
        """The state of it in one line."""
        if self.failure:
            return self.failure
        amiss = [f"{name} {one.state}: {one.said}" for name, one in self.stages.items() if not one.whole]
        poor = [name for name, one in self.stages.items() if one.whole and not one.good]
        amiss += [f"not good enough: {', '.join(poor)}"] if poor else []
        made = sum(one.state == "made" for one in self.stages.values())
        return "; ".join(amiss) or (f"{made} stage{'s' * (made > 1)} made" if made else "up to date")


def run_fleet(
    members: Sequence[FleetMember],
    requests: Mapping[str, RunRequest],
    executor: Executor,
    report: Progress,
    announce: Callable[[RunMember], None],
) -> tuple[RunMember, ...]:
    """Run the stages of every campaign.

    Parameters
    ----------
    members : sequence of FleetMember
    requests : mapping of str to RunRequest
        By name.
    executor : Executor
        Takes the tasks: what models are missing, models, campaigns.
    report : callable
        Called with the stage and the share done.
    announce : callable
        Called with every campaign when it is done.
    """
    report("models", 0.0)
    wanted: dict[str, WantedModel] = {}
    for one in as_completed([executor.submit(models_of, requests[member.name]) for member in members]):
        wanted |= one.result()
    # those with effects rest on the plate's: in two rounds, for a worker that waits for another does nothing
    for place, kinds in enumerate(((0, 2), (1,))):
        kept = [one for one in wanted.values() if list(BUILD).index(one.kind) in kinds]
        for done in as_completed([executor.submit(BUILD[one.kind], one.declared) for one in kept]):
            done.result()
        report("models", 0.5 * (place + 1))
    tasks = {executor.submit(run_member, member, requests[member.name]): member for member in members}
    found: dict[str, RunMember] = {}
    for count, task in enumerate(as_completed(tasks), start=1):
        found[tasks[task].name] = task.result()
        report("campaigns", count / len(members))
        announce(task.result())
    return tuple(found[member.name] for member in members)


def models_of(request: RunRequest) -> dict[str, WantedModel]:
    """Return the models that a campaign needs and that are not in the cache, by all that decides them.

    Declarations that are equal but for title, date and temperatures need one model. A campaign that cannot be read
    needs none: its run says why.
    """
    try:
        work = Work(request, request.run)
        wanted = work.models_wanted() if work.hashes else ()
    except (CampaignFileError, ResultFileError, OSError, ValueError):
        return {}
    found = {}
    for one in wanted:
        declared = json.loads(one.declared)
        if one.kind != PANEL:
            declared = [declared.get(name) for name in DECIDES] + [declared["protocol"]["band"]]
        key = hashlib.sha256(json.dumps([one.kind, declared], sort_keys=True).encode()).hexdigest()
        found[key] = one
    return found


def run_member(member: FleetMember, request: RunRequest) -> RunMember:
    """Run the stages of one campaign, without workers or a terminal of its own."""
    empty = RunMember(member.name, member.campaign, request.run)
    states: dict[str, StageRecord] = {}

    def keep(stage: str, state: StageRecord) -> None:
        states[stage] = replace(state, inputs={}, settings={}, versions={}, results={})  # run.json holds them

    try:
        run_chain(request, RunListener(keep, _no_progress, _no_workers))
    except (CampaignFileError, ResultFileError) as error:
        return replace(empty, stages=states, failure=" ".join(str(error).split()))
    except OSError as error:
        sentence = told(error)
        if sentence is None:
            raise
        return replace(empty, stages=states, failure=sentence)
    return replace(empty, stages=states)


@contextmanager
def _no_progress() -> Iterator[Progress]:
    yield silent


@contextmanager
def _no_workers(_: int) -> Iterator[Executor | None]:
    yield None


def is_campaign(path: Path) -> bool:
    """Whether a folder claims to be a campaign of any form."""
    return is_campaign_folder(path) or is_recorded_campaign(path) or declares_plate(path)


def is_fleet(named: Sequence[Path]) -> bool:
    """Whether the paths typed ask for a fleet, not for a single campaign."""
    (first, *others) = named
    return bool(others) or _is_list(first) or (not is_campaign(first) and bool(_inside(first)))


def fleet_members(named: Sequence[Path]) -> tuple[FleetMember, ...]:
    """Return the campaigns of the paths typed, in their order, those of a folder by name.

    Raises
    ------
    ResultFileError
        For a path that holds no campaign, a list that cannot be read, two campaigns of one name.
    """
    found: list[FleetMember] = []
    for path in named:
        found += [FleetMember(one.resolve().name, one) for one in _campaigns_of(path)]
    places: dict[str, Path] = {}
    for one in found:
        before = places.setdefault(one.name, one.campaign)
        if before is not one.campaign and before.resolve() == one.campaign.resolve():
            raise ResultFileError(f"{one.campaign} is named twice: name each piece once")
        if before is not one.campaign:
            raise ResultFileError(
                f"{before} and {one.campaign} have one name, and results are called by it: rename one of them"
            )
    if len(found) > MOST_CAMPAIGNS:
        raise ResultFileError(f"{len(found)} campaigns are named; allowed: up to {MOST_CAMPAIGNS}")
    return tuple(found)


def _is_list(path: Path) -> bool:
    return path.suffix.lower() in LISTS and path.is_file()


def _campaigns_of(path: Path) -> list[Path]:
    if _is_list(path):
        return _listed(path)
    if is_campaign(path):
        return [path]
    inside = _inside(path)
    if not inside:
        raise ResultFileError(
            f"{path}: no campaign, nor a folder of campaigns; allowed: folders with campaign.toml (recorded), "
            "protocol.json (imported) or plate.toml (FRFs), folders of such, and lists of them (*.txt)"
        )
    return inside


def _inside(folder: Path) -> list[Path]:
    """Return the campaigns in a folder, by name; none where it is none, or cannot be listed."""
    with suppress(OSError):
        return sorted(one for one in folder.iterdir() if one.is_dir() and is_campaign(one))
    return []


def _is_there(folder: Path) -> bool:
    """Whether a folder that a list names is a campaign; not where its name is none that a disk takes."""
    try:
        return is_campaign(folder)
    except (OSError, ValueError):
        return False


def _listed(path: Path) -> list[Path]:
    try:
        lines = read_text(path, LARGEST_LIST_FILE).splitlines()
    except (OSError, ValueError) as error:
        raise ResultFileError(
            f"{path}: the list cannot be read ({error}); allowed: text, one folder a line"
        ) from error
    found = []
    for number, line in enumerate(lines, start=1):
        named = line.partition("#")[0].strip()
        if not named:
            continue
        one = path.parent / named
        if not _is_there(one):
            raise ResultFileError(
                f"{path}: line {number}: {named[:80]} is no campaign; allowed: folders with campaign.toml, "
                "protocol.json or plate.toml, relative to the list"
            )
        found.append(one)
    if not found:
        raise ResultFileError(f"{path}: the list is empty; allowed: one folder a line, # before remarks")
    return found
