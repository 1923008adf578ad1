import numpy as np
import pytest

from tests.simulation.verification.exact_plates import roots


def test_roots_of_a_polynomial_are_found_with_none_between():
    wanted = np.array([0.5, 2.0, 2.0004, 7.3, 9.9])
    found = roots(lambda f: np.prod(f[:, None] - wanted, axis=1), 0.1, 10.0)
    assert found == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6])
def test_two_roots_between_neighbouring_samples_are_both_found(distance):
    wanted = 3.0 + distance * np.array([-0.5, 0.5])
    found = roots(lambda f: np.prod(f[:, None] - wanted, axis=1), 0.1, 10.0, step=0.05)
    assert found == pytest.approx(wanted, abs=1e-3 * distance)


def test_a_minimum_that_stays_above_zero_is_no_root():
    assert roots(lambda f: (f - 3.0) ** 2 + 1e-8, 0.1, 10.0).size == 0


def test_a_sign_that_changes_at_a_break_is_no_root():
    found = roots(lambda f: np.sign(f - 4.0) * (f - 2.0) * (f - 4.0) ** 2, 0.1, 10.0, breaks=[4.0])
    assert found == pytest.approx([2.0])


@pytest.mark.parametrize(("lowest", "highest"), [(0.0, 1.0), (2.0, 1.0)])
def test_a_range_that_is_none_is_refused(lowest, highest):
    with pytest.raises(ValueError, match="allowed 0 < lowest < highest"):
        roots(np.sin, lowest, highest)
