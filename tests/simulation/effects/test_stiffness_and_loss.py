"""Effects on moduli, bond and loss, against the definitions of ``recorded-campaign/1`` by hand."""

from dataclasses import replace

import numpy as np
import pytest

from simulation.effects.library import LIBRARY


def test_orthotropy_keeps_the_product_of_both_poisson_ratios(trial):
    """nu_xy nu_yx = nu**2 and nu_xy E_y = nu_yx E_x give Q12 = nu sqrt(1 - delta_e**2) E/(1 - nu**2)."""
    circumstances, state = trial()
    after = LIBRARY["orthotropy"].apply(state, circumstances, {"delta_e": 0.04, "delta_g": 0.1})
    youngs, nu = 2e9, 0.38
    along_x, along_y = youngs * after.modulus_x, youngs * after.modulus_y
    assert (along_x, along_y) == pytest.approx((1.92e9, 2.08e9))
    nu_xy = nu * np.sqrt(along_x / along_y)
    q12 = nu_xy * along_y / (1.0 - nu**2)
    assert q12 == pytest.approx(nu * np.sqrt(after.modulus_x * after.modulus_y) * youngs / (1.0 - nu**2))
    assert q12 == pytest.approx(nu * np.sqrt(1.0 - 0.04**2) * youngs / (1.0 - nu**2))
    assert after.in_plane_shear == pytest.approx(1.1)


@pytest.mark.parametrize(("temperature", "chi"), [(25.0, 1.0 / 1.1), (25.0 + 20.0 * np.log(3.0), 1.0 / 1.3)])
def test_a_bond_softens_exponentially_from_25_degrees(trial, temperature, chi):
    circumstances, state = trial(temperature=temperature)
    after = LIBRARY["bond_shear_lag"].apply(state, circumstances, {"gamma25": 0.1, "softening": 0.05})
    assert after.bond == pytest.approx(chi)


def test_kappa_of_one_is_the_local_kramers_kronig_slope(trial):
    """A constant loss angle delta goes with dln|E|/dln f = 2 delta/pi, on both parts of the modulus alike."""
    circumstances, state = trial(temperature=30.0, frequency=(499.9, 500.0, 500.1))
    after = LIBRARY["viscoelastic_dispersion"].apply(state, circumstances, {"kappa": 1.0})
    slope = np.log(after.storage[2] / after.storage[0]) / np.log(500.1 / 499.9)
    assert slope == pytest.approx(2.0 * 0.06 / np.pi)
    assert after.storage[1] == 1.0
    np.testing.assert_array_equal(after.loss, after.storage)


def test_a_modulus_stiffer_by_a_power_law_satisfies_kramers_kronig_exactly(trial):
    """(j f)**n has the loss angle n pi/2 at all frequencies: n = 2 kappa eta/pi asks for kappa eta = delta."""
    circumstances, state = trial(temperature=30.0, frequency=(125.0, 2000.0))
    after = LIBRARY["viscoelastic_dispersion"].apply(state, circumstances, {"kappa": np.arctan(0.06) / 0.06})
    angle = np.arctan(0.06)
    causal = (1j * np.array([125.0, 2000.0]) / 500.0) ** (2.0 * angle / np.pi)
    np.testing.assert_allclose(after.storage, np.abs(causal), rtol=1e-13)
    np.testing.assert_allclose(np.angle(causal), angle, rtol=1e-13)


def test_dispersion_takes_the_loss_factor_of_the_plates_temperature(trial):
    circumstances, state = trial(temperature=40.0, frequency=(1000.0,))
    after = LIBRARY["viscoelastic_dispersion"].apply(state, circumstances, {"kappa": 1.0})
    eta = 0.06 * np.exp(-0.01 * 10.0 + 0.5e-4 * 100.0)
    assert after.storage[0] == pytest.approx(2.0 ** (2.0 * eta / np.pi))


def test_viscous_friction_is_a_loss_factor_that_rises_as_frequency(trial):
    circumstances, state = trial(frequency=(250.0, 500.0, 1500.0))
    after = LIBRARY["damping_dispersion"].apply(state, circumstances, {"p": 1.0})
    np.testing.assert_allclose(after.loss, [0.5, 1.0, 3.0], rtol=1e-14)
    np.testing.assert_array_equal(after.storage, 1.0)


def test_twice_the_level_softens_four_times_as_much_up_to_the_cap(trial):
    circumstances, state = trial(frequency=(200.0, 300.0, 400.0))
    weak = replace(circumstances, strain_energy=np.array([0.1, 0.5, 1.0]))
    strong = replace(circumstances, strain_energy=4.0 * weak.strain_energy)
    stronger = replace(circumstances, strain_energy=16.0 * weak.strain_energy)
    effect, values = LIBRARY["amplitude_softening"], {"a": 0.05, "b": 0.08}
    assert effect.needs_strain_energy
    once, twice, four = (effect.apply(state, c, values) for c in (weak, strong, stronger))
    np.testing.assert_allclose(once.storage, [0.995, 0.975, 0.95], rtol=1e-14)
    np.testing.assert_allclose(once.loss, [1.003, 1.015, 1.03], rtol=1e-14)
    np.testing.assert_allclose(1.0 - twice.storage, 4.0 * (1.0 - once.storage), rtol=1e-12)
    np.testing.assert_allclose(four.storage, [1.0 - 0.05 * 1.6, 0.8, 0.8], rtol=1e-14)  # e = 1.6, 8 and 16


