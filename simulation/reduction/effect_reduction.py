"""Reduction of a plate for a whole family of states: effects of every size, in any combination.

The vectors of the plain reduction are extended by the leading directions of the responses that they do not
represent: to point forces in the state as declared, and to patches and transducers in extreme states. The error is
measured against the full plate in other states.
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
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.effect_certification import (
    SLIP,
    SOFT,
    STIFF,
    departed_sheet,
    extreme_states,
    laws_within,
    measured_error,
    offset_states,
    sheet_error,
)
from simulation.reduction.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE, EffectOperators
from simulation.reduction.effect_projection import (
    CELLS_AT_ONCE,
    Projector,
    patch_energies,
    plate_energies,
    strains,
    unspotted,
)
from simulation.reduction.places import attachable, nowhere, patterns
from simulation.reduction.plate_basis import PlateBasis, plain_reduction
from simulation.reduction.vectors.energy_decomposition import energy_shift, middle
from simulation.reduction.vectors.rational_krylov import extended_basis, missing_directions
from simulation.shell.assembly import SELECTING_FORCES, assemble_chosen
from simulation.shell.fineness import Fineness, relative_loss
from simulation.shell.points import attached_discs
from simulation.shell.shell_model import ShellModel
from simulation.shell.shell_plate import ShellPlate
from simulation.state.patch_departures import (
    OFFSET_RANGE,
    can_move,
    footprint_slopes,
    offset_energies,
    patch_departures,
    patches_as_declared,
    shift_slopes,
    unmoved,
)
from simulation.state.plate_state import ABOUT, SHEETS, PlateState, Sheet
from simulation.state.state_matrices import FullPlate

STAGE = "reducing the plate with its effects"
TOLERANCES = "tolerances of the declaration"
WORKERS = 2
"""Number of states solved, and of energies projected, at a time."""
LEAST_DIRECTION, LARGEST_TAIL = 5e-4, 2e-3
"""Shares of a state's responses: smallest share of one direction, largest share of all directions left out."""
OF_SHEETS = 0.2
"""Factor on them for orthotropic sheets, whose moduli may be far from their declaration: natural frequencies of a
spruce plate with moduli 42 % off are exact to 5e-6, with a factor of 1 to 4e-5."""
LEAST_LOSS = 0.02
"""Smallest loss factor, over the usual one, by which they are made smaller."""


def reduce_with_effects(
    experiment: Experiment,
    box: MaterialBox,
    *,
    basis: PlateBasis | None = None,
    fineness: Fineness | None = None,
    training: BasisTraining | None = None,
    near: Sheet | None = None,
    exact: bool = False,
    offset: bool = True,
    progress: Progress | None = None,
) -> tuple[EffectOperators, FullPlate, Real]:
    """Reduce an experiment's plate for all states that effects can cause.

    Parameters
    ----------
    basis : PlateBasis, optional
        Of the plain reduction at the same `fineness`; if not given, or of another mesh (another version's
        triangulation), it is computed with `training`.
    near : (4,) tuple of float, optional
        Logarithms of an orthotropic sheet's moduli about which the operators are made, see
        `simulation.state.plate_state`; about the declared ones, and less exact, unless given.
    exact : bool
        Whether patches are exactly as declared; how their places change a plate takes half of the time.
    offset : bool
        Whether the first sensor may lie up to `OFFSET_RANGE` beside its place, which takes a third of the time and
        more than half of the memory.
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
        For an invalid box or band, or a plate with neither patch nor force.
    RuntimeError
        If the tolerance of the plain reduction cannot be reached.
    """
    report = progress or (lambda stage, share: None)
    band = experiment.protocol.band
    attached = attached_discs(experiment.plate, experiment.attachments)
    acting, measured = [*attached, *experiment.footprints], experiment.footprints[:SELECTING_FORCES]
    model, basis = _plain(experiment, box, attached, basis, fineness, training, progress)
    full = FullPlate.of(model)
    probe = model.footprint_rows(acting)
    loads, states = probe[: len(attached) + SELECTING_FORCES].T, training_states(full, box, near, offset=offset)
    missing = _missing(full, basis.vectors, states, loads, measured, box, band, report)
    vectors = _extended(model, basis.vectors, missing, box, band)
    done = [0.6]

    def step() -> None:
        report(STAGE, done[0])
        done[0] += 0.25 * CELLS_AT_ONCE / model.space.mesh.cells

    places = np.array([disc.point for disc in attached]).reshape(-1, 2)
    ops = project(
        full,
        vectors,
        model,
        places,
        probe,
        box,
        band,
        step,
        footprints=experiment.footprints,
        attached=attached,
        exact=exact,
        offset=offset,
    )
    report(STAGE, 0.9)
    error = measured_error(full, ops, acting[: len(attached) + SELECTING_FORCES])
    if full.shell.orthotropic:
        error = max(error, sheet_error(full, ops, near, acting[: len(attached) + SELECTING_FORCES]))
    ops = replace(ops, error=error, plain_error=basis.error, dropped=basis.dropped)
    report(STAGE, 1.0)
    return ops, full, vectors


