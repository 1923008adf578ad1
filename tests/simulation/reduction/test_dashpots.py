"""Dashpots of supports: against exact receptances, the full plate, and the balance of powers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from analysis.channel import Footprint
from analysis.experiment import Plate
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.library import library
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.reduction.modal_form import MOST_COLUMNS, columns, few_columns
from simulation.reduction.plate_basis import reduce_with_footprints
from simulation.reduction.reduced_model import lowest_modes
from simulation.shell.assembly import assemble
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.fineness import Fineness
from simulation.shell.points import footprint_points
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

LX, LY, H, RHO = 0.3, 0.22, 0.003, 1000.0
E, NU, ETA = 2e9, 0.35, 0.03
POINT, FORCE, SEEN, RADIUS, DAMPING = (0.11, 0.08), (0.19, 0.13), (0.07, 0.15), 0.004, 6.0
BOX = MaterialBox((1.5e9, 3e9), (0.33, 0.40), (0.02, 0.1))
BAND = (100.0, 500.0)
LINES = np.linspace(40.0, 600.0, 90)
EDGE = {"kind": "elastic", "edge": "left", "translation": 2e4, "damping": 90.0, "rotation_damping": 0.05}
SPOT = {"kind": "elastic", "point": (0.05, 0.14), "radius": 0.004, "damping": 12.0}
MATERIAL = (2.1e9, 0.372, 0.071)
CARD = ElectricLoad(305e3, 120e-12)


def simply_supported(points: list[tuple[float, float]], frequency: np.ndarray) -> np.ndarray:
    """Receptances (K, K, F) between discs of a hard simply supported Mindlin plate (Navier)."""
    count = 120
    m, n = (a.ravel() for a in np.meshgrid(np.arange(1, count), np.arange(1, count), indexing="ij"))
    k2 = (m * np.pi / LX) ** 2 + (n * np.pi / LY) ** 2
    complex_e = E * (1.0 + 1j * ETA)
    d, g = complex_e * H**3 / (12.0 * (1.0 - NU**2)), 5.0 / 6.0 * complex_e / (2.0 * (1.0 + NU)) * H
    s = (2 * np.pi * frequency[:, None]) ** 2
    # rotations along the gradient of w: two equations a mode
    inner = d * k2 + g - RHO * H**3 / 12.0 * s
    stiffness = g * k2 - RHO * H * s - (g**2 * k2) / inner
    x, y = footprint_points([Footprint(point, RADIUS) for point in points])[0].T[..., None]
    average = footprint_points([Footprint(point, RADIUS) for point in points])[1]
    shape = average @ (np.sin(m * np.pi * x / LX) * np.sin(n * np.pi * y / LY))
    return np.einsum("im,fm,jm->ijf", shape, 4.0 / (LX * LY) / stiffness, shape)


def test_a_dashpot_on_a_simply_supported_plate_against_the_modal_sum() -> None:
    """With one dashpot c at p, G_ab becomes G_ab - G_ap j w c G_pb / (1 + j w c G_pp)."""
    spot = {"kind": "elastic", "point": POINT, "radius": RADIUS, "damping": DAMPING}
    plate = Plate(
        length_x=LX,
        length_y=LY,
        thickness=H,
        mass=RHO * LX * LY * H,
        support=({"kind": "hard-simple", "edge": "all"}, spot),
    )
    recipe = MeshRecipe(spacing=0.05, edge_strip=3.0, growth=1.5, grading=0.0)
    model = assemble(plate, recipe=recipe, degree=6)
    discs = [Footprint(FORCE, RADIUS), Footprint(SEEN, RADIUS)]
    box = MaterialBox((E, E), (NU, NU), (0.02, 0.1))
    reduced = reduce_with_footprints(model, box, (40.0, 600.0), discs)[0]
    assert reduced.error < 1e-4
    exact = simply_supported([POINT, FORCE, SEEN], LINES)
    impedance = 2j * np.pi * LINES * DAMPING
    expected = exact[1:, 1:] - exact[1:, :1] * exact[:1, 1:] * impedance / (1.0 + impedance * exact[0, 0])
    assert np.abs(expected - exact[1:, 1:]).max() > 0.3 * np.abs(exact[1:, 1:]).max()
    modal = reduced.modal_form(E, NU, ETA)
    found = modal.compliance(reduced.footprints.T, reduced.footprints.T, LINES)
    assert np.abs(found - expected).max() < 2e-3 * np.abs(expected).max()


@pytest.fixture(scope="module")
def experiment(declare, patches):
    free = declare(patches, BAND)
    plate = Plate.model_validate({**free.plate.model_dump(), "support": (EDGE, SPOT)})
    return free.model_copy(update={"plate": plate})


@pytest.fixture(scope="module")
def model(experiment, coarse_mesh):
    return assemble(experiment.plate, experiment.patch, recipe=coarse_mesh, degree=4)


@pytest.fixture(scope="module")
def twin(model):
    return Twin(
        DeclaredPlate(reduce_with_footprints(model, BOX, BAND, ())[0]), Instruments.of_patches(0, (1,), CARD)
    )


def test_along_an_edge_the_reduced_plate_answers_like_the_full_one(model, twin):
    lines = np.array([120.0, 233.0, 477.0])
    full = model.frf(*MATERIAL, lines, actuator=0, sensors=(1,), load=CARD)
    undamped = replace(model, damping=0.0 * model.damping)
    without = undamped.frf(*MATERIAL, lines, actuator=0, sensors=(1,), load=CARD)
    rms = np.sqrt(np.mean(np.abs(full) ** 2))
    assert np.abs(twin.frf(LocalLaws.of_material(*MATERIAL), lines) - full).max() < 2e-4 * rms
    assert np.abs(without - full).max() > 0.1 * rms
    assert twin.plate.reduced.dashpots.shape[1] < 40


def test_power_in_is_power_out(model, twin):
    """Of the force b V, j w u* b V / 2 goes in; loss factor and dashpots take up w (eta u*Ku + w u*Cu) / 2."""
    lines = np.linspace(*BAND, 40)
    reduced = twin.plate.reduced
    u = reduced.amplitudes(*MATERIAL, lines, inputs=[0])[0]
    omega = 2 * np.pi * lines
    power = 0.5 * (1j * omega * (u.conj() @ -reduced.coupling[:, 0])).real
    lost = reduced.stiffness(*MATERIAL).imag
    hysteretic = 0.5 * omega * np.einsum("fr,rs,fs->f", u.conj(), lost, u).real
    viscous = 0.5 * omega**2 * (np.abs(u @ reduced.dashpots) ** 2).sum(axis=1)
    assert hysteretic + viscous == pytest.approx(-power, rel=1e-9)
    assert (viscous > 0.05 * -power).any()


@pytest.mark.parametrize("index", [0, 1, 2])
def test_sensitivities_equal_central_differences(twin, index):
    lines = np.linspace(*BAND, 120)
    step = 2e-4 * MATERIAL[index]

    def central(size):
        up, down = list(MATERIAL), list(MATERIAL)
        up[index] += size
        down[index] -= size
        one, other = (twin.frf(LocalLaws.of_material(*there), lines) for there in (up, down))
        return (one - other) / (2 * size)

    twin = replace(twin, reach=np.inf)
    slopes = twin.linearise(LocalLaws.of_material(*MATERIAL), lines).by_material[index]
    slopes = slopes / (MATERIAL[index] if index != 1 else 1.0)
    expected = (4 * central(step) - central(2 * step)) / 3
    assert np.abs(slopes - expected).max() < 1e-6 * np.abs(expected).max()


def test_temperature_acts_through_the_laws(experiment, twin):
    """Away from their reference, curved, and on a plate that grows with temperature."""
    lines, away = np.linspace(*BAND, 120), SweepPoint(31.0, 0.0, 1.0)
    value = np.array([np.log(MATERIAL[0]), MATERIAL[1], np.log(MATERIAL[2])])
    laws = LocalLaws(24.0, value, np.array([-0.02, 0.001, 0.03]), np.array([3e-4, 1e-4, -2e-3]))
    plate = experiment.plate.model_copy(update={"dimensions_at": 20.0, "expansion": 1e-4})
    twin = replace(twin, reach=np.inf, experiment=experiment.model_copy(update={"plate": plate}))

    def central(size):
        one, other = (twin.frf(laws, lines, point=replace(away, temperature=31.0 + s)) for s in (size, -size))
        return (one - other) / (2 * size)

    found = twin.linearise(laws, lines, point=away).by_temperature
    expected = (4 * central(1e-2) - central(2e-2)) / 3
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_damped_poles_are_singular_points(twin):
    """At a pole p, K - p + j sqrt(p) C has no inverse; dashpots add to the loss of every mode they move."""
    reduced = twin.plate.reduced
    modal = reduced.modal_form(*MATERIAL)
    damping = reduced.dashpots @ reduced.dashpots.T
    poles = modal.damped_poles()
    for pole in poles[:6]:
        z = reduced.stiffness(*MATERIAL) - pole * np.eye(reduced.size) + 1j * np.sqrt(pole) * damping
        values = np.linalg.svd(z, compute_uv=False)
        assert values[-1] < 1e-9 * values[0]
    loss = poles.imag / poles.real
    assert loss[poles.real < (2 * np.pi * BAND[1]) ** 2].max() > 1.3 * MATERIAL[2]
    values, _ = lowest_modes(reduced, *MATERIAL, 12)
    elastic = values[values.real > (2 * np.pi * 60.0) ** 2]
    assert (elastic.imag / elastic.real).max() > 1.3 * MATERIAL[2]


@pytest.mark.slow
def test_the_twin_with_effects_has_the_same_dashpots(experiment, model, coarse_mesh):
    ops, _, _ = reduce_with_effects(experiment, BOX, fineness=Fineness(coarse_mesh, degree=4, tolerance=0.0))
    assert ops.error < 1e-3
    with_effects = Twin.of(experiment, EffectPlate(ops), library(experiment))
    lines = np.array([120.0, 233.0, 477.0])
    laws = LocalLaws.of_material(*MATERIAL)
    found = with_effects.frf(laws, lines, point=SweepPoint(laws.reference, 0.0, 1.0))
    expected = model.frf(*MATERIAL, lines, actuator=0, sensors=(1,), load=CARD)
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()
    # a dashpot of an effect, where one of the supports stands already, adds to it
    on = {"suspension": {"stiffness": 0.0, "damping": 5.0}}
    point = SweepPoint(laws.reference, 0.0, 1.0)
    line = with_effects.linearise(laws, lines, on, point, [("suspension", "damping", {})])
    up, down = (
        with_effects.frf(laws, lines, {"suspension": {"stiffness": 0.0, "damping": 5.0 + s}}, point)
        for s in (1e-3, -1e-3)
    )
    assert np.abs(line.by_parameter[0] - (up - down) / 2e-3).max() < 1e-4 * np.abs(line.by_parameter[0]).max()


def test_columns_give_the_damping_back():
    rng = np.random.default_rng(1)
    root = rng.standard_normal((30, 4))
    damping, answers = root @ root.T, rng.standard_normal((30, 9))
    found = columns(damping, answers)
    assert found.shape == (30, 4)
    assert found @ found.T == pytest.approx(damping)
    assert columns(np.zeros((30, 30)), answers).shape == (30, 0)


def test_dashpots_at_points_have_a_column_each(declare, patches, coarse_mesh):
    spots = (SPOT, {**SPOT, "point": (0.2, 0.1), "damping": 3.0})
    free = declare(patches, BAND)
    plate = Plate.model_validate({**free.plate.model_dump(), "support": spots})
    model = assemble(plate, free.patch, recipe=coarse_mesh, degree=4)
    found = few_columns(model.damping)
    assert found is not None
    assert found.shape == (model.size, 2)
    assert np.abs(found @ found.T - model.damping.toarray()).max() < 1e-6 * np.abs(model.damping).max()


def test_many_dashpots_have_no_few_columns(model):
    assert few_columns(model.damping) is None
    assert few_columns(csr_matrix((5, 5))).shape == (5, 0)
    assert few_columns(csr_matrix(np.eye(MOST_COLUMNS + 1))) is None
