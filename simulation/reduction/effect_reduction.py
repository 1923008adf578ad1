"""Reduction of a plate so that it answers for a whole family of states: effects of every size, combined freely.

The vectors of the plain reduction, point forces among its inputs, are extended state by state: a few Krylov
vectors of the plate in an extreme state, and of those the leading directions of what the plain space misses in its
responses. What is left is measured against the full plate in other states.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analysis.channel import Footprint
from analysis.experiment import Attachment, Experiment, Plate
from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox
from simulation.meshing.recipe import MeshRecipe
from simulation.reduction.campaign_basis import for_materials
from simulation.reduction.effect_certification import measured_error
from simulation.reduction.effect_operators import EffectOperators
from simulation.reduction.effect_projection import CHUNK, Projector, patch_energies, plate_energies, strains
from simulation.reduction.energy_decomposition import energy_shift, middle, orthonormal
from simulation.reduction.rational_krylov import Chain
from simulation.reduction.reduce import Training, reduction
from simulation.shell.assembly import FEW, assemble_for
from simulation.shell.factors import factorize
from simulation.shell.fineness import Fineness
from simulation.shell.shell_model import ShellModel
from simulation.state.extreme_states import SLIP, SOFT, STEEPEST, STIFF, extreme_states, laws_within, offset_states
from simulation.state.plate_state import PlateState
from simulation.state.sensor_offset import OFFSET_RANGE, can_move, offset_energies
from simulation.state.state_matrices import FullPlate, StateMatrices

Real = NDArray[np.float64]
Progress = Callable[[str, float], None]

STAGE = "reducing the plate with its effects"
INSIDE = 0.9
"""Share of the distance to the nearest edge that the disc of an attachment may take."""
WORKERS = 2
"""Energies projected at a time."""
BLOCKS = 10
BOX_TAIL = 4e-4
"""See `simulation.reduction.campaign_basis.for_materials`."""
FINE = Fineness(MeshRecipe(spacing=0.034, strip=0.7, edge_strip=0.85, growth=1.1), tolerance=1e-9)
"""Finer than the plain twin's, and on cells of its own, so that both together tell what the mesh does."""


def reduce_with_effects(
    experiment: Experiment,
    box: MaterialBox,
    *,
    fineness: Fineness | None = None,
    training: Training | None = None,
    progress: Progress | None = None,
) -> tuple[EffectOperators, FullPlate, Real]:
    """Operators of an experiment's plate, the full plate behind them, and vectors (n, N) they were chosen from.

    The operators keep r <= N directions of the vectors.
    """
    report = progress or (lambda stage, share: None)
    band = experiment.protocol.band
    attached = [attached_disc(experiment.plate, a) for a in (*experiment.string, *experiment.cable)]
    places = np.array([disc.point for disc in attached]).reshape(-1, 2)
    acting = [*attached, *experiment.footprints]
    model = assemble_for(
        experiment.plate,
        experiment.patch,
        box,
        band,
        footprints=acting,
        fineness=fineness or FINE,
        progress=lambda share: report(STAGE, 0.1 * share),
    )
    full = FullPlate.of(model)
    probe = model.footprint_rows(acting)
    trained, felt = probe[: len(places) + FEW], experiment.footprints[:FEW]
    inputs = replace(
        model,
        coupling=np.hstack([model.coupling, trained.T]),
        capacitance=np.concatenate([model.capacitance, np.ones(len(trained))]),
    )
    _, vectors = reduction(
        inputs, box, band, training=training, progress=lambda stage, share: report(STAGE, 0.1 + 0.2 * share)
    )
    states = training_states(full, box)
    for k, state in enumerate(states):
        report(STAGE, 0.3 + 0.3 * k / len(states))
        matrices = full.matrices(state, loss=False, footprints=felt)
        vectors = extended(vectors, matrices, band, (training or Training()).tolerance)
    energy = model.stiffness(*middle(box)) + energy_shift(band) * model.mass
    vectors = orthonormal(vectors, energy, cutoff=1e-6)
    done = [0.6]

    def step() -> None:
        report(STAGE, done[0])
        done[0] += 0.25 * CHUNK / model.space.mesh.cells

    ops = compressed(project(full, vectors, model, places, probe, box, band, step))
    report(STAGE, 0.9)
    ops = replace(ops, error=measured_error(full, ops, felt))
    report(STAGE, 1.0)
    return ops, full, vectors


def attached_disc(plate: Plate, attachment: Attachment) -> Footprint:
    """Disc on which a string or a cable acts: as declared, or as large as the plate's edges leave room.

    A mass at a point would be heavier the finer the mesh: the point compliance of a Mindlin plate has no limit.
    """
    point = np.array([attachment.point])
    room = min(float(loop.distance(point)[0]) for loop in (plate.loop, *plate.hole_loops))
    radius = 0.5 * plate.thickness if attachment.radius is None else attachment.radius
    return Footprint(attachment.point, min(radius, INSIDE * room))


