"""Gaps of campaigns whose declaration, or whose theory, is not exact: what is named, and its σ.

The first two are of a plate whose declaration has the errors of a careful workshop, the others of an aluminium L
computed as a solid. Each is as its README says.
"""

from pathlib import Path

import numpy as np
import pytest

from app.files.campaigns.loading import load_campaign
from app.stages.gap import GapComparison, GapRequest, compute

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "campaigns"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.shared,
    pytest.mark.skipif(not FOLDER.is_dir(), reason="the recorded campaigns are not beside the checkout"),
]


def compared(name: str) -> GapComparison:
    return compute(GapRequest(load_campaign(FOLDER / name)), lambda stage, share: None)


@pytest.mark.parametrize("name", ["pp-plate-tolerances", "solid-l-null"])
def test_nothing_is_claimed_where_nothing_is_hidden(name: str) -> None:
    found = compared(name)
    assert found.report.verdict == "none"
    assert not found.report.effects
    assert not any(one.beyond for one in found.report.declared)


@pytest.mark.parametrize(
    ("name", "mass"), [("pp-plate-tolerances-mass", 0.860209e-3), ("solid-l-mass", 4e-3)], ids=["plate", "solid L"]
)
def test_a_hidden_mass_is_named_within_its_deviation(name: str, mass: float) -> None:
    found = compared(name)
    (effect,) = found.report.effects
    assert effect.name == "point_mass"
    assert set(effect.equivalent) <= {"mass_at_place"}  # the same mass, its place not taken as declared
    assert effect.probability > 0.9
    (parameter,) = effect.parameters
    assert abs(parameter.value / mass - 1.0) < 0.03
    assert abs(parameter.value - mass) < 2.0 * parameter.sigma
    assert found.report.held_out[0].closure > 0.99
    assert "point_mass" in found.corrected.effects  # the twin file carries it


def test_a_solid_has_what_plate_theory_leaves_out() -> None:
    """Its share is one; it is found to some tenths, beside thickness and modulus."""
    declared = {one.name: one for one in compared("solid-l-null").report.declared}
    share = declared["plate_theory"]
    assert abs(share.value - 1.0) < 3.0 * share.sigma
    assert share.value == pytest.approx(1.0, abs=0.3)
    assert np.isfinite(share.sigma)
