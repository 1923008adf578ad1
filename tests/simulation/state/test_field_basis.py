"""Fields as polynomials: exact where they are polynomials, closest where they are not."""

import numpy as np
import pytest

from simulation.state.field_basis import field_basis, polynomial, polynomials

DEGREE = 3


def test_the_constant_comes_first_and_degrees_ascend():
    terms = polynomials(DEGREE)
    assert terms[0] == (0, 0)
    assert len(set(terms)) == len(terms) == (DEGREE + 1) * (DEGREE + 2) // 2
    assert [sum(t) for t in terms] == sorted(sum(t) for t in terms)


def test_polynomials_come_back_as_they_were():
    basis = field_basis(DEGREE)
    for k, degrees in enumerate(polynomials(DEGREE)):
        found = basis.coefficients(polynomial(degrees, basis.xi, basis.zeta))
        np.testing.assert_allclose(found, np.eye(len(found))[k], atol=1e-13)


def test_what_is_not_representable_is_orthogonal_to_what_is():
    basis = field_basis(DEGREE)
    left_out = polynomial((4, 0), basis.xi, basis.zeta) + polynomial((2, 2), basis.xi, basis.zeta)
    np.testing.assert_allclose(basis.coefficients(left_out), 0.0, atol=1e-13)


def test_a_smooth_field_is_met_ever_closer():
    errors = []
    for degree in (1, 2, 3):
        basis = field_basis(degree)
        field = np.exp(0.1 * basis.xi - 0.05 * basis.zeta)
        terms = [polynomial(d, basis.xi, basis.zeta) for d in polynomials(degree)]
        errors.append(np.abs(basis.coefficients(field) @ np.array(terms) - field).max())
    assert errors[1] < errors[0] / 10.0
    assert errors[2] < errors[1] / 10.0


def test_complex_fields_have_complex_coefficients():
    """What makes a complex step of any field one of its coefficients."""
    basis = field_basis(DEGREE)
    field = 2.0 + basis.xi * (1.0 + 3e-30j)
    found = basis.coefficients(field)
    assert found[polynomials(DEGREE).index((1, 0))].imag == pytest.approx(3e-30, rel=1e-12)
