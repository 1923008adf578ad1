"""Simulation of one campaign of a trial: drawn, its truth written, recorded on the simulated rig.

Small causes are in every campaign; nobody tells them, and the judging library lacks them. They are what a
laboratory has besides the one effect that is looked for: loss that differs by direction or frequency, a foam below
the plate, air, strings that resonate. Together they make the resonances scatter about those of the twin by a given
amount.
"""

import copy
import shutil
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Values
from app.blind_trial.assignments import KINDS, Assignment, shuffled
from app.blind_trial.draw_effects import USED_RANGE_SHARE, DrawnEffects, draw_effects, random_values
from app.blind_trial.effect_size import EffectSize
from app.blind_trial.experiments import any_declaration, declared, draw_experiments
from app.blind_trial.plates import OTHER_MESH, PlateKind, as_it_is
from app.blind_trial.specimen import Specimen
from app.blind_trial.unlisted_effects import UNLISTED_EFFECTS
from app.files.atomic import write_json
from app.files.campaigns.folder import Source
from app.files.campaigns.import_recording import import_joined
from app.files.provenance import sha256
from app.stages.acquire import acquire_campaign
from app.twins.campaign_twin import effect_twin
from drivers.rig.campaign import unobserved
from drivers.rig.session import Session
from simulation.effects.library import LIBRARY, library

SCHEMA = "flexura-blind-truth/1"
NOISE_RANGE = (0.01, 0.03)
"""Noise on a line of a sweep's FRF, as a share of the response. Over its four hundred lines a sweep has the same
information as with 1 % on every tenth, and the twin's error of 0.1 % does not hide effects of a few sigma."""


BOTH_WAYS = ("thermal_lag", "annealing", "depolarization")
"""Effects that only an up and a down ramp show."""
TWO_LEVELS = ("amplitude_softening", "piezo_nonlinearity")
"""Effects that only two levels show."""


def wanted(assignment: Assignment, names: Sequence[str], stream: str, seed: int) -> tuple[str, ...]:
    """Name of the effect to hide; the second of a pair is chosen later, when the plate is known.

    Parameters
    ----------
    assignment : Assignment
    names : sequence of str
        Effects to choose from; the kind ``outside`` has its own.
    stream, seed : str, int
        See `shuffled`.

    Returns
    -------
    tuple of str
        One name; empty for the kind ``null``.
    """
    word = KINDS.index(assignment.kind)
    match assignment.kind:
        case "null":
            return ()
        case "outside":
            return (shuffled(tuple(UNLISTED_EFFECTS), stream, seed, assignment.ordinal, word),)
        case _:
            return (shuffled(names, stream, seed, assignment.ordinal, word),)


