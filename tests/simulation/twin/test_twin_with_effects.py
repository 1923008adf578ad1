"""The twin with effects on a coarsely meshed plate: derivatives, known answers, and the full plate."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.experiment import Attachment
from analysis.material import LocalLaws, MaterialBox
from analysis.protocol.sweep import SweepTiming
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects.library import LIBRARY, library
from simulation.reduction.effect_certification import (
    CERTIFIED_LINES,
    STEEPEST_SLOPES,
    combined_state,
    extreme_states,
    state_error,
)
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.shell.points import attached_discs, footprint_rows
from simulation.shell.rigidity import W
from simulation.shell.unknowns import factorize
from simulation.state.attached import Seat
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import Circumstances, PlateState
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.loaded_modes import LoadedModes, attached_poles
from simulation.twin.twin import Twin

BAND = (100.0, 500.0)
LINES = np.linspace(*BAND, 120)
POINT = SweepPoint(24.0, 0.4 / 60.0, 2.0)
LAWS = LocalLaws(
    23.0, np.array([np.log(2e9), 0.38, np.log(0.06)]), np.array([-0.02, 0.002, -0.01]), np.array([1e-4, 0.0, 1e-4])
)
SHAPES = {
    "softening": 0.03,
    "x": 0.11,
    "y": 0.08,
    "growth": 0.05,
    "order": 0.5,
    "frequency": 300.0,
    "resonance": 300.0,
    "loss": 0.1,
}


@pytest.fixture(scope="module")
def experiment(declare, patches):
    return declare(patches, BAND)


@pytest.fixture(scope="module")
def reduced(experiment, coarse_mesh):
    box = MaterialBox((1e9, 3.2e9), (0.33, 0.46), (0.02, 0.12))
    return reduce_with_effects(experiment, box, fineness=Fineness(coarse_mesh, degree=4, tolerance=1e-6))


@pytest.fixture(scope="module")
def twin(experiment, reduced):
    return Twin.of(experiment, EffectPlate(reduced[0]), library(experiment)).referred(LAWS)


def test_where_the_sensor_stays_in_place_the_twin_answers_as_well(experiment, twin, coarse_mesh):
    """Operators for a misplaced sensor are half of the memory; all other effects do without."""
    box, fineness = twin.box, Fineness(coarse_mesh, degree=4, tolerance=1e-6)
    ops, _, _ = reduce_with_effects(experiment, box, fineness=fineness, offset=False)
    known = {name: one for name, one in library(experiment).items() if name != "sensor_offset"}
    placed = Twin.of(experiment, EffectPlate(ops), known).referred(LAWS)
    assert ops.offset_range == 0.0
    assert ops.size < twin.plate.operators.size
    for effects in ({}, {"bond_shear_lag": values_of(twin, "bond_shear_lag", 1.0)}):
        wanted = twin.frf(LAWS, LINES, effects)
        assert np.abs(placed.frf(LAWS, LINES, effects) - wanted).max() < 2e-3 * np.abs(wanted).max()


def values_of(twin, name, share):
    """Amplitudes at a share of their prior sigma, shapes somewhere."""
    return {p.name: SHAPES[p.name] if p.shape else share * p.sigma for p in twin.cards[name].parameters}


def every_effect(twin):
    return list(twin.cards)


def test_all_take_part_but_those_of_accelerometers(twin):
    assert set(LIBRARY) - set(twin.cards) == {"accelerometer_mass", "mounting_resonance"}


def test_absent_effects_change_nothing(twin):
    plain = twin.frf(LAWS, LINES, point=POINT)
    for name in every_effect(twin):
        there = twin.frf(LAWS, LINES, {name: values_of(twin, name, 0.0)}, POINT)
        assert there == pytest.approx(plain, rel=1e-9, abs=1e-9 * np.abs(plain).max()), name


@pytest.mark.slow
def test_derivatives_by_every_parameter(twin):
    exact = replace(twin, reach=np.inf)
    for name, card in twin.cards.items():
        at = values_of(twin, name, 0.3)
        wanted = [(name, p.name, at) for p in card.parameters]
        line = exact.linearise(LAWS, LINES[::6], {name: at}, POINT, wanted)
        for parameter, found in zip(card.parameters, line.by_parameter, strict=True):
            # no one step is far from both rounding and curvature for all effects: the better of two counts
            errors = []
            for step in (
                (2e-6, 2e-5) if parameter.name in "xy" else (1e-3 * parameter.sigma, 1e-2 * parameter.sigma)
            ):
                moved = [
                    exact.frf(
                        LAWS, LINES[::6], {name: {**at, parameter.name: at[parameter.name] + k * step}}, POINT
                    )
                    for k in (1, -1, 2, -2)
                ]
                quotient = (8.0 * (moved[0] - moved[1]) - (moved[2] - moved[3])) / (12.0 * step)
                rounding = 1e-10 * np.abs(moved[0]).max() / step
                errors.append(np.abs(found - quotient).max() / (1e-6 * np.abs(quotient).max() + rounding))
            assert min(errors) < 1.0, (name, parameter.name)


@pytest.mark.parametrize("on", [{"thermal_lag": {"tau": 120.0}}, {"draught_gradient": {"gx": 3.0, "gy": -2.0}}])
def test_derivatives_by_laws_and_temperature(twin, on):
    exact = replace(twin, reach=np.inf)
    line = exact.linearise(LAWS, LINES[::6], on, POINT)
    for law in range(3):
        d = 1e-5 * np.eye(3)[law]
        # steps ten times as large and one order more: smaller ones drown in rounding
        one, other, two, third = (
            exact.frf(replace(LAWS, value=LAWS.value + 10 * s * d), LINES[::6], on, POINT) for s in (1, -1, 2, -2)
        )
        quotient = (8.0 * (one - other) - (two - third)) / 12e-4
        assert np.abs(line.by_material[law] - quotient).max() < 1e-6 * np.abs(quotient).max()
        flat = np.zeros(3)
        for found, one in ((line.by_slope, (d, flat)), (line.by_curvature, (flat, d))):
            moved = (LAWS.tilted(*(s * part for part in one), POINT.temperature) for s in (10, -10))
            up, down = (exact.frf(laws, LINES[::6], on, POINT) for laws in moved)
            quotient = (up - down) / 2e-4
            assert np.abs(found[law] - quotient).max() < 1e-5 * np.abs(quotient).max()
    up, down = (
        exact.frf(LAWS, LINES[::6], on, replace(POINT, temperature=POINT.temperature + s * 1e-3)) for s in (1, -1)
    )
    quotient = (up - down) / 2e-3
    assert np.abs(line.by_temperature - quotient).max() < 1e-6 * np.abs(quotient).max()


def test_few_coordinates_answer_like_all(twin):
    for effects in ({}, {"orthotropy": {"delta_e": 0.05, "delta_g": -0.04}}, {"point_mass": {"mass": 0.002}}):
        few, all_of_them = (t.frf(LAWS, LINES, effects, POINT) for t in (twin, replace(twin, reach=np.inf)))
        assert np.abs(few - all_of_them).max() < 2e-4 * np.abs(all_of_them).max()


def test_a_lag_is_another_temperature(twin):
    late = twin.frf(LAWS, LINES, {"thermal_lag": {"tau": 240.0}}, POINT)
    colder = replace(POINT, temperature=POINT.temperature - 240.0 * POINT.rate)
    assert late == pytest.approx(twin.frf(LAWS, LINES, point=colder), rel=1e-9)


def test_a_drift_within_the_sweep_is_another_temperature_at_each_frequency(twin):
    """What is left is of second order in the drift: 0.13 K over a sweep of 20 s, and half of it."""
    timing = SweepTiming("logarithmic", BAND, 1.0, 20.0, 22.0)
    still, effects = replace(POINT, rate=0.0), {"point_mass": {"mass": 0.002}}

    def left(rate: float) -> tuple[float, float]:
        temperature = POINT.temperature + rate * timing.after_middle(LINES)
        by_line = zip(LINES, temperature, strict=True)
        steady = [twin.frf(LAWS, np.array([f]), effects, replace(still, temperature=t))[:, 0] for f, t in by_line]
        drifting = replace(POINT, rate=rate, timing=timing)
        found = twin.frf(LAWS, LINES, effects, drifting), twin.linearise(LAWS, LINES, effects, drifting).transfer
        assert found[0] == pytest.approx(found[1], rel=1e-12)
        return tuple(
            np.abs(f - np.transpose(steady)).max() for f in (found[0], twin.frf(LAWS, LINES, effects, still))
        )

    (whole, without), (half, _) = left(0.4 / 60.0), left(0.2 / 60.0)
    assert whole < 0.05 * without
    assert half == pytest.approx(whole / 4.0, rel=0.3)


def test_dispersion_is_another_modulus_at_each_frequency(twin):
    eta = LAWS.loss_factor(POINT.temperature)
    for f in (200.0, 500.0):
        line = np.array([f])
        found = twin.frf(LAWS, line, {"viscoelastic_dispersion": {"kappa": 1.0}}, POINT)
        stiffer = replace(LAWS, value=LAWS.value + np.array([2.0 * eta / np.pi * np.log(f / 500.0), 0.0, 0.0]))
        assert found == pytest.approx(twin.frf(stiffer, line, point=POINT), rel=2e-3)
        found = twin.frf(LAWS, line, {"damping_dispersion": {"p": 0.2}}, POINT)
        damped = replace(LAWS, value=LAWS.value + np.array([0.0, 0.0, 0.2 * np.log(f / 500.0)]))
        assert found == pytest.approx(twin.frf(damped, line, point=POINT), rel=2e-3)


def test_softening_grows_with_the_square_of_the_level(twin):
    on = {"amplitude_softening": {"a": 1e-4, "b": 0.0}}
    plain, strong = (twin.frf(LAWS, LINES, effects, POINT) for effects in ({}, on))
    weak = twin.frf(LAWS, LINES, on, replace(POINT, level=1.0))
    assert strong - plain == pytest.approx(4.0 * (weak - plain), abs=0.02 * np.abs(strong - plain).max())


def test_point_loads_against_the_full_plate(twin, reduced):
    ops, full, _ = reduced
    order = {(0.03, 0.187): 0, (0.058, 0.03): 1}
    state = twin.state(LAWS, LINES, {}, POINT)
    xi, zeta = full.sampling
    exact = full.matrices(type(state).baseline(xi, zeta, LAWS, POINT.temperature, LINES))
    discs = attached_discs(full.shell.plate, [Attachment(point=point) for point in order])
    rows = full.unknowns.rows(footprint_rows(full.shell.space, discs), W).toarray()
    peak = np.abs(twin.frf(LAWS, LINES, point=POINT)).max()
    for effects, place, k, c, m in (
        ({"point_mass": {"mass": 0.002}}, (0.058, 0.03), 0.0, 0.0, 0.002),
        ({"suspension": {"stiffness": 300.0, "damping": 0.4}}, (0.03, 0.187), 300.0, 0.4, 0.0),
    ):
        row = rows[order[place]]
        for f in (141.0, 263.0, 407.0):
            omega = 2 * np.pi * f
            z = exact.plate + 1j * exact.plate_loss + exact.patches - omega**2 * exact.mass
            factors = factorize(z)
            answers = factors.solve(exact.coupling.astype(complex))
            to_point = factors.solve(row.astype(complex))
            impedance = k + 1j * omega * c - omega**2 * m
            # Sherman and Morrison: a load on one point changes the plate by a matrix of rank one
            there = row @ answers
            answers -= np.outer(to_point, there) * impedance / (1.0 + impedance * (row @ to_point))
            g = exact.coupling.T @ answers
            load = twin.experiment.acquisition
            across = ops.capacitance[1] + load.input_capacitance + 1.0 / (1j * omega * load.input_resistance)
            expected = -g[1, 0] / (across + g[1, 1])
            found = twin.frf(LAWS, np.array([f]), effects, POINT)[0, 0]
            assert abs(found - expected) < 5e-4 * peak, (effects, f)


HUNG = {"x": 0.163, "y": 0.052}
CORNER = {"x": 0.236, "y": 0.004}
VERY_CORNER = {"x": 0.2385, "y": 0.0015}


@pytest.mark.parametrize("place", [HUNG, {"x": 0.112, "y": 0.089}, CORNER, VERY_CORNER])
def test_attachments_at_any_place_against_the_full_plate(twin, reduced, place):
    _, full, _ = reduced
    xi, zeta = full.sampling
    exact = full.matrices(PlateState.baseline(xi, zeta, LAWS, POINT.temperature, LINES))
    discs = attached_discs(full.shell.plate, [Attachment(point=(place["x"], place["y"]))])
    row = full.unknowns.rows(footprint_rows(full.shell.space, discs), W).toarray()[0]
    plain = twin.frf(LAWS, LINES, point=POINT)
    peak = np.abs(plain).max()
    spring = 0.001 * (2.0 * np.pi * 300.0) ** 2 * (1.0 + 0.05j)
    for name, values, impedance in (
        ("mass_at_place", {"mass": 0.003}, lambda w: -0.003 * w**2),
        ("spring_at_place", {"stiffness": 3000.0, "loss": 0.1}, lambda w: 3000.0 * (1.0 + 0.1j)),
        ("dashpot_at_place", {"damping": 0.5}, lambda w: 0.5j * w),
        (
            "resonator_at_place",
            {"mass": 0.001, "resonance": 300.0, "loss": 0.05},
            lambda w: -0.001 * w**2 * spring / (spring - 0.001 * w**2),
        ),
    ):
        found = twin.frf(LAWS, LINES, {name: {**values, **place}}, POINT)[0]
        effect = np.abs(found - plain[0]).max()
        for k in (23, 60, 119):
            omega = 2 * np.pi * LINES[k]
            factors = factorize(exact.plate + 1j * exact.plate_loss + exact.patches - omega**2 * exact.mass)
            answers = factors.solve(exact.coupling.astype(complex))
            to_point = factors.solve(row.astype(complex))
            d = impedance(omega)
            answers -= np.outer(to_point, row @ answers) * d / (1.0 + d * (row @ to_point))
            g = exact.coupling.T @ answers
            load = twin.experiment.acquisition
            across = twin.plate.capacitance[1] + load.input_capacitance
            expected = -g[1, 0] / (across + 1.0 / (1j * omega * load.input_resistance) + g[1, 1])
            assert (
                abs(found[k] - expected)
                < (3e-3 if place in (CORNER, VERY_CORNER) else 2e-3) * effect + 1e-4 * peak
            ), (
                name,
                LINES[k],
            )


def test_the_compliance_under_an_attachment_has_a_tolerance(twin, experiment):
    """Twice as soft is in series with a spring; its derivative is the quotient of differences."""
    free = replace(twin, tolerances=tolerances(experiment, twin.plate.operators.movable, attachable=True))
    spring = {"spring_at_place": {"stiffness": 3000.0, "loss": 0.1, **CORNER}}

    def at(share):
        return {**spring, "place_contact": {"share": share}}

    np.testing.assert_allclose(free.frf(LAWS, LINES, at(0.0), POINT), twin.frf(LAWS, LINES, spring, POINT))
    seat = Seat.of(twin.plate.operators, *_attached_and_state(free, at(np.log(2.0))))
    once = Seat.of(twin.plate.operators, *_attached_and_state(free, at(0.0)))
    bare = 3000.0 * (1.0 + 0.1j)
    softer = [1.0 / (one.stiffness + 1j * one.loss) - 1.0 / bare for one in (seat, once)]
    np.testing.assert_allclose(softer[0], 2.0 * softer[1], rtol=1e-9)
    here, step = at(0.5), 1e-4
    tangent = ("place_contact", "share", here["place_contact"])
    exact = free.linearise(LAWS, LINES, here, POINT, [tangent]).by_parameter[0]
    quotient = (free.frf(LAWS, LINES, at(0.5 + step), POINT) - free.frf(LAWS, LINES, at(0.5 - step), POINT)) / (
        2.0 * step
    )
    assert np.abs(exact - quotient).max() < 1e-5 * np.abs(quotient).max()


def _attached_and_state(twin, effects):
    state = twin.state(LAWS, LINES, effects, POINT)
    return state.attached[0], state


def test_light_attachments_at_one_place_add_up(twin):
    both = {"mass_at_place": {"mass": 2e-7, **HUNG}, "spring_at_place": {"stiffness": 0.1, "loss": 0.0, **HUNG}}
    plain, together = (twin.frf(LAWS, LINES, on, POINT) for on in ({}, both))
    alone = sum(twin.frf(LAWS, LINES, {name: values}, POINT) - plain for name, values in both.items())
    assert np.abs(together - plain - alone).max() < 1e-3 * np.abs(alone).max()


def test_attachments_act_beside_dispersion_and_dashpots(twin):
    """With spectra the plate is solved line by line: an exponent that does nothing must change nothing."""
    for name, values in (("mass_at_place", {"mass": 0.002}), ("dashpot_at_place", {"damping": 0.3})):
        one = {name: {**values, **HUNG}}
        modal = twin.frf(LAWS, LINES, one, POINT)
        by_lines = twin.frf(LAWS, LINES, {**one, "damping_dispersion": {"p": 1e-12}}, POINT)
        np.testing.assert_allclose(by_lines, modal, rtol=1e-7)


def test_nothing_is_attached_beside_the_plate(twin):
    with pytest.raises(ValueError, match=r"nothing can be attached at 0.26, 0.05 m: it is off the plate"):
        twin.frf(LAWS, LINES, {"mass_at_place": {"mass": 0.001, "x": 0.26, "y": 0.05}}, POINT)


def test_at_one_line_attachments_are_a_part_of_the_stiffness(twin):
    """Two ways: a change of rank one of the answers, or modes of the whole at this line."""
    for name, values in (("mass_at_place", {"mass": 0.002}), ("dashpot_at_place", {"damping": 0.3})):
        one = {name: {**values, **HUNG}}
        pair = twin.frf(LAWS, LINES[[40, 90]], one, POINT)
        for k, line in enumerate((40, 90)):
            alone = twin.frf(LAWS, LINES[[line]], one, POINT)
            np.testing.assert_allclose(alone[:, 0], pair[:, k], rtol=1e-8)


@pytest.mark.parametrize("name", ["mass_at_place", "spring_at_place", "dashpot_at_place", "resonator_at_place"])
def test_attachments_are_joined_to_modes_as_to_the_answers_of_every_line(twin, monkeypatch, name):
    """Transfers and all derivatives, beside dashpots, too."""
    values = {p.name: SHAPES[p.name] if p.shape else p.sigma for p in twin.cards[name].parameters} | HUNG
    effects = {name: values, "local_damage": {"loss": 0.1, "x": 0.05, "y": 0.12}}
    if name == "spring_at_place":
        effects["mass_at_place"] = {"mass": 0.001, "x": 0.12, "y": 0.05}
    tangents = [(one, p.name, effects[one]) for one in effects for p in twin.cards[one].parameters]
    tangents += [
        ("suspension", p.name, values_of(twin, "suspension", 1.0)) for p in twin.cards["suspension"].parameters
    ]
    found = []
    for modes in (True, False):
        if not modes:
            monkeypatch.setattr("simulation.twin.local_solution._modal", lambda *_: None)
        solved = twin.solved(twin.state(LAWS, LINES, effects, POINT), LINES)
        assert (solved.modal is not None) == modes
        found.append((twin.linearise(LAWS, LINES, effects, POINT, tangents), solved.answers))
    (ours, answers), (plain, wanted) = found
    np.testing.assert_allclose(answers, wanted, rtol=0.0, atol=1e-9 * np.abs(wanted).max())
    for part in ("transfer", "by_material", "by_slope", "by_curvature", "by_temperature", "by_parameter"):
        one, other = getattr(ours, part), getattr(plain, part)
        size = np.abs(other).reshape(-1, other.shape[-1]).max(axis=1)
        assert (np.abs(one - other).reshape(-1, other.shape[-1]).max(axis=1) <= 1e-7 * size + 1e-300).all(), part


@pytest.mark.parametrize(
    "effects",
    [
        {"mass_at_place": {"mass": 0.004, **HUNG}},
        {"spring_at_place": {"stiffness": 3e3, "loss": 0.1, **HUNG}},
        {"mass_at_place": {"mass": 0.002, "x": 0.12, "y": 0.05}, "dashpot_at_place": {"damping": 0.3, **HUNG}},
    ],
)
def test_modes_with_attachments_are_free_vibrations_at_their_own_frequencies(twin, effects):
    """At one line the attachment is a part of the stiffness; a mode is found again at its own frequency."""
    lines = np.geomspace(LINES[0], LINES[-1], 400)
    solved = twin.solved(twin.state(LAWS, lines, effects, POINT), lines)
    found = attached_poles(solved, solved.modal, twin.instruments, twin.plate.capacitance)
    plain = twin.solved(twin.state(LAWS, lines, {}, POINT), lines)
    without = LoadedModes.of(plain, plain.modal, twin.instruments, twin.plate.capacitance).poles
    inside = (np.abs(without) > 2 * np.pi * lines[0]) & (np.abs(without) < 2 * np.pi * lines[-1])
    assert abs(len(found) - inside.sum()) <= 1  # one may have left the band
    assert np.abs(found[:, None] / without - 1.0).min(axis=1).max() > 1e-3
    for pole in found:
        line = np.array([np.abs(pole)]) / (2 * np.pi)
        alone = twin.solved(twin.state(LAWS, line, effects, POINT), line)
        there = LoadedModes.of(alone, alone.modal, twin.instruments, twin.plate.capacitance).poles
        assert np.abs(there / pole - 1.0).min() < 2e-4  # of a width of 6 %


def test_light_mass_lowers_a_mode_as_rayleigh_says(twin, reduced):
    ops, _, _ = reduced
    plain = twin.solved(twin.state(LAWS, LINES, {}, POINT), LINES)  # modes of the plate as it is
    stiffness, mass = plain.composite.plate + plain.composite.fixed, plain.composite.mass
    squares, shapes = np.linalg.eigh(np.linalg.solve(mass, stiffness))
    elastic = int(np.searchsorted(squares, (2 * np.pi * 100.0) ** 2))
    there = ops.deflection[1] @ plain.basis @ shapes[:, elastic]
    light = 1e-5
    loaded = twin.solved(twin.state(LAWS, LINES, {"point_mass": {"mass": light}}, POINT), LINES)
    k, m = loaded.composite.plate + loaded.composite.fixed, loaded.composite.mass
    moved = np.sort(np.linalg.eigvals(np.linalg.solve(m, k)).real)[elastic]
    assert moved / squares[elastic] - 1.0 == pytest.approx(-light * there**2, rel=0.01)


def test_states_at_the_edges_of_their_ranges_against_the_full_plate(reduced):
    ops, full, _ = reduced
    basis, rng = field_basis(BENDING_DEGREE), np.random.default_rng(3)
    laws = LocalLaws.of_material(2.2e9, 0.37, 0.05, slope=STEEPEST_SLOPES)

    def error(make: Callable[[Real, Real], PlateState]) -> float:
        few = make(basis.xi, basis.zeta)
        there = full.moved_by(few.offset_x, few.offset_y)  # fields stay where they are when the sensor moves
        return state_error(full, ops, few, make(*there.sampling), int(rng.integers(CERTIFIED_LINES)))

    def extreme(xi: Real, zeta: Real, size: float) -> list[PlateState]:
        return extreme_states(xi, zeta, laws, ops.offset_range, size)

    for size in (1.0, -1.0):
        for k in range(len(extreme(basis.xi, basis.zeta, size))):
            assert error(lambda xi, zeta, k=k, size=size: extreme(xi, zeta, size)[k]) < 2e-4, (size, k)
    assert error(lambda xi, zeta: combined_state(xi, zeta, laws, ops.offset_range, 0.5)) < 1e-3


FIELDS = {
    "density_gradient": {"mx": 0.06, "my": -0.04},
    "modulus_gradient": {"ex": 0.1, "ey": 0.06},
    "thickness_crown": {"cx": 0.01, "cy": -0.01},
    "thermal_crown": {"gx": 3.0, "gy": 2.0},
    "transverse_shear": {"delta": -0.4},
    "poisson_loss": {"kappa": 1.0},
    "loss_orthotropy": {"delta_eta": 0.3, "delta_shear": 0.4},
    "patch_debond": {"A1": 0.3, "S1": 0.15},
    "patch_loss": {"eta": 0.05},
}


@pytest.mark.parametrize("name", FIELDS)
def test_states_that_were_not_trained_against_the_full_plate(name, experiment, reduced):
    ops, full, _ = reduced
    basis = field_basis(BENDING_DEGREE)
    laws = LocalLaws.of_material(2.2e9, 0.37, 0.05, slope=STEEPEST_SLOPES)
    point = replace(POINT, temperature=45.0)

    def state(xi: Real, zeta: Real) -> PlateState:
        plain = PlateState.baseline(xi, zeta, laws, laws.reference, np.array([500.0]))
        around = Circumstances.of(experiment, point, np.array([500.0]))
        return LIBRARY[name].apply(plain, around, FIELDS[name])

    few, exact = state(basis.xi, basis.zeta), state(*full.sampling)
    plain = PlateState.baseline(*full.sampling, laws, laws.reference, np.array([500.0]))
    effect = state_error(full, ops, few, plain, 97)
    assert effect > 2e-3
    assert state_error(full, ops, few, exact, 97) < 4e-3 * effect


def test_it_refuses_what_was_not_certified(twin):
    with pytest.raises(ValueError, match=r"modulus along x over E .* outside the twin's certified range"):
        twin.frf(LAWS, LINES, {"orthotropy": {"delta_e": 0.3, "delta_g": 0.0}}, POINT)
    with pytest.raises(ValueError, match="youngs_modulus"):
        twin.frf(replace(LAWS, value=LAWS.value + np.array([2.0, 0.0, 0.0])), LINES, point=POINT)


def test_parts_of_modes_with_every_effect(twin):
    """Of the plate without what is attached to it: near enough to tell what a mode's shift does.

    All but a modulus that softens with the strain energy, which a shift of E changes, too.
    """
    for name in set(every_effect(twin)) - {"amplitude_softening"}:
        at = {name: values_of(twin, name, 0.3)}
        line, found = twin.linearise(LAWS, LINES, at, POINT), twin.modal_parts(LAWS, LINES, at, POINT)
        away = np.abs(0.5 * found.by_pole.sum(axis=0) - line.by_material[0])
        assert away.max() < 0.35 * np.abs(line.by_material[0]).max(), name
