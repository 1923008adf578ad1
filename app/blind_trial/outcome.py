"""Outcome of one campaign of a trial: judged by the code of the verbs, its verdict compared with its truth."""

import time
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from analysis.gap.thresholds import CLASS_COSINE
from app.blind_trial.assignments import Kind
from app.blind_trial.effect_size import MAINS
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.loading import load_campaign
from app.files.declarations.simulation_section import Laws
from app.files.parsed_text import parse_json, read_text
from app.stages import gap
from app.stages.gap import GAP, GapRequest

REFUSED = "refused.json"


def judge_campaign(folder: Path, run: Path, without: Collection[str]) -> None:
    """Compare a campaign as ``flexura gap`` does; write gap.json, or the reason for refusal, into `run`.

    Parameters
    ----------
    folder : Path
        Folder of the campaign.
    run : Path
        Run folder; created if missing.
    without : collection of str
        Effects removed from the library for this campaign.
    """
    run.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()
    try:
        campaign = load_campaign(folder)
        request = GapRequest(campaign, mains=MAINS, without=frozenset(without), describing=False)
        found = gap.compute(request, lambda stage, share: None)
    except (CampaignFileError, ResultFileError) as error:
        write_json(run / REFUSED, {"why": str(error)})
        return
    gap.save(run, request, found, time.perf_counter() - begun)


def is_judged(run: Path) -> bool:
    """Whether a run holds a verdict, which is written last."""
    return (run / gap.GAP).is_file() or (run / REFUSED).is_file()


Record = Mapping[str, Any]
CLAIMED = ("explained", "partly_explained")


@dataclass(frozen=True)
class Named:
    """One claimed effect.

    Attributes
    ----------
    name : str
    equivalent : tuple of str
    probability : float
    against : mapping
        Log evidence of every alternative, relative to it, nats, as in gap.json.
    parameters : mapping
        Value and standard deviation of each.
    """

    name: str
    equivalent: tuple[str, ...]
    probability: float
    against: Mapping[str, float]
    parameters: Mapping[str, tuple[float, float]]

    @property
    def members(self) -> frozenset[str]:
        """Its class: the effect and those that this campaign cannot distinguish from it."""
        return frozenset({self.name, *self.equivalent})


@dataclass(frozen=True)
class TrialOutcome:
    """A campaign of a trial with its verdict and truth.

    Attributes
    ----------
    number : int
    kind : str
    effects : mapping
        Hidden parameters by effect.
    scale : mapping
        Prior standard deviations of the amplitudes, by effect; without shape parameters (position, rate).
    size : mapping
        Size of each effect, in sigma of noise and the twin's own error.
    cosine : float or None
        Between the signals of two effects.
    imitations : mapping
        Cosine between the total hidden signal and the nearest signal of each library effect.
    verdict : str
        Verdict in gap.json, or ``refused``.
    named : tuple of Named
        Effects claimed; hints with verdict unknown do not count.
    closure : float or None
        On held-out temperatures.
    closure_also : tuple of float
        On a held-out channel or level, if there was one with a gap.
    one_ramp : bool
    not_observable : frozenset of str
    seconds : float
    scatter : float
        Of the resonances, by nuisances that nobody told.
    law_errors : mapping of str to tuple of float
        Of the laws of the twin issued at the campaign's temperatures, in their stated standard deviations.
    """

    number: int
    kind: Kind
    effects: Mapping[str, Mapping[str, float]]
    scale: Mapping[str, Mapping[str, float]]
    size: Mapping[str, float]
    cosine: float | None
    imitations: Mapping[str, float]
    verdict: str
    named: tuple[Named, ...] = ()
    closure: float | None = None
    closure_also: tuple[float, ...] = ()
    one_ramp: bool = False
    not_observable: frozenset[str] = field(default_factory=frozenset)
    seconds: float = 0.0
    scatter: float = 0.0
    law_errors: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def right_names(self) -> bool:
        """Whether exactly the hidden effects are named."""
        return {n.name for n in self.named} == set(self.effects)

    @property
    def right_classes(self) -> bool:
        """Whether there are as many classes as hidden effects, each with one of them."""
        if len(self.named) != len(self.effects):
            return False
        return any(
            all(effect in named.members for effect, named in zip(self.effects, order, strict=True))
            for order in permutations(self.named)
        )

    @property
    def declared_unknown(self) -> bool:
        """Whether the verdict is unknown, or only effects confounded with the hidden one are named."""
        return self.verdict == "unknown" or (bool(self.named) and all(self._acts_alike(n) for n in self.named))

    def record(self) -> dict[str, Any]:
        """Return it for a file."""
        return {
            "number": self.number,
            "kind": self.kind,
            "hidden": {name: dict(values) for name, values in self.effects.items()},
            "size_sigma": dict(self.size),
            "cosine": self.cosine,
            "verdict": self.verdict,
            "named": {
                n.name: {"equivalent": list(n.equivalent), "probability": n.probability} for n in self.named
            },
            "right_names": self.right_names,
            "right_classes": self.right_classes,
            "declared_unknown": self.declared_unknown,
            "closure": self.closure,
            "closure_also": list(self.closure_also),
            "seconds": self.seconds,
            "scatter": self.scatter,
            "law_errors_sigma": {name: list(errors) for name, errors in self.law_errors.items()},
        }

    def is_there(self, named: Named) -> bool:
        """Whether a claimed class contains a hidden effect, or is confounded with one that the library lacks."""
        lacking = self.kind in ("outside", "ablated")
        return self._acts_alike(named) if lacking else bool(named.members & set(self.effects))

    def _acts_alike(self, named: Named) -> bool:
        return any(self.imitations.get(member, 0.0) > CLASS_COSINE for member in named.members)


