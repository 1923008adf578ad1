"""Effects whose answer is known, on a plate reduced to its lowest modes: what is exact on any coordinates."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.library import library
from simulation.reduction.composition import Coefficients, composed
from simulation.reduction.effect_reduction import project
from simulation.state.plate_state import PointLoad
from simulation.state.state_matrices import FullPlate
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.local_solution import LocalSolution
from simulation.twin.twin import Twin

BAND = (100.0, 700.0)
LINES = np.linspace(*BAND, 61)
POINT = SweepPoint(40.0, 0.01, 1.0)
LAWS = LocalLaws.of_material(2e9, 0.38, 0.06, reference=40.0, slope=(-0.02, 0.002, -0.01))


@pytest.fixture(scope="module")
def twin(declare, three_patches, coarse_model) -> Twin[EffectPlate]:
    """Modes of one material and the static answers to patches and points; two sensors, every effect available."""
    experiment = declare(three_patches, BAND)
    full = FullPlate.of(coarse_model)
    places = np.array([attached.point for attached in experiment.attachments])
    probe = np.asarray(coarse_model.deflection(places).todense())
    energy = coarse_model.stiffness(2e9, 0.38) + (2 * np.pi * 300.0) ** 2 * coarse_model.mass
    start = np.random.default_rng(0).standard_normal(coarse_model.size)
    _, vectors = eigsh(energy, 40, coarse_model.mass, sigma=0.0, v0=start)
    box = MaterialBox((1e9, 3.2e9), (0.33, 0.46), (0.02, 0.12))
    ops = project(full, vectors, coarse_model, places, probe, box, BAND, lambda: None)
    return replace(Twin.of(experiment, EffectPlate(ops), library(experiment)), reach=np.inf).referred(LAWS)


def frf(twin, effects, lines=LINES, laws=LAWS, point=POINT):
    return twin.frf(laws, lines, effects, point)


@pytest.fixture(scope="module")
def plain(twin):
    return frf(twin, {})


def test_zero_is_nothing_to_the_last_bits(twin, plain):
    """All effects at once, every amplitude zero, shapes anywhere."""
    absent = {name: card.zero(card.sites[0]) for name, card in twin.cards.items()}
    for name, values in absent.items():
        assert np.abs(frf(twin, {name: values}) - plain).max() < 1e-12 * np.abs(plain).max(), name


def test_factors_on_the_signals_are_exact(twin, plain):
    omega = 2 * np.pi * LINES
    for effects, factor in (
        ({"channel_skew": {"delay": 8e-5}}, np.exp(-8e-5j * omega)),
        ({"high_pass": {"corner": 25.0}}, 1j * LINES / (1j * LINES + 25.0)),
        ({"piezo_drift": {"alpha": 0.002}}, 1.0 + 0.002 * 15.0),
    ):
        np.testing.assert_allclose(frf(twin, effects), plain * factor, rtol=1e-12)
    np.testing.assert_allclose(frf(twin, {"feedthrough": {"gain": 0.004}}) - plain, 0.004, rtol=1e-11)


def test_factors_multiply_and_the_feedthrough_comes_last(twin, plain):
    together = {"channel_skew": {"delay": 8e-5}, "piezo_drift": {"alpha": 0.002}, "feedthrough": {"gain": 0.004}}
    expected = plain * np.exp(-8e-5j * 2 * np.pi * LINES) * 1.03 + 0.004
    np.testing.assert_allclose(frf(twin, together), expected, rtol=1e-12)


@pytest.mark.parametrize("f", [150.0, 320.0, 640.0])
def test_air_is_a_heavier_plate_at_one_frequency(twin, f):
    """Per area, on normal motion: as if W, the integral of w**2, times m_a joined the mass."""
    line = np.array([f])
    effects = {"air_loading": {"added_mass_factor": 1.5, "radiation_factor": 0.0}}
    state = twin.state(LAWS, line, effects, POINT)
    ops = twin.plate.operators
    whole = composed(ops, Coefficients.of(state, ops))
    heavier = replace(whole, mass=whole.mass + state.area_mass[0] * ops.normal)
    bare = state.with_(area_mass=np.zeros(1))
    wanted = LocalSolution.of(ops, heavier, bare, line, np.inf).compliance()
    found = LocalSolution.of(ops, whole, state, line, np.inf).compliance()
    np.testing.assert_allclose(found, wanted, rtol=1e-8)
    assert (
        np.abs(found - LocalSolution.of(ops, whole, bare, line, np.inf).compliance()).max()
        > 1e-3 * np.abs(found).max()
    )


@pytest.mark.parametrize("kind", ["mass", "stiffness"])
def test_a_light_load_shifts_a_mode_as_rayleighs_quotient_says(twin, kind):
    """Eigenvalue s: a mass m at p takes s m w(p)**2 off, a spring k adds k w(p)**2, w the mode of mass one."""
    ops = twin.plate.operators
    state = twin.state(LAWS, LINES, {}, POINT)
    whole = composed(ops, Coefficients.of(state, ops))

    def modes(loads):
        local = LocalSolution.of(ops, whole, state.with_(point_loads=loads), LINES[:2], np.inf)
        stiffness = local.composite.plate + local.composite.fixed
        root = np.linalg.inv(np.linalg.cholesky(local.composite.mass))
        squares, shapes = np.linalg.eigh(root @ stiffness @ root.T)
        return squares, local.basis @ (root.T @ shapes)

    squares, shapes = modes(())
    there = ops.deflection[0] @ shapes
    elastic = np.flatnonzero(squares > (2 * np.pi * 50.0) ** 2)
    antinode = elastic[np.abs(there[elastic[:8]]).argmax()]
    size = 1e-6 if kind == "mass" else 1.0
    moved, _ = modes((PointLoad(twin.experiment.string[0].point, **{kind: size}),))
    change = moved[antinode] - squares[antinode]
    quotient = -squares[antinode] * size * there[antinode] ** 2 if kind == "mass" else size * there[antinode] ** 2
    assert change == pytest.approx(quotient, rel=2e-3)
    node = elastic[np.abs(there[elastic[:8]]).argmin()]
    assert abs(moved[node] / squares[node] - 1.0) < abs(moved[antinode] / squares[antinode] - 1.0)


def test_a_stiff_dashpot_holds_a_point_as_a_stiff_spring_does(twin):
    """A dashpot c at angular frequency w is a spring j w c."""
    line = np.array([333.0])
    dashpot = frf(twin, {"suspension": {"stiffness": 0.0, "damping": 10.0}}, line)
    ops, state = twin.plate.operators, twin.state(LAWS, line, {}, POINT)
    whole = composed(ops, Coefficients.of(state, ops))
    solved = LocalSolution.of(ops, whole, state, line, np.inf)
    row = ops.deflection[0] @ solved.basis
    z = whole.plate + 1j * whole.plate_loss + whole.fixed - (2 * np.pi * 333.0) ** 2 * whole.mass
    z = solved.basis.T @ z @ solved.basis + 10.0j * 2 * np.pi * 333.0 * np.outer(row, row)
    coupling = solved.composite.coupling
    g = coupling.T @ np.linalg.solve(z, coupling)
    load = twin.experiment.acquisition
    across = ops.capacitance[1:] + load.input_capacitance + 1.0 / (2j * np.pi * 333.0 * load.input_resistance)
    wanted = np.linalg.solve(np.diag(across) + g[1:, 1:], -g[1:, 0])
    np.testing.assert_allclose(dashpot[:, 0], wanted, rtol=1e-9)


def test_orthotropy_at_once_along_both_axes_is_another_isotropic_plate(twin, plain):
    """With E_x = E_y = f E and the shear modulus times f it is f E, but for the little of transverse shear."""
    state = twin.state(LAWS, LINES, {}, POINT).with_(modulus_x=1.05, modulus_y=1.05, in_plane_shear=1.05)
    ops = twin.plate.operators
    whole = composed(ops, Coefficients.of(state, ops))
    found = LocalSolution.of(ops, whole, state, LINES, np.inf).compliance()
    stiffer = twin.state(replace(LAWS, value=LAWS.value + np.array([np.log(1.05), 0.0, 0.0])), LINES, {}, POINT)
    other = composed(ops, Coefficients.of(stiffer, ops))
    wanted, before = (
        LocalSolution.of(ops, c, s, LINES, np.inf).compliance()
        for c, s in ((other, stiffer), (composed(ops, Coefficients.of(_plain(twin), ops)), _plain(twin)))
    )
    assert np.abs(found - wanted).max() < 0.1 * np.abs(before - wanted).max()


def _plain(twin):
    return twin.state(LAWS, LINES, {}, POINT)


def test_softening_is_another_material_at_each_line_and_counts_the_level_twice(twin, plain):
    values = {"amplitude_softening": {"a": 0.02, "b": 0.05}}
    quiet = frf(twin, values, point=replace(POINT, level=1e-4))
    assert np.abs(quiet - plain).max() < 1e-7 * np.abs(plain).max()
    once, twice = (twin.state(LAWS, LINES, values, replace(POINT, level=level)) for level in (0.001, 0.002))
    assert 1.0 - twice.storage == pytest.approx(4.0 * (1.0 - once.storage), rel=1e-5)
    once = twin.state(LAWS, LINES, values, replace(POINT, level=0.5))
    index = int(np.argmin(once.storage))
    line = LINES[[index]]
    lost = once.storage[index] * LAWS.youngs_modulus(40.0)
    eta = LAWS.loss_factor(40.0) * once.loss[index] / once.storage[index]
    laws = replace(LAWS, value=np.array([np.log(lost), 0.38, np.log(eta)]))
    found = frf(twin, values, point=replace(POINT, level=0.5))[:, [index]]
    np.testing.assert_allclose(found, frf(twin, {}, line, laws), rtol=1e-9)


def changed(ops, **attributes):
    """Change the plate's numbers: the same plate with other operators."""
    return EffectPlate(replace(ops, **attributes))


