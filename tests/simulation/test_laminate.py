import numpy as np
import pytest

from simulation.laminate import Elasticity, Layer, patch_layer


def test_moments_are_integrals_over_the_thickness():
    layer = Layer(0.0005, 0.00175)
    z, w = np.polynomial.legendre.leggauss(4)
    z, w = layer.height + 0.5 * layer.thickness * z, 0.5 * layer.thickness * w
    assert layer.moments == pytest.approx([(w * z**k).sum() for k in (0, 1, 2)])


def test_layers_add_up_to_one_thick_layer():
    lower, upper = Layer(0.003), patch_layer(0.003, 0.001, "top")
    whole = Layer(0.004, 0.0005)
    assert np.add(lower.moments, upper.moments) == pytest.approx(whole.moments)


def test_bottom_mirrors_top():
    top, bottom = patch_layer(0.003, 0.0005, "top"), patch_layer(0.003, 0.0005, "bottom")
    assert np.multiply(top.moments, (1, -1, 1)) == pytest.approx(bottom.moments)


def test_isotropic_shear_modulus():
    e, nu = 2e9, 0.37
    c1 = e / (1 - nu**2)
    elasticity = Elasticity.isotropic(c1, nu * c1)
    assert elasticity.q66 == pytest.approx(e / (2 * (1 + nu)))
    assert elasticity.g == elasticity.q66