def compressed(ops: EffectOperators) -> EffectOperators:
    """Operators on the directions that materials all over the box need."""
    (e0, e1), (n0, n1), (h0, _) = ops.box.youngs_modulus, ops.box.poisson_ratio, ops.box.loss_factor
    corners = [(e1, n0), (e1, n1), (float(np.sqrt(e0 * e1)), 0.5 * (n0 + n1)), (e0, n0), (e0, n1)]
    materials = [LocalLaws.of_material(e, nu, max(h0, 0.01), slope=STEEPEST) for e, nu in corners]
    return for_materials(ops, materials, BOX_TAIL)


def training_states(full: FullPlate, box: MaterialBox) -> list[PlateState]:
    """States in which the vectors must answer: what an offset does is no mirror of what the opposite one does.

    The bond is loosened on a stiff plate too: patches that hardly hold change it in another way than a soft one.
    """
    xi, zeta = full.sampling
    reach = OFFSET_RANGE if can_move(full) else 0.0
    laws = laws_within(box, SOFT)
    soft, stiff = (
        PlateState.baseline(xi, zeta, there, there.reference, np.array([500.0]))
        for there in (laws, laws_within(box, STIFF))
    )
    loose = stiff.with_(bond=1.0 - SLIP)
    return [*extreme_states(xi, zeta, laws, reach), *offset_states(soft, -reach), loose]


def extended(vectors: Real, matrices: StateMatrices, band: tuple[float, float], tolerance: float) -> Real:
    """Vectors (n, r + s) that answer in one more state as well, to about `tolerance`."""
    stiffness = matrices.plate + matrices.patches
    shifts = 2 * np.pi * np.array([0.55 * band[1], band[1]])
    chains = [
        Chain(factorize(stiffness - shift**2 * matrices.mass), matrices.mass, matrices.coupling)
        for shift in shifts
    ]
    new = np.hstack([chain.extend(BLOCKS)[0] for chain in chains])
    both = np.hstack([vectors, new])
    gram, elastic = both.T @ (matrices.mass @ both), both.T @ (stiffness @ both)
    answers = _answers(elastic, gram, both.T @ matrices.coupling, band)
    energy = elastic + (2 * np.pi * 0.3 * band[1]) ** 2 * gram
    old, added = _missing(energy, answers, vectors.shape[1], 3.0 * tolerance)
    fresh = new @ added - vectors @ old
    fresh = fresh - vectors @ (vectors.T @ (matrices.mass @ fresh))
    values, basis = np.linalg.eigh(_symmetric(fresh.T @ (matrices.mass @ fresh)))
    return np.hstack([vectors, fresh @ (basis / np.sqrt(values))])


def _answers(stiffness: Real, mass: Real, force: Real, band: tuple[float, float]) -> Real:
    """Real and imaginary parts of the lightly damped answers along the band, (N, k)."""
    values, basis = np.linalg.eigh(_symmetric(mass))
    kept = values > 1e-11 * values[-1]
    basis = basis[:, kept] / np.sqrt(values[kept])
    squares, shapes = scipy.linalg.eigh(_symmetric(basis.T @ stiffness @ basis), driver="evd")
    terms = 1.0 / ((1.0 + 0.04j) * squares[:, None] - (2 * np.pi * np.linspace(*band, 150)) ** 2)
    modal = ((shapes.T @ (basis.T @ force))[:, :, None] * terms[:, None, :]).reshape(len(squares), -1)
    return np.asarray(basis @ (shapes @ np.hstack([modal.real, modal.imag])))


def _missing(energy: Real, answers: Real, r: int, tolerance: float) -> tuple[Real, Real]:
    """Leading directions of what the first r coordinates cannot say of the answers, in the energy's norm.

    Returns what to take away of the first (r, s), and the shares of the others (N - r, s).
    """
    inner = np.linalg.solve(energy[:r, :r], energy[:r, r:])
    values, basis = np.linalg.eigh(_symmetric(energy[r:, r:] - energy[r:, :r] @ inner))
    kept = values > 1e-9 * values[-1]
    root = basis[:, kept] * np.sqrt(values[kept])
    size = np.sqrt(np.einsum("ij,ij->j", answers, energy @ answers))
    left, strength, _ = np.linalg.svd(root.T @ (answers[r:] / size), full_matrices=False)
    count = int((strength > tolerance * np.sqrt(answers.shape[1])).sum())
    directions = basis[:, kept] / np.sqrt(values[kept]) @ left[:, :count]
    return inner @ directions, directions


def _symmetric(matrix: Real) -> Real:
    return np.asarray(0.5 * (matrix + matrix.T))


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
    """Operators on given vectors; their error is yet unmeasured."""
    p = Projector(full, vectors)
    with ThreadPoolExecutor(WORKERS) as executor:
        stacks: dict[str, Any] = {
            **plate_energies(p, executor, step),
            **patch_energies(p),
            **offset_energies(p, executor),
            **strains(p),
        }
    return EffectOperators(
        **stacks,
        capacitance=model.capacitance,
        points=places,
        deflection=probe[: len(places)] @ vectors,
        footprints=probe[len(places) :] @ vectors,
        box=box,
        band=band,
        error=float("inf"),
    )