def test_a_permittivity_that_drifts_is_another_capacitance(twin):
    at_40 = replace(twin, plate=changed(twin.plate.operators, capacitance=1.06 * twin.plate.capacitance))
    drifting = frf(twin, {"permittivity_drift": {"beta": 0.004}})
    np.testing.assert_allclose(drifting, frf(at_40, {}), rtol=1e-12)


def test_a_leak_is_another_input(twin):
    inputs = twin.experiment.acquisition.model_copy(update={"input_resistance": 305e3 / 1.2})
    other = Twin.of(twin.experiment.model_copy(update={"acquisition": inputs}), twin.plate, twin.library)
    leaking = frf(twin, {"insulation_leak": {"leak25": 0.1, "growth": np.log(2.0) / 15.0}})
    np.testing.assert_allclose(leaking, frf(replace(other, reach=np.inf), {}), rtol=1e-12)
    assert np.abs(np.angle(leaking[0, 0] / frf(twin, {})[0, 0])) > 0.01


def test_crosstalk_is_added_in_quadrature(twin, plain):
    added = frf(twin, {"crosstalk": {"gain": 0.004}}) - plain
    np.testing.assert_allclose(added, np.tile(0.004j * LINES / 500.0, (2, 1)), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("kappa", [0.5, 1.0])
def test_a_lossless_bulk_is_a_complex_poissons_ratio_of_the_whole_stiffness(twin, kappa):
    """K(E (1 + j eta), nu - j x) = K + j (eta K - x dK/dnu) to first order, dK/dnu at a given E by differences."""
    ops, step = twin.plate.operators, 1e-5

    def matrices(effects, ratio=0.0):
        laws = replace(LAWS, value=LAWS.value + np.array([0.0, ratio, 0.0]))
        state = twin.state(laws, LINES, effects, POINT)
        return composed(ops, Coefficients.of(state, ops))

    slope = (matrices({}, step).plate - matrices({}, -step).plate) / (2.0 * step)
    wanted = 0.06 * (matrices({}).plate - kappa * (0.5 - 0.38) * slope)
    found = matrices({"poisson_loss": {"kappa": kappa}}).plate_loss
    assert np.abs(found - wanted).max() < 1e-7 * np.abs(wanted).max()
    assert np.abs(matrices({}).plate_loss - wanted).max() > 1e-3 * np.abs(wanted).max()


def test_losses_by_direction_are_those_of_another_orthotropy(twin):
    """The imaginary part of the stiffness is a stiffness with moduli times their loss factors."""
    ops = twin.plate.operators
    values = {"loss_orthotropy": {"delta_eta": 0.1, "delta_shear": 0.2}}
    lossy, plain = (composed(ops, Coefficients.of(twin.state(LAWS, LINES, e, POINT), ops)) for e in (values, {}))
    along = twin.state(LAWS, LINES, {}, POINT).with_(modulus_x=0.9, modulus_y=1.1, in_plane_shear=1.2)
    other = composed(ops, Coefficients.of(along, ops)).plate
    cross = np.tensordot(Coefficients.of(along, ops).bending[2], ops.bending[2], 1)
    cross = cross + np.tensordot(Coefficients.of(along, ops).membrane[2], ops.membrane[2], 1)
    mended = other + (1.0 / np.sqrt(0.99) - 1.0) * cross  # Q12 keeps the mean of both losses, not their root
    shear = np.tensordot(
        Coefficients.of(along, ops).shear, ops.shear, 2
    )  # transverse shear loses as much in shear
    np.testing.assert_allclose(lossy.plate_loss, 0.06 * (mended + 0.2 * shear), atol=1e-9 * np.abs(other).max())
    np.testing.assert_array_equal(lossy.plate, plain.plate)


@pytest.mark.parametrize("f", [150.0, 640.0])
def test_a_foundation_is_a_negative_mass_and_friction_an_imaginary_one(twin, f):
    """At one frequency both add a multiple of W, the integral of w**2, to the stiffness."""
    line, omega = np.array([f]), 2.0 * np.pi * f
    ops = twin.plate.operators
    state = twin.state(LAWS, line, {}, POINT)
    whole = composed(ops, Coefficients.of(state, ops))
    for effects, added in (
        ({"elastic_foundation": {"stiffness": 2e6}}, 2e6),
        ({"surface_damping": {"resistance": 60.0}}, 60j * omega),
        ({"elastic_foundation": {"stiffness": 2e6}, "surface_damping": {"resistance": 60.0}}, 2e6 + 60j * omega),
    ):
        z = whole.plate + 1j * whole.plate_loss + whole.fixed + added * ops.normal - omega**2 * whole.mass
        wanted = whole.coupling.T @ np.linalg.solve(z, whole.coupling)
        there = twin.state(LAWS, line, effects, POINT)
        found = LocalSolution.of(ops, whole, there, line, np.inf).compliance()[..., 0]
        np.testing.assert_allclose(found, wanted, rtol=1e-8)


def test_a_foundation_lifts_a_rigid_plate_to_its_bounce(twin):
    """A free plate moves as a whole at w**2 = k/(mass per area), patches' mass aside."""
    ops = twin.plate.operators
    state = twin.state(LAWS, LINES, {"elastic_foundation": {"stiffness": 2e5}}, POINT)
    whole = composed(ops, Coefficients.of(state, ops))
    solved = LocalSolution.of(ops, whole, state, LINES[:2], np.inf)
    local = solved.composite
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(local.mass, local.plate + local.fixed)).real)
    plate, ceramic = twin.experiment.plate, 3 * 7800.0 * 0.02**2 * 0.0005
    bounce = 2e5 * plate.area / (plate.mass + ceramic)
    lifted = squares[3:6]  # the first three move in the plane
    assert np.abs(lifted / bounce - 1.0).min() < 0.01


