"""The self-consistent strain energy: of one mode, whose equation is a cubic, and of a plate solved directly."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

from analysis.effect_card import EffectCard, Parameter
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.effect import Effect
from simulation.effects.library import library
from simulation.reduction.composition import Coefficients, Composite, composed
from simulation.reduction.effect_operators import EffectOperators
from simulation.reduction.effect_reduction import project
from simulation.state.plate_state import PlateState
from simulation.state.state_matrices import FullPlate
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.local_plate import LocalPlate
from simulation.twin.strain_energy import StrainEnergy
from simulation.twin.twin import Twin

BAND = (100.0, 700.0)
LINES = np.linspace(*BAND, 61)
POINT = SweepPoint(40.0, 0.01, 2.0)
LAWS = LocalLaws.of_material(2e9, 0.38, 0.06, reference=40.0, slope=(-0.02, 0.002, -0.01))
SOFT = {"amplitude_softening": {"a": 0.02, "b": 0.05}}
SHAPES = {"softening": 0.03, "x": 0.11, "y": 0.08}
RESONANCE, LOSS = 300.0, 0.05


def one_mode(force: float, a: float, b: float, lines: np.ndarray) -> StrainEnergy:
    """Energy of a spring with loss and a mass of 1 kg, peak 1 at a force of 1 where nothing follows it."""
    stiffness = (2 * np.pi * RESONANCE) ** 2
    k, zero = np.array([[stiffness]]), np.zeros((1, 1))
    local = Composite(k, LOSS * k, zero, np.ones((1, 1)), np.array([[force * LOSS * np.sqrt(2.0 * stiffness)]]))
    laws = LocalLaws.of_material(2e9, 0.38, LOSS)
    state = PlateState.baseline(np.zeros(1), np.zeros(1), laws, 20.0, lines)

    def softened(energy):
        kept = 1.0 - a * energy
        return state.with_(storage=kept, loss=kept + b * energy)

    undamped = cast(EffectOperators, SimpleNamespace(damping=zero))
    plate = LocalPlate(np.eye(1), local, zero, undamped)
    return StrainEnergy.of(plate, 0, softened, lines)


@pytest.mark.parametrize(
    ("force", "a", "b", "bends_over"),
    [(0.5, 0.02, 0.05, False), (1.0, 0.1, 0.0, True), (1.3, 0.15, 0.1, True), (2.0, 0.1, 0.3, True)],
)
def test_one_mode_takes_the_lowest_root_of_its_cubic(force: float, a: float, b: float, bends_over: bool) -> None:
    """It is e |s - q + j eta l|**2 = (eta force)**2 s, s = 1 - a e, l = s + b e, q the frequency ratio squared."""
    lines = np.linspace(0.7, 1.2, 251) * RESONANCE
    found = one_mode(force, a, b, lines).settled()
    several = 0
    for f, e in zip(lines, found, strict=True):
        q = (f / RESONANCE) ** 2
        s, lossy = np.polynomial.Polynomial([1.0, -a]), np.polynomial.Polynomial([1.0, b - a])
        cubic = np.polynomial.Polynomial([0.0, 1.0]) * ((s - q) ** 2 + LOSS**2 * lossy**2) - LOSS**2 * force**2 * s
        roots = cubic.roots()
        real = np.sort(roots.real[(np.abs(roots.imag) < 1e-7) & (roots.real > 0.0) & (roots.real < 1.0 / a)])
        several += real.size > 1
        assert e == pytest.approx(real[0], rel=1e-8), f
    assert (several > 0) is bends_over


@pytest.fixture(scope="module")
def twin(declare, three_patches, coarse_model) -> Twin[EffectPlate]:
    """Modes of one material and no more, every effect available, energies counted from 25 degrees Celsius."""
    experiment = declare(three_patches, BAND)
    full = FullPlate.of(coarse_model)
    places = np.array([attached.point for attached in experiment.attachments])
    probe = np.asarray(coarse_model.deflection(places).todense())
    energy = coarse_model.stiffness(2e9, 0.38) + (2 * np.pi * 300.0) ** 2 * coarse_model.mass
    start = np.random.default_rng(0).standard_normal(coarse_model.size)
    _, vectors = eigsh(energy, 40, coarse_model.mass, sigma=0.0, v0=start)
    box = MaterialBox((1e9, 3.2e9), (0.33, 0.46), (0.02, 0.12))
    ops = project(full, vectors, coarse_model, places, probe, box, BAND, lambda: None)
    known = {**library(experiment), "warmed_air": WARMED_AIR}
    return replace(Twin.of(experiment, EffectPlate(ops), known), reach=np.inf).referred(LAWS)


def _warmed_air(state, circumstances, values):
    """Heavier, more damped and quieter where the plate moves more: what an effect of a user may do, too."""
    much = values["weight"] * circumstances.strain_energy / (1.0 + circumstances.strain_energy)
    return state.with_(
        area_mass=state.area_mass + much,
        area_resistance=state.area_resistance + 300.0 * much,
        log_gain=state.log_gain - 0.3 * much,
    )


WARMED_AIR = Effect(
    lambda _: EffectCard("warmed_air", "", (Parameter("weight", "kg/m2", 0.0, 1.0, 0.1),), "two levels", ""),
    _warmed_air,
    needs_strain_energy=True,
)


def values_of(twin: Twin[EffectPlate], name: str) -> dict[str, float]:
    return {p.name: SHAPES[p.name] if p.shape else 0.3 * p.sigma for p in twin.cards[name].parameters}


def stored(twin: Twin[EffectPlate], state: PlateState, lines: np.ndarray) -> np.ndarray:
    """u^H K u / 2 per volt on the actuator, K as softened, each line factorized."""
    ops = twin.plate.operators
    whole = composed(ops, Coefficients.of(state, ops))
    rows = [ops.deflection[np.abs(ops.points - load.point).sum(1).argmin()] for load in state.point_loads]
    energies = np.zeros(lines.size)
    for k, omega in enumerate(2 * np.pi * lines):
        z = state.storage[k] * whole.plate + 1j * state.loss[k] * whole.plate_loss + whole.fixed
        z = (
            z
            - omega**2 * (whole.mass + state.area_mass[k] * ops.normal)
            + 1j * omega * state.area_resistance[k] * ops.normal
        )
        for load, row in zip(state.point_loads, rows, strict=True):
            z = z + (load.stiffness + 1j * omega * load.damping - omega**2 * load.mass) * np.outer(row, row)
        u = np.linalg.solve(z, whole.coupling[:, 0])
        energies[k] = 0.5 * state.storage[k] * (u.conj() @ whole.plate @ u).real
    return energies


def test_the_reference_is_the_largest_energy_at_25_degrees(twin: Twin[EffectPlate]) -> None:
    lines = np.linspace(*BAND, 6001)
    state = twin.state(LAWS, lines, point=SweepPoint(25.0, 0.0, 1.0))
    assert twin.peak_energy == pytest.approx(stored(twin, state, lines).max(), rel=1e-4)


@pytest.mark.parametrize(
    "others",
    [
        {},
        {"point_mass": {"mass": 0.002}, "damping_dispersion": {"p": 0.2}},
        {"orthotropy": {"delta_e": 0.05, "delta_g": 0.02}, "suspension": {"stiffness": 100.0, "damping": 0.5}},
        {"air_loading": {"added_mass_factor": 1.0, "radiation_factor": 1.0}, "warmed_air": {"weight": 0.05}},
    ],
)
def test_every_line_is_the_fixed_point_that_plain_iteration_finds(twin: Twin[EffectPlate], others) -> None:
    lines = LINES[::4]
    on = {**others, **SOFT}
    energy = np.zeros(lines.size)
    for _ in range(400):  # damped, from the linear plate on
        there = 4.0 * stored(twin, twin.states.at(POINT, LAWS, on, lines, energy), lines) / twin.peak_energy
        energy = energy + 0.5 * (there - energy)
    assert np.abs(there - energy).max() < 1e-10
    assert energy.max() > 0.3
    wanted = twin.states.at(POINT, LAWS, on, lines, energy)
    found = twin.state(LAWS, lines, on, POINT)
    np.testing.assert_allclose(found.storage, wanted.storage, rtol=1e-9)
    np.testing.assert_allclose(found.loss, wanted.loss, rtol=1e-9)
    np.testing.assert_allclose(found.area_mass, wanted.area_mass, rtol=1e-9)


def test_beyond_the_cap_of_four_a_line_is_a_linear_plate(twin: Twin[EffectPlate]) -> None:
    loud = replace(POINT, level=1e4)
    values = SOFT["amplitude_softening"]
    state = twin.state(LAWS, LINES, SOFT, loud)
    np.testing.assert_allclose(state.storage, 1.0 - 4.0 * values["a"], rtol=1e-14)
    np.testing.assert_allclose(state.loss, 1.0 - 4.0 * values["a"] + 4.0 * values["b"], rtol=1e-14)


@pytest.mark.parametrize("follows", ["amplitude_softening", "warmed_air"])
def test_derivatives_follow_the_energy_with_every_other_effect_on(twin: Twin[EffectPlate], follows: str) -> None:
    names = ["orthotropy", "thermal_gradient", "thickness_taper", "thermal_lag", "suspension", "point_mass"]
    names += ["bond_shear_lag", "damping_dispersion", "air_loading", "local_damage", "sensor_offset", "high_pass"]
    on = {name: values_of(twin, name) for name in [*names, follows]}
    lines = LINES[::3]
    wanted = [(name, p, {}) for name, values in on.items() for p in values]
    line = twin.linearise(LAWS, lines, on, POINT, wanted)

    def check(found, at, step: float) -> None:
        one, other, two, third = (at(k * step) for k in (1, -1, 2, -2))
        quotient = (8.0 * (one - other) - (two - third)) / (12.0 * step)
        assert np.abs(found - quotient).max() < 2e-6 * np.abs(quotient).max() + 1e-10 * np.abs(one).max() / step

    for (name, p, _), found in zip(wanted, line.by_parameter, strict=True):
        sigma = {q.name: q.sigma for q in twin.cards[name].parameters}[p]

        def moved(d: float, name: str = name, p: str = p):
            return twin.frf(LAWS, lines, {**on, name: {**on[name], p: on[name][p] + d}}, POINT)

        share = 3e-4 if name == "amplitude_softening" else 3e-3  # a line close to bending over is sharply curved
        check(found, moved, 2e-5 if name == "local_damage" and p in "xy" else share * sigma)
    for law in range(3):
        unit = np.eye(3)[law]
        check(
            line.by_material[law],
            lambda d, unit=unit: twin.frf(replace(LAWS, value=LAWS.value + d * unit), lines, on, POINT),
            1e-4,
        )
        check(
            line.by_slope[law],
            lambda d, unit=unit: twin.frf(LAWS.tilted(d * unit, 0.0 * unit, POINT.temperature), lines, on, POINT),
            1e-4,
        )
        check(
            line.by_curvature[law],
            lambda d, unit=unit: twin.frf(LAWS.tilted(0.0 * unit, d * unit, POINT.temperature), lines, on, POINT),
            1e-4,
        )
    check(
        line.by_temperature,
        lambda d: twin.frf(LAWS, lines, on, replace(POINT, temperature=POINT.temperature + d)),
        1e-2,
    )


def test_an_effect_that_is_not_on_yet_is_tried_at_the_linear_energy(twin: Twin[EffectPlate]) -> None:
    absent = {"a": 0.0, "b": 0.0}
    mass = {"point_mass": {"mass": 0.002}}
    line = twin.linearise(LAWS, LINES, mass, POINT, [("amplitude_softening", p, absent) for p in absent])
    for p, found in zip(absent, line.by_parameter, strict=True):
        one, two = (
            twin.frf(LAWS, LINES, {**mass, "amplitude_softening": {**absent, p: d}}, POINT) for d in (1e-5, 2e-5)
        )
        quotient = (4.0 * one - two - 3.0 * line.transfer) / 2e-5
        assert np.abs(found - quotient).max() < 1e-5 * np.abs(quotient).max()
    plain = twin.linearise(LAWS, LINES, mass, POINT)
    np.testing.assert_allclose(line.by_material, plain.by_material, rtol=1e-12)


def test_energies_are_counted_by_the_laws_that_a_fit_has_come_to(twin: Twin[EffectPlate]) -> None:
    lossier = replace(LAWS, value=LAWS.value + np.array([0.0, 0.0, 0.1]))
    away = replace(LAWS, reference=60.0, slope=np.zeros(3))
    found = twin.counted([away, lossier], ["point_mass", "amplitude_softening"])
    assert found.peak_energy == twin.referred(lossier).peak_energy
    assert twin.peak_energy is not None
    assert found.peak_energy < 0.9 * twin.peak_energy
    assert twin.counted([away, lossier], ["point_mass"]) is twin


def test_an_energy_without_reference_is_refused(twin: Twin[EffectPlate]) -> None:
    with pytest.raises(ValueError, match="call `referred` first"):
        replace(twin, peak_energy=None).frf(LAWS, LINES, SOFT, POINT)
