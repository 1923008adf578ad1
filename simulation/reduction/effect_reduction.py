"""Reduction of a plate so that it answers for a whole family of states: effects of every size, combined freely.

The vectors of the plain reduction are joined by the leading directions of what they miss of the answers to forces
at points as declared, and of those to patches and transducers in extreme states. What is left is measured against
the full plate in other states.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.experiment import Experiment
from analysis.material import MaterialBox
from analysis.progress import Progress
from simulation.reduction.basis_training import BasisTraining
from simulation.reduction.effect_certification import measured_error
from simulation.reduction.effect_operators import EffectOperators
from simulation.reduction.effect_projection import plate_energies, strains
from simulation.reduction.energy_decomposition import energy_shift, middle
from simulation.reduction.missing_answers import joined, missed
from simulation.reduction.patch_projection import patch_energies
from simulation.reduction.plate_basis import PlateBasis, plain_reduction
from simulation.reduction.projector import CHUNK, Projector
from simulation.shell.assembly import FEW, assemble_chosen
from simulation.shell.fineness import Fineness
from simulation.shell.footprints import attached_disc
from simulation.shell.shell_model import ShellModel
from simulation.state.extreme_states import SLIP, SOFT, STIFF, extreme_states, laws_within, offset_states
from simulation.state.plate_state import PlateState
from simulation.state.sensor_offset import OFFSET_RANGE, can_move, offset_energies
from simulation.state.state_matrices import FullPlate

STAGE = "reducing the plate with its effects"
WORKERS = 2
"""States answered, and energies projected, at a time."""
LEAST, TAIL = 5e-4, 2e-3
"""Shares of a state's answers: what one direction has to hold, and what all that are left out may hold."""


def reduce_with_effects(
    experiment: Experiment,
    box: MaterialBox,
    *,
    basis: PlateBasis | None = None,
    fineness: Fineness | None = None,
    training: BasisTraining | None = None,
    progress: Progress | None = None,
) -> tuple[EffectOperators, FullPlate, Real]:
    """Reduce an experiment's plate for all states that effects make of it.

    Parameters
    ----------
    experiment : Experiment
    box : MaterialBox
    basis : PlateBasis, optional
        Of the plain reduction at the same `fineness`; one that is not given, or is of another mesh (of another
        version's triangulation), is made with `training`.
    fineness : Fineness, optional
    training : BasisTraining, optional
    progress : callable, optional
        Called with the stage's name and the share done.

    Returns
    -------
    ops : EffectOperators
        With their error measured.
    full : FullPlate
    vectors : (n, r) ndarray
        Orthonormal in the mass.

    Raises
    ------
    GeometryError
        Where no good mesh is found.
    ValueError
        If box or band make no sense, or the plate has neither patch nor force.
    RuntimeError
        If the tolerance of the plain reduction cannot be reached.
    """
    report = progress or (lambda stage, share: None)
    band = experiment.protocol.band
    attached = [attached_disc(experiment.plate, a) for a in experiment.attachments]
    acting, felt = [*attached, *experiment.footprints], experiment.footprints[:FEW]
    model = None
    if basis is not None:
        model = assemble_chosen(experiment.plate, experiment.patch, basis.kept, fineness=fineness)
    if basis is None or model is None or not basis.fits(model.mass):
        model, _, basis = plain_reduction(
            experiment.plate,
            experiment.patch,
            box,
            band,
            attached=attached,
            footprints=experiment.footprints,
            driven=experiment.driven,
            fineness=fineness,
            training=training,
            progress=progress,
        )
    full = FullPlate.of(model)
    probe = model.footprint_rows(acting)
    missing = _missing(full, basis.vectors, probe[: len(attached) + FEW].T, felt, box, band, report)
    energy = model.stiffness(*middle(box)) + energy_shift(band) * model.mass
    vectors = joined(basis.vectors, missing, energy, model.mass, TAIL * _finer(box))
    done = [0.6]

    def step() -> None:
        report(STAGE, done[0])
        done[0] += 0.25 * CHUNK / model.space.mesh.cells

    places = np.array([disc.point for disc in attached]).reshape(-1, 2)
    ops = project(full, vectors, model, places, probe, box, band, step)
    report(STAGE, 0.9)
    error = measured_error(full, ops, acting[: len(attached) + FEW])
    ops = replace(ops, error=error, plain_error=basis.error, dropped=basis.dropped)
    report(STAGE, 1.0)
    return ops, full, vectors


