import numpy as np
import pytest

from simulation.shell.electric_load import ElectricLoad

F = np.array([100.0, 450.0, 1500.0])


def random_compliance(k, rng):
    a = rng.standard_normal((k, k, F.size)) + 1j * rng.standard_normal((k, k, F.size))
    return 1e-9 * (a + a.transpose(1, 0, 2))


def test_one_sensor_divides_by_everything_across_it():
    rng = np.random.default_rng(0)
    g, h = random_compliance(1, rng), 1e-11 * rng.standard_normal((1, F.size)).astype(complex)
    load = ElectricLoad(305e3, 120e-12)
    expected = -h / (7.3e-9 + 120e-12 + 1 / (1j * 2 * np.pi * F * 305e3) + g[0])
    assert np.allclose(load.voltages(h, g, np.array([7.3e-9]), F), expected, rtol=1e-12)


def test_sensors_satisfy_their_charge_balance():
    """Charge q = b'u - Cp V leaves every patch through its own input: q = (Cc + 1/(jwR)) V."""
    rng = np.random.default_rng(1)
    g, h, c = random_compliance(3, rng), random_compliance(3, rng)[0], np.array([7e-9, 8e-9, 6e-9])
    load = ElectricLoad(1e5, 3e-10)
    v = load.voltages(h, g, c, F)
    deformation = -h - np.einsum("ikf,kf->if", g, v)
    charge = deformation - c[:, None] * v
    assert np.allclose(charge, (3e-10 + 1 / (1j * 2 * np.pi * F * 1e5)) * v, rtol=1e-12)


def test_phase_of_an_unmoved_patch_on_a_resistive_input():
    """physics: 305 kohm turns a 7.34 nF patch by about 35 degrees at 100 Hz without stiffness loading."""
    h = np.full((1, F.size), -1e-11, complex)
    v = ElectricLoad(305e3).voltages(h, np.zeros((1, 1, F.size)), np.array([7.34e-9]), F)
    assert np.angle(v[0]) == pytest.approx(np.arctan(1 / (2 * np.pi * F * 305e3 * 7.34e-9)))


@pytest.mark.parametrize(("r", "c"), [(0.0, 0.0), (-1.0, 0.0), (1e5, -1e-12), (float("nan"), 0.0)])
def test_nonsense_is_refused(r, c):
    with pytest.raises(ValueError, match="input"):
        ElectricLoad(r, c)
