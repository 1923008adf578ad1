"""Effects on normal motion, against the definitions of ``recorded-campaign/1`` by hand."""

import numpy as np
import pytest

from simulation.effects.library import LIBRARY


def test_every_string_holds_by_the_same_spring_and_dashpot(trial):
    circumstances, state = trial()
    after = LIBRARY["suspension"].apply(state, circumstances, {"stiffness": 300.0, "damping": 0.2})
    assert [load.point for load in after.point_loads] == [(0.03, 0.187), (0.21, 0.187)]
    assert {(load.stiffness, load.damping, load.mass) for load in after.point_loads} == {(300.0, 0.2, 0.0)}


def test_the_cables_mass_joins_what_hangs_on_the_plate_already(trial):
    circumstances, state = trial()
    held = LIBRARY["suspension"].apply(state, circumstances, {"stiffness": 300.0, "damping": 0.0})
    after = LIBRARY["point_mass"].apply(held, circumstances, {"mass": 8e-4})
    assert after.point_loads[:2] == held.point_loads
    cable = after.point_loads[2]
    assert (cable.point, cable.stiffness, cable.damping, cable.mass) == ((0.058, 0.03), 0.0, 0.0, 8e-4)


def test_the_first_sensor_moves_by_its_offset(trial):
    circumstances, state = trial()
    after = LIBRARY["sensor_offset"].apply(state, circumstances, {"dx": 1e-3, "dy": -2e-3})
    assert (after.offset_x, after.offset_y) == (1e-3, -2e-3)


def test_air_by_the_speed_of_the_bending_waves(trial):
    """With c_b = (D w**2/(rho h))**(1/4) the wavenumber is w/c_b: another way to the same numbers."""
    frequency = np.array([100.0, 400.0, 1500.0])
    circumstances, state = trial(temperature=30.0, frequency=tuple(frequency))
    after = LIBRARY["air_loading"].apply(state, circumstances, {"added_mass_factor": 1.0, "radiation_factor": 1.0})
    omega = 2.0 * np.pi * frequency
    rigidity = 2e9 * 0.003**3 / 12.0 / (1.0 - 0.38**2)
    bending = (rigidity * omega**2 / (0.12996 / (0.24 * 0.19))) ** 0.25
    air, sound = 1.204 * 293.0 / 303.0, 331.3 * np.sqrt(1.0 + 30.0 / 273.15)
    assert sound == pytest.approx(349.0, abs=0.2)
    mach = bending / sound
    assert (mach < 0.9).all()
    np.testing.assert_allclose(after.area_mass, 2.0 * air * bending / omega / np.sqrt(1.0 - mach**2), rtol=1e-12)
    np.testing.assert_allclose(after.area_resistance, 0.35 * air * sound * mach**2, rtol=1e-12)
    # by hand at 100 Hz: D = 5.26 N m, 2.85 kg/m2, k_b = 21.5 rad/m: 4.65 cm of air on each face, 4 % of the plate
    assert after.area_mass[0] == pytest.approx(2.0 * 1.164 * 0.0465, rel=0.01)


def test_each_factor_of_the_air_has_its_own_half(trial):
    circumstances, state = trial()
    apply = LIBRARY["air_loading"].apply
    both = apply(state, circumstances, {"added_mass_factor": 1.0, "radiation_factor": 1.0})
    other = apply(state, circumstances, {"added_mass_factor": 0.0, "radiation_factor": 2.0})
    np.testing.assert_array_equal(other.area_mass, 0.0)
    np.testing.assert_allclose(other.area_resistance, 2.0 * both.area_resistance)


def test_added_mass_stays_finite_above_coincidence_and_radiation_grows_on(trial):
    circumstances, state = trial(frequency=(2e4, 8e4))
    after = LIBRARY["air_loading"].apply(state, circumstances, {"added_mass_factor": 1.0, "radiation_factor": 1.0})
    # q stays at 0.9: the mass falls as 1/k_b, that is as 1/sqrt(f); the resistance rises as q**2, that is as f
    assert after.area_mass[0] == pytest.approx(2.0 * after.area_mass[1])
    assert after.area_resistance[1] == pytest.approx(4.0 * after.area_resistance[0])


def test_a_cable_holds_and_strings_weigh_where_they_are_declared(trial):
    circumstances, state = trial()
    held = LIBRARY["cable_stiffness"].apply(state, circumstances, {"stiffness": 200.0, "damping": 0.1})
    (cable,) = held.point_loads
    assert (cable.point, cable.stiffness, cable.damping, cable.mass) == ((0.058, 0.03), 200.0, 0.1, 0.0)
    hung = LIBRARY["string_mass"].apply(state, circumstances, {"mass": 3e-4})
    assert [(load.point, load.mass) for load in hung.point_loads] == [((0.03, 0.187), 3e-4), ((0.21, 0.187), 3e-4)]


def test_only_accelerometers_without_a_declared_mass_get_one(accelerometers, trial):
    weighed = accelerometers.sensor[0].model_copy(update={"mass": 0.001})
    one = accelerometers.model_copy(update={"sensor": (weighed, accelerometers.sensor[1])})
    circumstances, state = trial(declared=one)
    after = LIBRARY["accelerometer_mass"].apply(state, circumstances, {"mass": 0.0022})
    np.testing.assert_allclose(after.departures.added_mass, [0.0, 0.0, 0.0022])  # the hammer, and both sensors


def test_a_foundation_and_friction_act_per_area(trial):
    circumstances, state = trial()
    air = LIBRARY["air_loading"].apply(state, circumstances, {"added_mass_factor": 1.0, "radiation_factor": 1.0})
    after = LIBRARY["surface_damping"].apply(air, circumstances, {"resistance": 40.0})
    np.testing.assert_allclose(after.area_resistance - air.area_resistance, 40.0)
    assert LIBRARY["elastic_foundation"].apply(air, circumstances, {"stiffness": 3e6}).area_stiffness == 3e6