def _finer(box: MaterialBox) -> float:
    """Return the factor of shares of answers: transfers follow their squares, over the loss factor."""
    fine = Fineness()
    return float(np.sqrt(fine.share(box) / fine.tolerance))


def _missing(
    full: FullPlate,
    vectors: Real,
    loads: Real,
    felt: Sequence[Footprint],
    box: MaterialBox,
    band: tuple[float, float],
    report: Progress,
) -> Real:
    """Collect what the vectors miss, (n, s): answers to `loads` (n, k) as declared, to the rest in extreme states.

    The rest are the patches and the footprints `felt`.
    """
    as_declared = plain_states(full, box) if loads.size else []
    states = [*as_declared, *training_states(full, box)]
    found = []
    finer = _finer(box)

    def missing(place: int) -> Real:
        matrices = full.matrices(states[place], loss=False, footprints=felt)
        if place < len(as_declared):
            matrices = replace(matrices, coupling=loads)
        return missed(vectors, matrices, band, LEAST * finer)

    with ThreadPoolExecutor(WORKERS) as executor:
        for k, part in enumerate(executor.map(missing, range(len(states)))):
            report(STAGE, 0.3 + 0.3 * (k + 1) / len(states))
            found.append(part)
    return np.hstack(found)


def plain_states(full: FullPlate, box: MaterialBox) -> list[PlateState]:
    """States of the plate as declared: soft, stiff and between."""
    laws = [laws_within(box, shares) for shares in (SOFT, STIFF, (0.5, 0.5))]
    return [PlateState.baseline(*full.sampling, there, there.reference, np.array([500.0])) for there in laws]


def training_states(full: FullPlate, box: MaterialBox) -> list[PlateState]:
    """States in which the vectors must answer: what an offset does is no mirror of what the opposite one does.

    The bond is loosened on a stiff plate too: patches that hardly hold change it in another way than a soft one.
    """
    reach = OFFSET_RANGE if can_move(full) else 0.0
    soft, stiff, _ = plain_states(full, box)
    loose = stiff.with_(bond=1.0 - SLIP)
    return [*extreme_states(*full.sampling, soft.laws, reach), *offset_states(soft, -reach), loose]


def project(
    full: FullPlate,
    vectors: Real,
    model: ShellModel,
    places: Real,
    probe: Real,
    box: MaterialBox,
    band: tuple[float, float],
    step: Callable[[], None],
) -> EffectOperators:
    """Operators on given vectors; their error is yet unmeasured.

    Parameters
    ----------
    full : FullPlate
    vectors : (n, r) ndarray
        Orthonormal in the mass.
    model : ShellModel
        The plain plate, whose capacitances are taken.
    places : (K, 2) ndarray, m
        Points of strings and cables.
    probe : (K + S, n) matrix
        Mean deflections there, then over the footprints of transducers.
    box : MaterialBox
    band : (float, float)
        Hz.
    step : callable
        Called after every chunk of cells.

    Returns
    -------
    EffectOperators
        Its error is infinite, for nobody has measured it.
    """
    p = Projector(full, vectors)
    with ThreadPoolExecutor(WORKERS) as executor:
        stacks: dict[str, Any] = {
            **plate_energies(p, executor, step),
            **patch_energies(p, executor),
            **offset_energies(p, executor),
            **strains(p),
        }
    return EffectOperators(
        **stacks,
        damping=vectors.T @ (full.damping @ vectors),
        capacitance=model.capacitance,
        points=places,
        deflection=probe[: len(places)] @ vectors,
        footprints=probe[len(places) :] @ vectors,
        box=box,
        band=band,
        error=float("inf"),
    )
