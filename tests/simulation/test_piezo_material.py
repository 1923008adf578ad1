from dataclasses import replace
from typing import get_args

import pytest

from analysis.experiment import Patch
from simulation.shell.piezo_material import NCE51, PIEZO_MATERIALS, VACUUM_PERMITTIVITY, PiezoMaterial


def test_derived_constants_of_nce51():
    assert NCE51.youngs_modulus == pytest.approx(62.5e9)
    assert NCE51.e31 == pytest.approx(-195e-12 / (16e-12 * (1.0 - 0.34)))
    clamped = NCE51.permittivity * 0.02**2 / 0.0005
    assert clamped == pytest.approx(7.34e-9, rel=1e-3)  # data sheet values at 20 x 20 x 0.5 mm


@pytest.mark.parametrize(
    ("name", "k31", "kp"),
    [("NCE51", 0.37, 0.65), ("PIC255", 0.35, 0.62), ("PZT-5A", 0.344, 0.60), ("PZT-5H", 0.388, 0.65)],
)
def test_coupling_factors_of_the_data_sheet(name, k31, kp):
    """They are measured independently of d31, s11 and the permittivity."""
    material = PIEZO_MATERIALS[name]
    free = material.relative_permittivity * VACUUM_PERMITTIVITY
    found = abs(material.d31) / (free * material.compliance) ** 0.5
    assert found == pytest.approx(k31, rel=0.04)
    assert found * (2.0 / (1.0 - material.poisson_ratio)) ** 0.5 == pytest.approx(kp, rel=0.04)


def test_every_material_that_can_be_declared_is_known():
    assert set(get_args(Patch.model_fields["material"].annotation)) == set(PIEZO_MATERIALS)


def test_clamped_over_free_permittivity_follows_the_planar_coupling():
    free = NCE51.relative_permittivity * VACUUM_PERMITTIVITY
    kp_squared = 2.0 * NCE51.d31**2 / (free * NCE51.compliance * (1.0 - NCE51.poisson_ratio))
    assert NCE51.permittivity == pytest.approx(free * (1.0 - kp_squared))


@pytest.mark.parametrize(
    ("key", "value"), [("compliance", 0.0), ("poisson_ratio", 0.5), ("density", -1.0), ("d31", -600e-12)]
)
def test_nonsense_is_refused_by_name(key, value):
    with pytest.raises(ValueError, match=key.split("_")[0]):
        replace(NCE51, **{key: value})


def test_q11_and_q12_invert_the_compliance():
    q11, q12 = PiezoMaterial(2e-11, 0.3, -1e-10, 1000.0, 7500.0).stiffness
    s11, s12 = 2e-11, -0.3 * 2e-11
    assert q11 * s11 + q12 * s12 == pytest.approx(1.0)
    assert q11 * s12 + q12 * s11 == pytest.approx(0.0, abs=1e-12)