def _plain(
    experiment: Experiment,
    box: MaterialBox,
    attached: Sequence[Footprint],
    basis: PlateBasis | None,
    fineness: Fineness | None,
    training: BasisTraining | None,
    progress: Progress | None,
) -> tuple[ShellModel, PlateBasis]:
    """Plate without effects and the basis of its plain reduction, computed unless `basis` fits the plate."""
    if basis is not None:
        model = assemble_chosen(
            experiment.plate, experiment.patch, box, experiment.protocol.band, basis.kept, fineness=fineness
        )
        if model is not None and basis.fits(model.mass):
            return model, basis
    model, _, basis = plain_reduction(
        experiment.plate,
        experiment.patch,
        box,
        experiment.protocol.band,
        attached=attached,
        footprints=experiment.footprints,
        driven=experiment.driven,
        fineness=fineness,
        training=training,
        progress=progress,
    )
    return model, basis


def _finer(box: MaterialBox, shell: ShellPlate) -> float:
    """Return a factor on the shares: errors of transfers are their squares over the loss factor."""
    return (OF_SHEETS if shell.orthotropic else 1.0) * float(
        np.sqrt(min(1.0, max(relative_loss(box), LEAST_LOSS)))
    )


def _extended(
    model: ShellModel, vectors: Real, missing: Real, box: MaterialBox, band: tuple[float, float]
) -> Real:
    """Add the leading directions (n, s) to vectors (n, r), see `extended_basis`."""
    energy = model.stiffness(*middle(box)) + energy_shift(band) * model.mass
    gram = vectors.T @ (energy @ vectors)
    return extended_basis(vectors, missing, energy, model.mass, LARGEST_TAIL * _finer(box, model.shell), gram=gram)


def _missing(
    full: FullPlate,
    vectors: Real,
    changed: Sequence[PlateState],
    loads: Real,
    measured: Sequence[Footprint],
    box: MaterialBox,
    band: tuple[float, float],
    report: Progress,
) -> Real:
    """Collect missing directions (n, s): responses to `loads` (n, k) as declared, to the rest in changed states.

    The rest are the patches and the footprints `measured`. In the soft plate, which has most modes in the band, it
    also answers to forces all over it.
    """
    soft, *others = plain_states(full, box)
    everywhere = np.hstack([loads, patterns(full, box, band)])
    as_declared = [soft, *others] if loads.size else [soft]
    states = [*as_declared, *changed]
    found = []
    finer = _finer(box, full.shell)

    def missing(place: int) -> Real:
        matrices = full.matrices(states[place], loss=False, footprints=measured)
        if place < len(as_declared):
            matrices = replace(matrices, coupling=loads if place else everywhere)
        return missing_directions(vectors, matrices, band, LEAST_DIRECTION * finer)

    with ThreadPoolExecutor(WORKERS) as executor:
        for k, part in enumerate(executor.map(missing, range(len(states)))):
            report(STAGE, 0.3 + 0.3 * (k + 1) / len(states))
            found.append(part)
    return np.hstack(found)


def plain_states(full: FullPlate, box: MaterialBox) -> list[PlateState]:
    """States of the plate as declared: soft, stiff and between."""
    laws = [laws_within(box, shares) for shares in (SOFT, STIFF, (0.5, 0.5))]
    return [PlateState.baseline(*full.sampling, there, there.reference, np.array([500.0])) for there in laws]


def training_states(
    full: FullPlate, box: MaterialBox, near: Sheet | None = None, *, offset: bool = True
) -> list[PlateState]:
    """States used for training, with offsets of both signs, because their effects are not symmetric.

    A compliant bond is included for a stiff plate too, because its effect differs from that on a soft plate.

    Parameters
    ----------
    near : (4,) tuple of float, optional
        See `sheet_states`.
    """
    reach = OFFSET_RANGE if offset and can_move(full) else 0.0
    soft, stiff, _ = plain_states(full, box)
    loose = stiff.with_(bond=1.0 - SLIP)
    extreme = extreme_states(*full.sampling, soft.laws, reach)
    return [*extreme, *offset_states(soft, -reach), loose, *sheet_states(full, box, near)]


def sheet_states(full: FullPlate, box: MaterialBox, near: Sheet | None) -> list[PlateState]:
    """States of an orthotropic sheet with other moduli than declared, soft and stiff.

    Parameters
    ----------
    near : (4,) tuple of float or None
        Moduli about which they are; None for states over the whole range.

    Returns
    -------
    list of PlateState
        None of isotropic sheets.
    """
    if not full.shell.orthotropic:
        return []
    around = SHEETS if near is None else tuple(tuple(np.add(near, away)) for away in ABOUT)
    plain = plain_states(full, box)[:2]
    return [departed_sheet(state, full.shell.sheet, away) for state in plain for away in around]


