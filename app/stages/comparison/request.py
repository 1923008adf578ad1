"""What is asked of the update and gap stages: a campaign to be set beside its twin.

What an earlier comparison left open, read from its gap.json.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from analysis.gap.plan.measurement import KINDS, OVEN_FIXED
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.recordings.grid_frequency import require_mains
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.inputs import campaign_settings
from app.files.campaigns.of_run import campaign_of
from app.files.parsed_text import parse_json, read_text
from app.files.provenance import provenance, sha256
from app.twins.campaign_twin import Start, start_of

MOST_HOURS = 1e4
"""Of a measurement: more than a year is a slip of the keyboard."""


@dataclass(frozen=True)
class UpdateRequest:
    """Model updating of a campaign's twin; its files are read and checked when it is made.

    Attributes
    ----------
    campaign : AnyCampaign
    twin : Path or None
        Twin file whose effects are on: held by the update stage, where the gap stage begins.
    effects : Path or None
        Folder with a user's own effects.
    mains : float
        Hz.

    Raises
    ------
    CampaignFileError, ResultFileError
        For a twin file or effects that do not suit the campaign's plate.
    ValueError
        For a mains frequency outside its range.
    """

    campaign: AnyCampaign
    _: KW_ONLY
    twin: Path | None = None
    effects: Path | None = None
    mains: float = 50.0

    def __post_init__(self) -> None:
        require_mains(self.mains)
        _ = self.start

    @cached_property
    def start(self) -> Start | None:
        """The twin file as read; None where none is named."""
        return start_of(self.twin, self.campaign.experiment, self.effects)

    def origin(self) -> dict[str, Any]:
        """Return the provenance of results."""
        named: dict[str, Any] = {"mains": self.mains}
        if self.start is not None:
            named |= {"twin": sha256(self.start.path), "effects": self.start.twin.effects}
        return provenance(self.campaign.hashes, named | campaign_settings(self.campaign))


@dataclass(frozen=True)
class GapRequest(UpdateRequest):
    """Comparison of a campaign with its twin, and what follows from it.

    Attributes
    ----------
    without : collection of str
        Effects of the library that are no candidates.
    describing : bool
        Whether what no effect explains is described, which takes a minute.
    plan : bool
        Whether the next experiment is planned.
    hours : mapping of str to float
        Laboratory hours of kinds of measurement, in place of the usual ones.
    rig : mapping or None
        Table of the experiment's file, which says what the rig can do; that of a planned campaign is made from it.
    after : (AnyCampaign, Path) or None
        An earlier campaign and its run folder, whose plan this campaign follows.
    """

    without: frozenset[str] = frozenset()
    describing: bool = True
    plan: bool = False
    hours: Mapping[str, float] = field(default_factory=dict)
    rig: Mapping[str, Any] | None = None
    after: tuple[AnyCampaign, Path] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.plan and (self.hours or self.rig):
            raise UnsuitedOptionError("--experiment and --hours belong to --plan")
        for kind, hours in self.hours.items():
            if kind not in KINDS or not 0.0 < hours <= MOST_HOURS:
                allowed = f"KIND=HOURS, above 0 and at most {MOST_HOURS:g}, KIND one of {', '.join(KINDS)}"
                raise UnsuitedOptionError(f"--hours '{kind}={hours:g}'; allowed: {allowed}")
        if self.after is not None:
            open_before(self.after[1])  # raises where nothing was open

    @property
    def further(self) -> bool:
        """Whether further stages take the comparison up."""
        return self.plan or self.after is not None

    def origin(self) -> dict[str, Any]:
        """Return the provenance of results: campaign, twin file, a user's effects."""
        inputs = dict(self.campaign.hashes)
        if self.twin is not None:
            inputs[f"twin {self.twin.name}"] = sha256(self.twin)
        if self.effects is not None:
            inputs |= {f"effect {file.name}": sha256(file) for file in sorted(self.effects.glob("[!_]*.py"))}
        return provenance(inputs, {"mains": self.mains, **campaign_settings(self.campaign)})


TURNED = "turned_plate"
LARGEST_GAP_FILE = 50_000_000
"""Bytes of a gap.json that is read."""


def open_before(run: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Read from a run what its plan left open.

    Parameters
    ----------
    run : Path
        Run folder with a gap.json of ``flexura gap --plan``.

    Returns
    -------
    effects : tuple of str
        All that its questions are about.
    turned : tuple of str
        Those whose amplitudes change sign, where the plan was to turn the plate.

    Raises
    ------
    ResultFileError
        Where there is none, or nothing was open.
    """
    file = run / "gap.json"
    try:
        record: Mapping[str, Any] = parse_json(read_text(file, LARGEST_GAP_FILE))
        plan = record["plan"]
        names = [name for one in plan["questions"] for name in (one["effect"], one["rival"]) if name]
        chosen = plan["next"] or {}
    except (OSError, CampaignFileError, ValueError, KeyError, TypeError) as error:
        wanted = f"make it with: flexura gap {campaign_of(run)} --plan"
        raise ResultFileError(f"{file}: holds no plan; {wanted}") from error
    if not names:
        raise ResultFileError(f"{file}: its plan has no questions; nothing was open that could be decided")
    turned = OVEN_FIXED if chosen.get("key") == TURNED else ()
    return tuple(dict.fromkeys(str(name) for name in names)), turned