def ways(names: Sequence[str], rng: np.random.Generator) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Legs and levels that can show all `names`; two legs are also used in a third of the other campaigns."""
    legs = ("up", "down") if set(BOTH_WAYS) & set(names) or rng.random() < 1.0 / 3.0 else ("up",)
    levels = (1.0, 2.0) if set(TWO_LEVELS) & set(names) else (1.0,)
    return legs, levels


def partners(names: Sequence[str], legs: Sequence[str], levels: Sequence[float]) -> tuple[str, ...]:
    """Return the effects that a campaign can show.

    Parameters
    ----------
    names : sequence of str
        Of effects.
    legs : sequence of str
    levels : sequence of float

    Returns
    -------
    tuple of str
        Of `names`.
    """
    blind = set(BOTH_WAYS) if len(legs) < 2 else set()
    blind |= set(TWO_LEVELS) if len(levels) < 2 else set()
    return tuple(name for name in names if name not in blind)


NUISANCES = (
    "loss_orthotropy",
    "damping_dispersion",
    "suspension",
    "elastic_foundation",
    "surface_damping",
    "air_loading",
    "resonator_at_place",
)
"""Effects of the library; those drawn are taken from it when the campaign is judged."""
NUISANCE_SCATTER = (0.0, 0.001, 0.003, 0.01)
"""Scatter of the resonances that they make, used in turn: relative, frequency and half loss factor together."""
CAUSES_AT_ONCE = 3
"""Different causes that are mixed in one campaign."""
REFUSED_FACTOR = 0.5
"""Factor on all of them while the twin refuses them."""
MOST_SCALINGS, SCATTER_ERROR = 6, 0.1
"""Largest number of times that they are scaled, and how near the scatter comes."""


@dataclass(frozen=True)
class Nuisances:
    """Small causes of one campaign.

    Attributes
    ----------
    effects : mapping
        Parameters by effect.
    scatter : float
        That they make.
    """

    effects: Mapping[str, Values] = field(default_factory=dict)
    scatter: float = 0.0


def draw_nuisances(
    wanted: float, left_out: Sequence[str], yard: EffectSize, rng: np.random.Generator
) -> Nuisances:
    """Draw a few causes and scale them to a scatter of the resonances.

    Parameters
    ----------
    wanted : float
        One of `NUISANCE_SCATTER`.
    left_out : sequence of str
        Effects that are hidden.
    yard : EffectSize
        Campaign for which the scatter is computed.
    rng : numpy.random.Generator

    Returns
    -------
    Nuisances
    """
    cards = yard.specimen.cards
    names = [name for name in NUISANCES if name in cards and name not in left_out]
    chosen = [str(name) for name in rng.permutation(names)[:CAUSES_AT_ONCE]]
    drawn = {name: random_values(cards[name], rng) for name in chosen}
    if not wanted:
        return Nuisances()
    amount, found = 0.1, Nuisances()
    for _ in range(MOST_SCALINGS):
        effects = {name: _scaled(cards[name], *drawn[name], amount) for name in chosen}
        scatter = yard.scatter(effects)
        if scatter is None:
            amount *= REFUSED_FACTOR
            continue
        found = Nuisances(effects, scatter)
        if abs(scatter / wanted - 1.0) < SCATTER_ERROR:
            break
        amount *= float(np.clip(wanted / scatter, 0.1, 10.0))
    return found


def _scaled(card: EffectCard, amplitudes: Values, shapes: Values, amount: float) -> dict[str, float]:
    within = {
        p.name: float(np.clip(amount * amplitudes[p.name], USED_RANGE_SHARE * p.low, USED_RANGE_SHARE * p.high))
        for p in card.amplitudes
    }
    return {**within, **shapes}


def make_campaign(
    assignment: Assignment,
    kind: PlateKind,
    stream: str,
    seed: int,
    truth: Path,
    folder: Path,
    built: PlateKind | None = None,
) -> None:
    """Simulate a campaign; its folder does not contain the truth.

    Parameters
    ----------
    assignment : Assignment
    kind : PlateKind
    stream, seed : str, int
        Seeds of all random numbers.
    truth : Path
        File for the truth, written before anything is recorded; the campaign contains its SHA-256.
    folder : Path
        Campaign folder; remains of an interrupted run are removed. With several inputs each has a folder of its
        own beside it, and this one holds the joined campaign.
    built : PlateKind, optional
        The plate as it is, with nuisances that nobody tells; by default as declared, without any.
    """
    rng = assignment.rng(stream, seed)
    possible = library(any_declaration(kind))
    names = tuple(name for name in LIBRARY if name in possible)
    first = wanted(assignment, names, stream, seed)
    legs, levels = ways(first, rng)
    specimen = _specimen(kind, built, rng, f"trial {assignment.name}", legs, levels)
    experiments = specimen.experiments
    share = float(np.exp(rng.uniform(*np.log(NOISE_RANGE))))
    judging = effect_twin(declared(experiments), lambda stage, share: None)
    with ThreadPoolExecutor(1) as executor:
        yard = EffectSize.of(specimen, judging, share, rng, executor)
        untold = Nuisances()
        if built is not None:
            untold = draw_nuisances(NUISANCE_SCATTER[assignment.ordinal % len(NUISANCE_SCATTER)], first, yard, rng)
            yard = yard.beside(untold.effects) if untold.effects else yard
        others = tuple(name for name in partners(names, legs, levels) if name not in untold.effects)
        hidden = draw_effects(assignment, first, others, yard, rng)
    write_json(truth, record(assignment, kind, specimen, hidden, yard, untold))
    record_on_rig(specimen, {**untold.effects, **hidden.effects}, yard.noise, truth, folder)


def _specimen(
    kind: PlateKind,
    built: PlateKind | None,
    rng: np.random.Generator,
    title: str,
    legs: tuple[str, ...],
    levels: tuple[float, ...],
) -> Specimen:
    """Draw the experiments of a plate, and of the same plate as it is with the same numbers."""
    again = copy.deepcopy(rng)
    experiments = draw_experiments(rng, kind, title, legs, levels)
    if built is None:
        return Specimen.of(experiments)
    return Specimen.of(experiments, built=as_it_is(draw_experiments(again, built, title, legs, levels), rng))


def record_on_rig(
    specimen: Specimen, hidden: Mapping[str, Values], noise: float, truth: Path, folder: Path
) -> None:
    """Record the campaign of every input, and join them if there are several.

    Parameters
    ----------
    specimen : Specimen
    hidden : mapping
        Parameters by effect, nuisances included.
    noise : float
        On every input of the cards, V rms.
    truth : Path
        File of the truth, already written; every campaign contains its SHA-256.
    folder : Path
        The campaign's, see `make_campaign`.
    """
    shutil.rmtree(folder, ignore_errors=True)
    several = len(specimen.experiments) > 1
    parts = []
    for source, experiment in enumerate(specimen.experiments):
        part = folder.with_name(f"{folder.name}-{specimen.declared.inputs[source].id}") if several else folder
        shutil.rmtree(part, ignore_errors=True)
        rig = specimen.rig(source, hidden, noise, truth)
        acquired = experiment.model_dump(mode="json", exclude={"simulation"})
        session, file = Session(rig, experiment.limits), Source(truth.name, sha256(truth))
        acquire_campaign(session, experiment, part, file, acquired, unobserved)
        parts.append(part)
    if several:
        import_joined(parts, folder)


def record(
    assignment: Assignment,
    kind: PlateKind,
    specimen: Specimen,
    hidden: DrawnEffects,
    yard: EffectSize,
    untold: Nuisances,
) -> dict[str, Any]:
    """Return the content of a truth file.

    Parameters
    ----------
    assignment : Assignment
    kind : PlateKind
    specimen : Specimen
    hidden : DrawnEffects
    yard : EffectSize
        Gives the noise, V rms, and the sweeps.
    untold : Nuisances

    Returns
    -------
    dict
        Of JSON values.
    """
    shown = yard.sweeps
    return {
        "schema": SCHEMA,
        "number": assignment.number,
        "kind": assignment.kind,
        "ablated": next(iter(hidden.effects)) if assignment.kind == "ablated" else None,
        "effects": hidden.effects,
        "prior_sigma": {
            name: {p.name: p.sigma for p in specimen.cards[name].amplitudes} for name in hidden.effects
        },
        "size_sigma": hidden.size,
        "sigma": yard.sigma,
        "cosine": hidden.cosine,
        "imitations": hidden.imitations,
        "legs": sorted(set(shown.direction), reverse=True),
        "levels": sorted({point.level for point in shown.points}),
        "gain": dict(zip(kind.inputs, specimen.driven.tolist(), strict=True)),
        "noise": yard.noise,
        "seed": [one.seed for one in specimen.simulations],
        "laws": specimen.true_laws.model_dump(mode="json"),
        "untold": untold.effects,
        "scatter": untold.scatter,
        "built": specimen.declared.plate.model_dump(mode="json", exclude_none=True),
        "plate": kind.record(),
        "mesh": asdict(OTHER_MESH),
    }
