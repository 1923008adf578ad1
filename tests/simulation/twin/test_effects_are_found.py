"""Effects hidden in a campaign that the full plate makes, line by line, are found and named by the gap workflow.

The mesh is coarse and the same on both sides; what the search knows of the plate is its reduction.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from analysis.experiment import Attachment
from analysis.gap.gap import find_gap
from analysis.material import LocalLaws, Material, MaterialBox, MaterialSigma
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated
from simulation.effects.library import LIBRARY, library
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.shell.points import attached_discs, footprint_rows
from simulation.shell.rigidity import W
from simulation.shell.unknowns import factorize
from simulation.state.plate_state import Circumstances, PlateState
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

pytestmark = pytest.mark.slow  # half a minute for the plate, as long for each campaign

BAND = (100.0, 450.0)
LINES = np.linspace(*BAND, 141)
TEMPERATURES = np.array([5.0, 17.0, 29.0, 41.0, 53.0])
GAIN, NOISE = 12.0, 0.01
HIDDEN = {
    "mass_at_place": {"mass": 4e-4, "x": 0.163, "y": 0.052},
    "spring_at_place": {"stiffness": 600.0, "x": 0.09, "y": 0.13, "loss": 0.2},
    "poisson_loss": {"kappa": 0.7},
    "loss_orthotropy": {"delta_eta": 0.15, "delta_shear": -0.1},
    "elastic_foundation": {"stiffness": 3e5},
}


def local(temperature: float) -> LocalLaws:
    def laws(t: float) -> np.ndarray:
        step = t - 25.0
        softening = 0.018 * step + 0.1 * np.tanh((t - 10.0) / 12.0)
        return np.array([np.log(2e9) - softening, 0.37 + 0.0012 * step, np.log(0.06) + 0.004 * step])

    return LocalLaws(
        temperature, laws(temperature), laws(temperature + 0.5) - laws(temperature - 0.5), np.zeros(3)
    )


@pytest.fixture(scope="module")
def plate_and_twin(declare, three_patches, coarse_mesh):
    experiment = declare(three_patches, BAND)
    box = MaterialBox((0.8e9, 3.4e9), (0.32, 0.43), (0.03, 0.12))
    fineness, training = Fineness(coarse_mesh, degree=4, tolerance=1e-6), BasisTraining(tolerance=3e-4, lines=60)
    ops, full, _ = reduce_with_effects(experiment, box, fineness=fineness, training=training)
    known = tolerances(experiment, ops.movable)
    return full, Twin.of(experiment, EffectPlate(ops), library(experiment), known).referred(local(25.0))


def measured(full, twin, name, values) -> Frf:
    """FRFs of the full plate with an effect, both sensors connected, with noise."""
    rng, experiment = np.random.default_rng(0), twin.experiment
    inputs = experiment.acquisition
    rows = np.zeros((0, full.unknowns.size))
    if "x" in values:
        (disc,) = attached_discs(experiment.plate, [Attachment(point=(values["x"], values["y"]))])
        rows = full.unknowns.rows(footprint_rows(full.shell.space, [disc]), W).toarray()
    h = np.empty((TEMPERATURES.size, 2, LINES.size), complex)
    for t, temperature in enumerate(TEMPERATURES):
        laws = local(temperature)
        plain = PlateState.baseline(*full.sampling, laws, temperature, LINES)
        around = Circumstances.of(experiment, SweepPoint(temperature, 0.007, 1.0), LINES)
        state = LIBRARY[name].apply(plain, around, values) if name else plain
        m = full.matrices(state)
        z0 = m.plate + 1j * m.plate_loss + m.patches
        for k, f in enumerate(LINES):
            omega = 2.0 * np.pi * f
            z = z0 - omega**2 * m.mass + state.area_stiffness * m.normal
            answers = factorize(z).solve(np.hstack([m.coupling, rows.T]).astype(complex))
            for one in state.attached:
                d = one.stiffness[k] + 1j * one.loss[k]
                there = rows @ answers
                answers = answers - np.outer(answers[:, -1], there[0]) * d / (1.0 + d * there[0, -1])
            g = m.coupling.T @ answers[:, :3]
            across = twin.plate.capacitance[1:] + inputs.input_capacitance
            across = across + 1.0 / (1j * omega * inputs.input_resistance)
            h[t, :, k] = GAIN * np.linalg.solve(np.diag(across) + g[1:, 1:], -g[1:, 0])
    variance = np.broadcast_to(NOISE**2 * (np.abs(h) ** 2).mean(-1, keepdims=True), h.shape).copy()
    h = h + np.sqrt(0.5 * variance) * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape))
    flat = np.ones(TEMPERATURES.size)
    return Frf(
        temperature=TEMPERATURES,
        direction=("up",) * TEMPERATURES.size,
        level=flat,
        frequency=LINES,
        h=h,
        variance=variance,
        coherence=np.ones(h.shape),
        excluded=np.zeros(LINES.size, dtype=bool),
        channels=("S1", "S2"),
    )


def true_laws() -> Updated:
    nothing = np.zeros(TEMPERATURES.size)
    values = np.array([local(t).value for t in TEMPERATURES])
    return Updated(
        temperature=TEMPERATURES,
        material=Material(np.exp(values[:, 0]), values[:, 1], np.exp(values[:, 2])),
        sigma=MaterialSigma(nothing, nothing, nothing),
        correlation=np.zeros((nothing.size, 4, 4)),
        gain=GAIN,
        sigma_gain=0.0,
        misfit_start=nothing,
        misfit=nothing,
        noise_floor=nothing,
        chi2_per_dof=nothing,
        settled=np.ones(nothing.size, dtype=bool),
    )


def gap(full, twin, name, values):
    with ThreadPoolExecutor(1) as executor:
        frf = measured(full, twin, name, values)
        return find_gap(frf, true_laws(), twin, twin.experiment.protocol, executor)


@pytest.mark.parametrize("name", HIDDEN)
def test_what_is_hidden_is_named_with_its_parameters(name, plate_and_twin):
    found = gap(*plate_and_twin, name, HIDDEN[name])
    assert found.verdict == "explained"
    (effect,) = found.effects
    assert name in (effect.name, *effect.equivalent)
    if effect.name == name:
        for one in effect.parameters:
            assert abs(one.value - HIDDEN[name][one.name]) < 4.0 * one.sigma, one


def test_a_resonator_that_is_far_from_all_starts_is_not_taken_for_anything_else(plate_and_twin):
    values = {"mass": 3e-4, "x": 0.12, "y": 0.07, "resonance": 260.0, "loss": 0.06}
    found = gap(*plate_and_twin, "resonator_at_place", values)
    assert found.verdict == "unknown" or found.effects[0].name == "resonator_at_place"


def test_nothing_is_named_where_nothing_is_hidden(plate_and_twin):
    found = gap(*plate_and_twin, "", {})
    assert found.verdict == "none"
    assert not found.effects