def test_moduli_stay_positive_at_the_ends_of_every_range(experiment, trial):
    circumstances, state = trial(frequency=(100.0, 1500.0))
    circumstances = replace(circumstances, strain_energy=np.array([2.0, 9.0]))
    for name in ("orthotropy", "amplitude_softening", "thickness_taper", "local_damage", "bond_shear_lag"):
        card = LIBRARY[name].card(experiment)
        for choice in range(2 ** len(card.parameters)):
            values = {p.name: p.high if choice >> k & 1 else p.low for k, p in enumerate(card.parameters)}
            after = LIBRARY[name].apply(state, circumstances, values)
            factors = [after.modulus_x, after.modulus_y, after.in_plane_shear, after.bond]
            factors += [*after.storage, *after.loss, *after.thickness, *(1.0 - d.loss for d in after.discs)]
            assert min(factors) > 0.0, (name, values)


def test_a_lossless_bulk_modulus_is_kept_real(trial):
    """K = E/(3 (1 - 2 nu)) with complex E and nu is real, and Q and G follow, to first order in eta."""
    circumstances, state = trial(temperature=30.0)
    after = LIBRARY["poisson_loss"].apply(state, circumstances, {"kappa": 1.0})
    eta, youngs, nu = 1e-5, 2e9 * (1.0 + 1e-5j), 0.38 - 1e-5j * 0.12
    assert abs(np.imag(youngs / (1.0 - 2.0 * nu))) < 1e-4 * eta * abs(youngs / (1.0 - 2.0 * nu))
    q11, shear = youngs / (1.0 - nu**2), youngs / (2.0 * (1.0 + nu))
    for modulus, found in ((q11, after.loss_x), (nu * q11, after.loss_cross), (shear, after.loss_shear)):
        assert found == pytest.approx(modulus.imag / modulus.real / eta, rel=1e-4)
    assert after.loss_y == after.loss_x


def test_loss_by_direction(trial):
    circumstances, state = trial()
    after = LIBRARY["loss_orthotropy"].apply(state, circumstances, {"delta_eta": 0.2, "delta_shear": 0.5})
    assert (after.loss_x, after.loss_y, after.loss_cross, after.loss_shear) == (0.8, 1.2, 1.0, 1.5)
    assert (after.modulus_x, after.modulus_y) == (1.0, 1.0)


def test_a_relaxation_is_zeners_solid(trial):
    """At its own frequency half of the strength is stored and half is lost; far above all is stored."""
    circumstances, state = trial(temperature=30.0, frequency=(400.0, 4e5))
    after = LIBRARY["relaxation"].apply(state, circumstances, {"strength": 0.02, "frequency": 400.0})
    np.testing.assert_allclose(after.storage, [1.01, 1.02], rtol=1e-6)
    np.testing.assert_allclose(0.06 * (after.loss - 1.0), [0.01, 0.02e-3], rtol=1e-4)


def test_a_relaxation_satisfies_kramers_and_kronig(trial):
    """Stored at f less stored at rest: 2 f**2/pi times the integral of the loss at x over x (f**2 - x**2)."""
    x = 300.0 * np.exp(np.linspace(-12.0, 12.0, 48_001) + 2.5e-4)  # symmetric about the pole: its principal value
    circumstances, state = trial(temperature=30.0, frequency=(300.0, *x))
    after = LIBRARY["relaxation"].apply(state, circumstances, {"strength": 0.1, "frequency": 700.0})
    lost = 0.06 * (after.loss[1:] - 1.0)
    stored = 2.0 * 300.0**2 / np.pi * np.trapezoid(lost / (300.0**2 - x**2), np.log(x))
    assert after.storage[0] - 1.0 == pytest.approx(stored, rel=1e-3)


@pytest.mark.parametrize("order", [0.3, 0.8])
def test_a_fractional_dashpot_and_a_spring_are_the_whole_modulus(trial, order):
    """E_0 + E_1 (j f)**order with the laws' modulus and a third of their loss at 500 Hz, the rest constant."""
    frequency, eta, share = np.array([125.0, 500.0, 2000.0]), 0.06, 1.0 / 3.0
    circumstances, state = trial(temperature=30.0, frequency=tuple(frequency))
    after = LIBRARY["fractional_viscosity"].apply(state, circumstances, {"share": share, "order": order})
    dashpot = share * eta / np.sin(0.5 * np.pi * order) * ((1j * frequency / 500.0) ** order - 1j**order)
    np.testing.assert_allclose(after.storage + 1j * eta * after.loss, 1.0 + 1j * eta + dashpot, rtol=1e-13)


def test_a_fractional_dashpot_of_order_zero_is_the_viscoelastic_dispersion(trial):
    circumstances, state = trial(temperature=30.0, frequency=(125.0, 2000.0))
    dashpot = LIBRARY["fractional_viscosity"].apply(state, circumstances, {"share": 1e-4, "order": 1e-4})
    dispersion = LIBRARY["viscoelastic_dispersion"].apply(state, circumstances, {"kappa": 1e-4})
    np.testing.assert_allclose(dashpot.storage - 1.0, dispersion.storage - 1.0, rtol=1e-3)


def test_annealing_is_there_on_the_way_down_only(trial):
    for rate, storage, loss in ((0.01, 1.0, 1.0), (-0.01, 1.05, 1.05 * 0.8)):
        circumstances, state = trial(rate=rate)
        after = LIBRARY["annealing"].apply(state, circumstances, {"stiffening": 0.05, "loss": -0.2})
        np.testing.assert_allclose(after.storage, storage)
        np.testing.assert_allclose(after.loss, loss)


def test_patches_come_off_one_by_one(trial):
    circumstances, state = trial()
    once = LIBRARY["patch_debond"].apply(state, circumstances, {"A1": 0.1, "S1": 0.0})
    np.testing.assert_allclose(once.debonded, [0.1, 0.0])
    twice = LIBRARY["patch_debond"].apply(once, circumstances, {"A1": 0.1, "S1": 0.2})
    np.testing.assert_allclose(twice.debonded, [1.0 - 0.9**2, 0.2])
