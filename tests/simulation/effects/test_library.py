"""The library as a whole: the contract of names, what is left out and why, the order, effects together."""

from dataclasses import replace

import numpy as np
import pytest

from simulation.effects.library import LIBRARY, apply_all, interior_point, library, numbers, verify

CONTRACT = {
    "orthotropy": ("delta_e", "delta_g"),
    "thermal_gradient": ("gx", "gy"),
    "draught_gradient": ("gx", "gy"),
    "thickness_taper": ("tx", "ty"),
    "thermal_lag": ("tau",),
    "suspension": ("stiffness", "damping"),
    "point_mass": ("mass",),
    "bond_shear_lag": ("gamma25", "softening"),
    "piezo_drift": ("alpha",),
    "viscoelastic_dispersion": ("kappa",),
    "damping_dispersion": ("p",),
    "air_loading": ("added_mass_factor", "radiation_factor"),
    "local_damage": ("loss", "x", "y"),
    "sensor_offset": ("dx", "dy"),
    "channel_skew": ("delay",),
    "high_pass": ("corner",),
    "feedthrough": ("gain",),
    "amplitude_softening": ("a", "b"),
    "loss_orthotropy": ("delta_eta", "delta_shear"),
    "poisson_loss": ("kappa",),
    "transverse_shear": ("delta",),
    "modulus_gradient": ("ex", "ey"),
    "density_gradient": ("mx", "my"),
    "thickness_crown": ("cx", "cy"),
    "thermal_crown": ("gx", "gy"),
    "string_mass": ("mass",),
    "cable_stiffness": ("stiffness", "damping"),
    "accelerometer_mass": ("mass",),
    "patch_debond": ("A1", "S1"),
    "patch_loss": ("eta",),
    "permittivity_drift": ("beta",),
    "insulation_leak": ("leak25", "growth"),
    "piezo_loss": ("angle",),
    "piezo_nonlinearity": ("beta",),
    "depolarization": ("lost",),
    "fractional_viscosity": ("share", "order"),
    "relaxation": ("strength", "frequency"),
    "annealing": ("stiffening", "loss"),
    "elastic_foundation": ("stiffness",),
    "surface_damping": ("resistance",),
    "low_pass": ("time_constant",),
    "mounting_resonance": ("softness",),
    "crosstalk": ("gain",),
    "mass_at_place": ("mass", "x", "y"),
    "spring_at_place": ("stiffness", "x", "y", "loss"),
    "dashpot_at_place": ("damping", "x", "y"),
    "resonator_at_place": ("mass", "x", "y", "resonance", "loss"),
}
"""Names in campaigns that disclose an effect, and in gap.json."""


OF_ACCELEROMETERS = {"accelerometer_mass", "mounting_resonance"}


@pytest.fixture(scope="module")
def declared(experiment, accelerometers):
    """Return the experiment that an effect is available for."""
    return lambda name: accelerometers if name in OF_ACCELEROMETERS else experiment


@pytest.mark.parametrize("name", LIBRARY)
def test_every_effect_is_absent_at_zero_and_safe_for_a_complex_step(name, declared):
    verify(LIBRARY[name], declared(name))


@pytest.mark.parametrize("name", LIBRARY)
def test_every_card_says_what_people_need(name, declared):
    card = LIBRARY[name].card(declared(name))
    assert card.name == name
    assert all(len(words.split()) >= 4 for words in (card.summary, card.needs, card.separated_by))
    for parameter in card.parameters:
        assert parameter.sigma <= parameter.high - parameter.low
        assert parameter.low <= parameter.typical <= parameter.high
    for site in card.sites:
        shapes = {p.name: p for p in card.parameters if p.shape}
        assert all(shapes[shape].low <= value <= shapes[shape].high for shape, value in site.items())


def test_names_and_parameters_are_the_contract(experiment):
    cards = {name: effect.card(experiment) for name, effect in LIBRARY.items()}
    assert {name: tuple(p.name for p in card.parameters) for name, card in cards.items()} == CONTRACT


def test_all_effects_at_zero_leave_the_plate_as_declared(experiment, trial):
    circumstances, state = trial(temperature=40.0, rate=0.4 / 60.0)
    effects = library(experiment)
    zeros = {name: effect.card(experiment).zero() for name, effect in effects.items()}
    after = numbers(apply_all(effects, state, circumstances, zeros))
    for name, value in numbers(state).items():
        np.testing.assert_array_equal(after[name], np.broadcast_to(value, after[name].shape), err_msg=name)


