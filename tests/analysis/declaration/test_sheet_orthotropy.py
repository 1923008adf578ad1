"""Orthotropic sheets: shares and moduli say the same, and isotropy is their zero."""

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.declaration.plate_material import DeclaredOrthotropy, PlateMaterial
from analysis.material import Orthotropy

SHEET = {"youngs_modulus_x": 3e9, "youngs_modulus_y": 3e9, "shear_modulus": 1e9}
SPRUCE = {"youngs_modulus_x": 12.1e9, "youngs_modulus_y": 0.999e9, "shear_modulus": 0.798e9}
RANGES = {"youngs_modulus": (3e9, 13e9), "poisson_ratio": (0.05, 0.3), "loss_factor": (0.004, 0.06)}


def test_moduli_and_shares_say_the_same() -> None:
    shares = DeclaredOrthotropy(delta_e=0.2, delta_g=0.1, angle=30.0).at(0.35)
    moduli = DeclaredOrthotropy(
        youngs_modulus_x=2.4e9, youngs_modulus_y=3.6e9, shear_modulus=1.1 * 3e9 / 2.7, angle=30.0
    ).at(0.35)
    assert (moduli.delta_e, moduli.delta_g) == pytest.approx((shares.delta_e, shares.delta_g))
    assert moduli.angle == shares.angle == pytest.approx(np.pi / 6)


def test_a_material_has_its_orthotropy_as_a_value() -> None:
    material = PlateMaterial(kind="pp-gf", orthotropy={"delta_e": 0.05, "delta_g": 0.02, "angle": 30})  # type: ignore[arg-type]
    assert material.departure == Orthotropy(0.05, 0.02, pytest.approx(np.pi / 6), (1.02, 1.02))
    assert PlateMaterial(kind="pp-gf").departure is None


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"delta_e": 0.1}, "either delta_e and delta_g, or youngs_modulus_x"),
        ({"delta_e": 0.1, "delta_g": 0.0, "shear_modulus": 1e9}, "all of one group and none of the other"),
        ({}, "either delta_e and delta_g"),
        ({"delta_e": 0.93, "delta_g": 0.0}, "delta_e"),
        ({"delta_e": 0.1, "delta_g": 0.0, "angle": 400.0}, "angle"),
        (
            {"youngs_modulus_x": 1e9, "youngs_modulus_y": 90e9, "shear_modulus": 1e9},
            "90 times the other; allowed up",
        ),
        ({"delta_e": 0.1, "delta_g": 0.0, "transverse_shear_modulus": 1e9}, "give delta_s, beside delta_e"),
        (
            {"youngs_modulus_x": 3e9, "youngs_modulus_y": 3e9, "shear_modulus": 1e9, "delta_s": 0.1},
            "give transverse_shear_modulus, beside shear_modulus",
        ),
        (
            {**SHEET, "transverse_shear_modulus": [1e9, 9e9]},
            r"transverse_shear_modulus .* Pa is 0\.91 to 8\.19 times an isotropic sheet's; allowed 0\.001 to 4",
        ),
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


def test_a_ratio_of_twelve_is_allowed_either_way() -> None:
    along = PlateMaterial(**RANGES, orthotropy=SPRUCE).departure  # type: ignore[arg-type]
    turned = {**SPRUCE, "youngs_modulus_x": 0.999e9, "youngs_modulus_y": 12.1e9}
    across = PlateMaterial(**RANGES, orthotropy=turned).departure  # type: ignore[arg-type]
    assert along is not None
    assert across is not None
    assert along.ratio == pytest.approx(0.999 / 12.1)
    assert across.ratio == pytest.approx(12.1 / 0.999)
    assert along.delta_e == -across.delta_e


def test_transverse_shear_is_that_of_the_plane_unless_it_is_declared() -> None:
    default = DeclaredOrthotropy(**SPRUCE).at(0.2)  # type: ignore[arg-type]
    assert default.transverse == pytest.approx((1.0 + default.delta_g,) * 2)
    assert not default.declared_transverse
    moduli = DeclaredOrthotropy(**SPRUCE, transverse_shear_modulus=(0.75e9, 0.05e9)).at(0.2)  # type: ignore[arg-type]
    isotropic = 0.25 * (12.1e9 + 0.999e9) / 1.2
    assert moduli.transverse == pytest.approx((0.75e9 / isotropic, 0.05e9 / isotropic))
    shares = DeclaredOrthotropy(
        delta_e=moduli.delta_e,
        delta_g=moduli.delta_g,
        delta_s=(moduli.transverse[0] - 1.0, moduli.transverse[1] - 1.0),
    )
    assert shares.at(0.4).transverse == pytest.approx(moduli.transverse)
    assert moduli.declared_transverse


def test_the_root_of_both_poisson_ratios_of_a_laminate_may_be_above_a_half() -> None:
    """A balanced laminate at 45 degrees has nu_xy = nu_yx of 0.7; an isotropic sheet cannot."""
    ranges = {**RANGES, "poisson_ratio": (0.6, 0.8)}
    assert PlateMaterial(**ranges, orthotropy={"delta_e": 0.0, "delta_g": 2.0}).box.poisson_ratio[1] == 0.8  # type: ignore[arg-type]
    with pytest.raises(ValidationError, match="up to 1 for orthotropic sheets only"):
        PlateMaterial(**ranges)  # type: ignore[arg-type]