def reduce_with_departures(
    experiment: Experiment,
    box: MaterialBox,
    *,
    basis: PlateBasis | None = None,
    fineness: Fineness | None = None,
    near: Sheet | None = None,
    progress: Progress | None = None,
) -> EffectOperators:
    """Reduce an experiment's plate for errors of its declaration alone, with the vectors of the plain reduction.

    Derivatives of a response by small changes need the response only, which these vectors represent: the first
    order of every departure is as accurate as they are. The moduli of an orthotropic sheet may be far from their
    declaration: vectors are added that follow them.

    Parameters
    ----------
    basis : PlateBasis, optional
        As in `reduce_with_effects`.
    near : (4,) tuple of float, optional
        As in `reduce_with_effects`.
    progress : callable, optional
        Called with the stage's name and the share done.

    Returns
    -------
    EffectOperators
        Of uniform fields, without offsets of the sensor beyond tolerances and without damaged spots.

    Raises
    ------
    GeometryError, ValueError, RuntimeError
        As `reduce_with_effects`.
    """
    report = progress or (lambda stage, share: None)
    attached = attached_discs(experiment.plate, experiment.attachments)
    model, basis = _plain(experiment, box, attached, basis, fineness, None, progress)
    report(TOLERANCES, 0.2)
    full = FullPlate.of(model)
    probe = model.footprint_rows([*attached, *experiment.footprints])
    places = np.array([disc.point for disc in attached]).reshape(-1, 2)
    band, measured = experiment.protocol.band, experiment.footprints[:SELECTING_FORCES]
    vectors, states = basis.vectors, sheet_states(full, box, near)
    if states:
        missing = _missing(full, vectors, states, np.zeros((model.size, 0)), measured, box, band, report)
        vectors = _extended(model, vectors, missing, box, band)
    ops = project(
        full,
        vectors,
        model,
        places,
        probe,
        box,
        band,
        lambda: None,
        footprints=experiment.footprints,
        attached=attached,
        uniform=True,
    )
    error = sheet_error(full, ops, near, [*attached, *measured]) if states else 0.0
    report(TOLERANCES, 1.0)
    return replace(ops, error=max(basis.error, error), plain_error=basis.error, dropped=basis.dropped)


def project(
    full: FullPlate,
    vectors: Real,
    model: ShellModel,
    places: Real,
    probe: Real,
    box: MaterialBox,
    band: tuple[float, float],
    step: Callable[[], None],
    *,
    footprints: Sequence[Footprint] = (),
    attached: Sequence[Footprint] = (),
    uniform: bool = False,
    exact: bool = False,
    offset: bool = True,
) -> EffectOperators:
    """Operators on given vectors; their error is not measured yet.

    Parameters
    ----------
    vectors : (n, r) ndarray
        Orthonormal in the mass.
    model : ShellModel
        The plate without effects, which gives the capacitances.
    places : (K, 2) ndarray, m
        Points of strings and cables.
    probe : (K + S, n) matrix
        Mean deflections there, then over the footprints of transducers.
    band : (float, float)
        Hz.
    step : callable
        Called after every chunk of cells.
    footprints, attached : sequence of Footprint
        The S of transducers, and the K discs at `places`.
    uniform : bool
        Whether all fields are uniform, without damaged spots and without offsets of the sensor beyond tolerances.
    exact : bool
        Whether patches are exactly as declared.
    offset : bool
        Whether the first sensor may lie up to `OFFSET_RANGE` beside its place.

    Returns
    -------
    EffectOperators
        With an infinite error, because it is not measured.
    """
    p = Projector(full, vectors)
    bending, other = (0, 0) if uniform else (BENDING_DEGREE, MEMBRANE_DEGREE)
    with ThreadPoolExecutor(WORKERS) as executor:
        stacks: dict[str, Any] = {
            **plate_energies(p, executor, step, (bending, other)),
            **patch_energies(p, executor, bending),
            **(patches_as_declared(p) if exact else patch_departures(p, executor)),
            **(offset_energies(p, executor) if offset and not uniform else unmoved(vectors.shape[1])),
            **(unspotted(p) if uniform else strains(p)),
            **(nowhere(vectors.shape[1]) if uniform else attachable(full, vectors, box, band)),
        }
    return EffectOperators(
        **stacks,
        footprint_slopes=footprint_slopes(full, footprints, vectors),
        deflection_slopes=shift_slopes(full, attached, vectors),
        angle=full.shell.sheet.angle,
        damping=vectors.T @ (full.damping @ vectors),
        capacitance=model.capacitance,
        points=places,
        deflection=probe[: len(places)] @ vectors,
        footprints=probe[len(places) :] @ vectors,
        box=box,
        band=band,
        error=float("inf"),
    )
