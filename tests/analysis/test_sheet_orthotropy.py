"""Orthotropic sheets: shares and moduli say the same, and isotropy is their zero."""

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.plate_material import PlateMaterial
from analysis.sheet_orthotropy import DeclaredOrthotropy, Orthotropy


def test_moduli_and_shares_say_the_same() -> None:
    shares = DeclaredOrthotropy(delta_e=0.2, delta_g=0.1, angle=30.0).at(0.35)
    moduli = DeclaredOrthotropy(
        youngs_modulus_x=2.4e9, youngs_modulus_y=3.6e9, shear_modulus=1.1 * 3e9 / 2.7, angle=30.0
    ).at(0.35)
    assert (moduli.delta_e, moduli.delta_g) == pytest.approx((shares.delta_e, shares.delta_g))
    assert moduli.angle == shares.angle == pytest.approx(np.pi / 6)


def test_a_material_has_its_orthotropy_as_a_value() -> None:
    material = PlateMaterial(kind="pp-gf", orthotropy={"delta_e": 0.05, "delta_g": 0.02, "angle": 30})  # type: ignore[arg-type]
    assert material.departure == Orthotropy(0.05, 0.02, pytest.approx(np.pi / 6))
    assert PlateMaterial(kind="pp-gf").departure is None


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"delta_e": 0.1}, "either delta_e and delta_g, or youngs_modulus_x"),
        ({"delta_e": 0.1, "delta_g": 0.0, "shear_modulus": 1e9}, "all of one group and none of the other"),
        ({}, "either delta_e and delta_g"),
        ({"delta_e": 0.9, "delta_g": 0.0}, "delta_e"),
        ({"delta_e": 0.1, "delta_g": 0.0, "angle": 400.0}, "angle"),
        ({"youngs_modulus_x": 1e9, "youngs_modulus_y": 90e9, "shear_modulus": 1e9}, r"is 0\.978; allowed"),
        ({"youngs_modulus_x": 1e9, "youngs_modulus_y": 1e9, "shear_modulus": 9e9}, "times an isotropic sheet's"),
        (
            {"youngs_modulus_x": 40e9, "youngs_modulus_y": 60e9, "shear_modulus": 18e9},
            r"youngs_modulus_y is 5e\+10 Pa, the material's youngs_modulus \[1.8e\+09, 1.1e\+10\] Pa",
        ),
    ],
)
def test_nonsense_is_refused(table: dict[str, float], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        PlateMaterial(kind="pp-gf", orthotropy=table)  # type: ignore[arg-type]