@pytest.mark.parametrize("name", LIBRARY)
def test_derivatives_hold_with_all_other_effects_on(name, declared, trial):
    at = declared(name)
    rate = -0.4 / 60.0 if name in ("annealing", "depolarization") else 0.4 / 60.0
    circumstances, state = trial(temperature=40.0, rate=rate, frequency=(100.0, 433.0, 1500.0), declared=at)
    circumstances = replace(circumstances, strain_energy=np.array([0.1, 0.9, 3.0]))
    effects = library(at)
    cards = {each: effect.card(at) for each, effect in effects.items()}
    values = {each: interior_point(card, card.sites[0]) for each, card in cards.items()}
    for parameter in cards[name].parameters:

        def moved(step, parameter=parameter):
            on = {**values[name], parameter.name: values[name][parameter.name] + step}
            return numbers(apply_all(effects, state, circumstances, {**values, name: on}))

        small = 1e-4 * parameter.sigma
        above, below, stepped = moved(small), moved(-small), moved(1j * 1e-30)
        for attribute, value in stepped.items():
            central = (above[attribute] - below[attribute]) / (2.0 * small)
            size = np.abs(central).max(initial=0.0)
            rounding = 1e-12 * np.abs(value).max(initial=0.0) / small
            np.testing.assert_allclose(np.imag(value) / 1e-30, central, rtol=0.0, atol=1e-6 * size + rounding)


def test_only_what_the_declaration_supports_takes_part(experiment, accelerometers, plate):
    assert set(library(experiment)) == set(CONTRACT) - OF_ACCELEROMETERS

    def left_out(**changes):
        return set(library(experiment)) - set(library(experiment.model_copy(update=changes)))

    assert left_out(string=()) == {"suspension", "string_mass"}
    assert left_out(cable=()) == {"point_mass", "cable_stiffness"}
    hot = experiment.oven.model_copy(update={"room_temperature": 60.0})
    assert left_out(oven=hot) == {"thermal_gradient", "thermal_crown"}
    strip = plate.model_copy(update={"length_y": 0.02})
    sensor = experiment.sensors[0].model_copy(update={"center": (0.04, 0.01)})
    beam = experiment.model_copy(update={"plate": strip, "patch": (experiment.actuator, sensor)})
    assert set(library(experiment)) - set(library(beam)) == {"local_damage", "sensor_offset"}
    assert {"accelerometer_mass", "mounting_resonance"} <= set(library(accelerometers))
    weighed = [sensor.model_copy(update={"mass": 0.001}) for sensor in accelerometers.sensor]
    assert "accelerometer_mass" not in library(accelerometers.model_copy(update={"sensor": tuple(weighed)}))
    moved = accelerometers.sensor[0].model_copy(update={"point": None, "points": ((0.17, 0.12), (0.1, 0.15))})
    assert "accelerometer_mass" not in library(accelerometers.model_copy(update={"sensor": (moved,)}))


def test_no_card_lets_a_patch_leave_the_plate(experiment):
    sensor = experiment.sensors[0].model_copy(update={"center": (0.012, 0.18)})
    near = experiment.model_copy(update={"patch": (experiment.actuator, sensor)})
    dx, dy = LIBRARY["sensor_offset"].card(near).parameters
    assert (dx.low, dx.high) == pytest.approx((-0.002, 0.0025), abs=2e-6)
    assert (dy.low, dy.high) == pytest.approx((-0.0025, 0.0), abs=2e-6)


def test_lag_comes_before_what_reads_the_plates_temperature(experiment, trial):
    circumstances, state = trial(temperature=61.0, rate=0.01)
    values = {"thermal_gradient": {"gx": 2.0, "gy": 0.0}, "thermal_lag": {"tau": 100.0}}  # 61 - 1 = 60
    after = apply_all(library(experiment), state, circumstances, values)
    np.testing.assert_allclose(after.temperature, 60.0 + state.xi, rtol=1e-14)


def test_gradients_do_not_reach_what_reads_the_plates_temperature(experiment, trial):
    """Sampling points that crowd on one side must not count as a warmer plate."""
    circumstances, state = trial(temperature=40.0)
    assert state.xi.mean() != 0.0
    effects = library(experiment)
    bond = {"bond_shear_lag": {"gamma25": 0.2, "softening": 0.05}}
    tilted = {**bond, "draught_gradient": {"gx": 8.0, "gy": 0.0}}
    alone = apply_all(effects, state, circumstances, bond)
    assert apply_all(effects, state, circumstances, tilted).bond == alone.bond


def test_values_of_an_effect_that_is_not_there_are_refused(experiment, trial):
    circumstances, state = trial()
    with pytest.raises(ValueError, match="no effect is named 'point_mas'; there are thermal_lag, orthotropy"):
        apply_all(library(experiment), state, circumstances, {"point_mas": {"mass": 1e-3}})
