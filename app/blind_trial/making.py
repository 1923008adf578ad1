"""One campaign of a trial made: drawn, its truth written down, recorded on the simulated rig."""

import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from app.blind_trial.assignments import Assignment
from app.blind_trial.draw_effects import DrawnEffects, draw_effects, partners, wanted, ways
from app.blind_trial.effect_size import EffectSize
from app.blind_trial.experiments import draw_experiment
from app.blind_trial.plates import OTHER_MESH, PlateKind
from app.blind_trial.specimen import Specimen
from app.files.atomic import write_json
from app.files.provenance import sha256
from app.files.sweep_file import Source
from app.stages.acquire import acquire_campaign
from drivers.rig.campaign import unobserved
from drivers.rig.session import Session
from simulation.effects.library import LIBRARY

SCHEMA = "flexura-blind-truth/1"
NOISE = (0.01, 0.03)
"""Of the response, on a line of a sweep's FRF. Over its four hundred lines a sweep is known as well as with 1 %
on every tenth, and the twin's own error of 0.1 % does not hide what is a few sigma."""


def make_campaign(
    assignment: Assignment, kind: PlateKind, stream: str, seed: int, truth: Path, folder: Path
) -> None:
    """Make a campaign whose folder does not tell what is hidden in it.

    Parameters
    ----------
    assignment : Assignment
    kind : PlateKind
    stream, seed : str, int
        All of it follows from them.
    truth : Path
        File to write the truth to before anything is recorded: the campaign carries its SHA-256.
    folder : Path
        The campaign's; what an interrupted run left there is removed.
    """
    rng = assignment.rng(stream, seed)
    first = wanted(assignment, tuple(LIBRARY), stream, seed)
    legs, levels = ways(first, rng)
    experiment = draw_experiment(rng, kind, f"trial {assignment.name}", legs, levels)
    specimen = Specimen.of(experiment, kind)
    share = float(np.exp(rng.uniform(*np.log(NOISE))))
    with ThreadPoolExecutor(1) as executor:
        yard = EffectSize.of(specimen, share, rng, executor)
        hidden = draw_effects(assignment, first, partners(legs, levels), yard, rng)
    write_json(truth, record(assignment, kind, specimen, hidden, yard))
    shutil.rmtree(folder, ignore_errors=True)
    rig = specimen.rig(hidden.effects, yard.noise, truth)
    acquired = experiment.model_dump(mode="json", exclude={"simulation"})
    session, source = Session(rig, experiment.limits), Source(truth.name, sha256(truth))
    acquire_campaign(session, experiment, folder, source, acquired, unobserved)


def record(
    assignment: Assignment, kind: PlateKind, specimen: Specimen, hidden: DrawnEffects, yard: EffectSize
) -> dict[str, Any]:
    """Return what a truth file holds.

    Parameters
    ----------
    assignment : Assignment
    kind : PlateKind
    specimen : Specimen
    hidden : DrawnEffects
    yard : EffectSize
        Gives the noise, V rms, and the sweeps.

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    simulation, shown = specimen.simulation, yard.sweeps
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
        "gain": simulation.gain,
        "noise": yard.noise,
        "seed": simulation.seed,
        "laws": simulation.laws.model_dump(mode="json"),
        "plate": kind.record(),
        "mesh": asdict(OTHER_MESH),
    }