def test_patches_that_come_off_and_lose(twin):
    """All off by one share take that share of all that they add; what is lost is lost off the mid-plane."""
    ops = twin.plate.operators
    plain, off, single, lossy = (
        composed(ops, Coefficients.of(twin.state(LAWS, LINES, values, POINT), ops))
        for values in (
            {},
            {"patch_debond": {"A1": 0.3, "S1": 0.3, "S2": 0.3}},
            {"patch_debond": {"A1": 0.3, "S1": 0.0, "S2": 0.1}},
            {"patch_loss": {"eta": 0.04}},
        )
    )
    scale = np.abs(plain.fixed).max()
    np.testing.assert_allclose(off.fixed, 0.7 * plain.fixed, atol=1e-9 * scale)
    np.testing.assert_allclose(off.coupling, 0.7 * plain.coupling, rtol=1e-12)
    np.testing.assert_allclose(single.coupling, plain.coupling * [0.7, 1.0, 0.9], rtol=1e-12)
    np.testing.assert_array_equal(off.mass, plain.mass)
    layers = plain.fixed - ops.patch_own
    np.testing.assert_allclose(lossy.plate_loss - plain.plate_loss, 0.04 * layers, atol=1e-9 * scale)
    np.testing.assert_array_equal(lossy.fixed, plain.fixed)


def test_all_moduli_times_a_factor_and_all_mass_times_a_factor(twin):
    """A uniform factor on the modulus field is another E; on the density, another mass of the plate."""
    ops, state = twin.plate.operators, twin.state(LAWS, LINES, {}, POINT)
    softer = composed(ops, Coefficients.of(state.with_(modulus=0.9 * state.modulus), ops))
    laws = replace(LAWS, value=LAWS.value + np.array([np.log(0.9), 0.0, 0.0]))
    other = composed(ops, Coefficients.of(twin.state(laws, LINES, {}, POINT), ops))
    np.testing.assert_allclose(softer.plate, other.plate, rtol=1e-9, atol=1e-12 * np.abs(other.plate).max())
    heavier = composed(ops, Coefficients.of(state.with_(density=1.1 * state.density), ops))
    bare = ops.mass[0] + ops.rotary[0]
    np.testing.assert_allclose(heavier.mass, other.mass + 0.1 * bare, atol=1e-12)