def outcome(truth: Record, verdict: Record | None) -> TrialOutcome:
    """Compare a truth file with gap.json, or with None if the campaign was refused."""
    known: dict[str, Any] = {
        "number": truth["number"],
        "kind": truth["kind"],
        "effects": truth["effects"],
        "scale": truth["prior_sigma"],
        "size": truth["size_sigma"],
        "cosine": truth["cosine"],
        "imitations": truth["imitations"],
        "one_ramp": len(truth["legs"]) == 1,
        "scatter": truth["scatter"],
    }
    if verdict is None:
        return TrialOutcome(**known, verdict="refused")
    claimed = verdict["effects"] if verdict["verdict"] in CLAIMED else []
    return TrialOutcome(
        **known,
        verdict=verdict["verdict"],
        named=tuple(_named(effect) for effect in claimed),
        closure=verdict["gap"]["held_out"]["closure"] if claimed else None,
        closure_also=tuple(
            part["closure"]
            for part in verdict["gap"].get("held_out_also", ())
            if claimed and part["closure"] is not None
        ),
        not_observable=frozenset(verdict["not_observable"]),
        seconds=verdict["seconds"],
        law_errors=_law_errors(truth["laws"], verdict["laws"]["final"]),
    )


def _law_errors(truth: Record, stated: Record) -> dict[str, tuple[float, ...]]:
    true = Laws.model_validate(truth).laws().at(np.array(stated["temperature_c"]))
    found = {}
    for name, unit in (("youngs_modulus", "_pa"), ("poisson_ratio", ""), ("loss_factor", "")):
        value, sigma = (np.array(stated[f"{before}{name}{unit}"]) for before in ("", "sigma_"))
        found[name] = tuple(((value - getattr(true, name)) / sigma).tolist())
    return found


def read_outcome(truth: Path, run: Path) -> TrialOutcome | None:
    """Read one campaign's outcome; None where it has no verdict yet, ResultFileError for a damaged file."""
    verdict: Record | None = None
    if (run / GAP).is_file():
        verdict = read_record(run / GAP)
    elif not (run / REFUSED).is_file():
        return None
    hidden = read_record(truth)
    try:
        return TypeAdapter(TrialOutcome).validate_python(asdict(outcome(hidden, verdict)))
    except (LookupError, TypeError, AttributeError, ValueError) as error:
        message = f"{truth}, {run / GAP}: not what this trial wrote ({error}); make the trial again"
        raise ResultFileError(message) from error


def read_record(file: Path) -> dict[str, Any]:
    """Read one table of a trial's JSON; ResultFileError where it is none."""
    try:
        found = parse_json(read_text(file))
    except (OSError, ValueError) as error:
        raise ResultFileError(
            f"{file}: unreadable ({error}); delete the trial's folder or name another"
        ) from error
    if not isinstance(found, dict):
        raise ResultFileError(f"{file}: holds no table; delete the folder or name another")
    return found


def _named(effect: Record) -> Named:
    return Named(
        name=effect["name"],
        equivalent=tuple(effect["equivalent"]),
        probability=effect["probability"],
        against=effect["against"],
        parameters={name: (p["value"], p["sigma"]) for name, p in effect["parameters"].items()},
    )
