"""In-plane stiffness of sheets against the engineering moduli that their declaration promises."""

import numpy as np
import pytest

from analysis.material import Orthotropy
from simulation.shell.rigidity import matrix, moduli, plane_stress_moduli, transverse


def test_no_departure_is_the_isotropic_sheet() -> None:
    q11, q22, q12, q66, q16, q26 = moduli(Orthotropy(0.0, 0.0), *plane_stress_moduli(2e9, 0.4))
    assert (q11, q12, q66, q16, q26) == pytest.approx((q22, 0.4 * q11, 0.5 * (q11 - q12), 0.0, 0.0))
    assert q11 == pytest.approx(2e9 / 0.84)


@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_moduli_are_those_of_uniaxial_stress(angle: float) -> None:
    """Along the sheet's own axes compliance is 1/Ex and 1/Ey, and nu_xy nu_yx is nu squared."""
    q = matrix(moduli(Orthotropy(0.2, 0.1, angle), *plane_stress_moduli(3e9, 0.35)))
    c, s = np.cos(angle), np.sin(angle)
    stress = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]).T
    compliance = stress.T @ np.linalg.inv(np.array(q, float)) @ stress
    assert 1.0 / np.diag(compliance) == pytest.approx([2.4e9, 3.6e9, 1.1 * 3e9 / 2.7])
    assert compliance[0, 1] ** 2 / (compliance[0, 0] * compliance[1, 1]) == pytest.approx(0.35**2)
    assert compliance[:2, 2] / compliance[0, 0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_transverse_shear_turns_as_a_tensor() -> None:
    """Along the sheet's own axes the stiffness is that declared, wherever these lie."""
    angle, factors = 0.4, (0.3, 0.02)
    xx, yy, xy = transverse(Orthotropy(-0.8, -0.7, angle, factors), 2e9)
    tensor = np.array([[xx, xy], [xy, yy]])
    for turn, factor in zip((angle, angle + 0.5 * np.pi), factors, strict=True):
        along = np.array([np.cos(turn), np.sin(turn)])
        assert tensor @ along == pytest.approx(factor * 2e9 * along, abs=1e-3)
