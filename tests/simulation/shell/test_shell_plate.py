"""Elastic edges, orthotropic sheets and patches that overlap on opposite faces, against closed forms."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import SHEAR_FACTOR
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import Unknowns

A, B, H, DENSITY = 0.2, 0.15, 0.004, 1000.0
MASS = A * B * H * DENSITY
E, NU = 2e9, 0.35
RECIPE = MeshRecipe(spacing=0.08)


def rectangle(**more) -> Plate:
    return Plate(length_x=A, length_y=B, thickness=H, mass=MASS, **more)


def model(degree: int = 5, **more) -> ShellModel:
    return assemble(rectangle(**more), recipe=RECIPE, degree=degree)


def bending(model: ShellModel, count: int) -> Real:
    """Lowest frequencies of a flat bare plate's deflection and rotations, Hz."""
    kept = np.flatnonzero(model.unknowns.chosen // model.space.size >= 2)
    parts = {
        name: getattr(model, name)[kept][:, kept]
        for name in ("stiffness_1", "stiffness_2", "stiffness_patch", "mass")
    }
    unknowns = Unknowns(model.space, model.unknowns.chosen[kept])
    return replace(model, unknowns=unknowns, **parts).eigenfrequencies(E, NU, count)


def test_on_soft_springs_along_its_edges_a_plate_heaves_and_tilts() -> None:
    """Of a stiff body: k times the perimeter over the mass, and k times the second moment of the edges."""
    k = 50.0
    found = bending(model(support=({"kind": "elastic", "edge": "all", "translation": k},)), 3)
    about_y = k * (A**3 / 6 + B * A**2 / 2) / (MASS * (A**2 + H**2) / 12)
    about_x = k * (B**3 / 6 + A * B**2 / 2) / (MASS * (B**2 + H**2) / 12)
    heave = k * 2 * (A + B) / MASS
    assert found == pytest.approx(np.sort(np.sqrt([heave, about_x, about_y])) / (2 * np.pi), rel=1e-3)


def test_a_hinged_plate_swings_on_the_spring_of_its_hinge() -> None:
    """A stiffness k b over the moment of inertia about the left edge."""
    k = 0.02
    hinge = {"kind": "soft-simple", "edge": "left"}
    soft = {"kind": "elastic", "edge": "left", "translation": 1e9, "rotation": k}
    inertia = MASS * (A**2 / 3 + H**2 / 12)
    found = bending(model(support=(soft,)), 1)
    assert found == pytest.approx(np.sqrt(k * B / inertia) / (2 * np.pi), rel=1e-3)
    assert bending(model(support=(hinge,)), 1) < 1e-3 * found


def test_stiff_springs_hold_as_supports_do() -> None:
    simple = bending(model(support=({"kind": "soft-simple", "edge": "all"},)), 4)
    stiff = bending(model(support=({"kind": "elastic", "edge": "all", "translation": 1e12},)), 4)
    assert stiff == pytest.approx(simple, rel=1e-5)
    clamped = bending(model(boundary="clamped"), 4)
    both = {"kind": "elastic", "edge": "all", "translation": 1e12, "rotation": 1e9}
    assert bending(model(support=(both,)), 4) == pytest.approx(clamped, rel=5e-3)  # the edge may still twist
    assert (clamped > 1.3 * simple).all()


def sheet(
    delta_e: float, delta_g: float, angle: float = 0.0, delta_s: float | tuple[float, float] | None = None
) -> dict:
    orthotropy = {"delta_e": delta_e, "delta_g": delta_g, "angle": angle, "delta_s": delta_s}
    return {"kind": "pp-gf", "orthotropy": orthotropy}


@pytest.mark.parametrize(
    ("delta_e", "delta_g", "delta_s"),
    [(0.3, -0.2, (0.0, 0.0)), (-0.846, -0.72, (-0.74, -0.98)), (0.846, -0.72, (-0.98, -0.74))],
    ids=["fibres", "spruce", "spruce across"],
)
def test_an_orthotropic_sheet_on_hard_supports_is_naviers(
    delta_e: float, delta_g: float, delta_s: tuple[float, float]
) -> None:
    """As of the isotropic plate, with D11, D22, D12, D66 and with transverse shear by plane; ratios up to 12."""
    c = E / (1 - NU**2) * H**3 / 12
    d11, d22, d12 = (1 - delta_e) * c, (1 + delta_e) * c, NU * np.sqrt(1 - delta_e**2) * c
    d66 = (1 + delta_g) * E / (2 * (1 + NU)) * H**3 / 12
    sx, sy = (SHEAR_FACTOR * (1 + one) * E / (2 * (1 + NU)) * H for one in delta_s)
    exact = []
    for m, n in product(range(1, 7), repeat=2):
        p, q = m * np.pi / A, n * np.pi / B
        stiffness = np.array(
            [
                [sx * p**2 + sy * q**2, sx * p, sy * q],
                [sx * p, d11 * p**2 + d66 * q**2 + sx, (d12 + d66) * p * q],
                [sy * q, (d12 + d66) * p * q, d22 * q**2 + d66 * p**2 + sy],
            ]
        )
        mass = DENSITY * np.diag([H, H**3 / 12, H**3 / 12])
        exact.append(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min()) / (2 * np.pi))
    material, support = sheet(delta_e, delta_g, delta_s=delta_s), ({"kind": "hard-simple", "edge": "all"},)
    wanted = np.sort(exact)[:5]
    errors = [
        np.abs(bending(model(degree, support=support, material=material), 5) / wanted - 1).max()
        for degree in (4, 6, 8)
    ]
    assert errors[1] < 3e-4
    assert errors[2] < 2e-5
    assert errors[2] < 0.2 * errors[1] < 0.04 * errors[0] + 1e-9


def test_a_quarter_turn_swaps_the_axes_of_a_sheet() -> None:
    materials = sheet(0.3, -0.1, 90.0, (-0.9, -0.2)), sheet(-0.3, -0.1, 0.0, (-0.2, -0.9))
    turned, swapped = (model(3, material=m) for m in materials)
    for name in ("stiffness_1", "stiffness_2"):
        one, other = getattr(turned, name), getattr(swapped, name)
        assert abs(one - other).max() < 1e-12 * abs(other).max()


def test_a_turned_sheet_is_a_turned_plate() -> None:
    """Fibres at 20 degrees in a plate as it lies, at 50 degrees in the plate turned by 30."""
    outline = {"kind": "rectangle", "center": (0.0, 0.0), "size": (A, B), "angle": 30.0}
    turned = Plate(outline=outline, thickness=H, mass=MASS, material=sheet(0.3, -0.2, 50.0))
    wanted = bending(model(7, material=sheet(0.3, -0.2, 20.0)), 10)[3:]
    found = bending(assemble(turned, recipe=RECIPE, degree=7), 10)[3:]
    assert found == pytest.approx(wanted, rel=1e-4)
    assert (
        np.abs(bending(model(7, material=sheet(0.3, -0.2, -20.0)), 10)[3:] / wanted - 1).max() < 1e-4
    )  # mirrored
    assert np.abs(bending(model(material=sheet(0.3, -0.2, 70.0)), 10)[3:] / wanted - 1).max() > 0.02


def test_patches_that_overlap_in_part_on_opposite_faces_are_the_sum_of_both() -> None:
    """On one mesh for both, each leaves what it has alone; where they overlap, offsets cancel."""
    above = Patch(id="A", role="actuator", center=(0.08, 0.07), size=(0.04, 0.03), thickness=0.0005)
    below = Patch(id="S", role="sensor", center=(0.10, 0.08), size=(0.03, 0.03), thickness=0.0005, side="bottom")
    both = assemble(rectangle(), [above, below], recipe=MeshRecipe(spacing=0.08, grading=0.0, pieces=1), degree=3)
    shell = both.shell
    common = shell.under[0] & shell.under[1]
    assert 0 < common.sum() < min(under.sum() for under in shell.under)
    for patch, under in zip(shell.patches, shell.under, strict=True):
        assert shell.space.dx[shell.space.spread(under)].sum() == pytest.approx(patch.area, rel=1e-9)
    alone = []
    for k in (0, 1):
        names = {name: cells for name, cells in shell.space.mesh.inside.items() if name != f"patch {k + 1}"}
        names[f"patch {k + 1}"] = np.zeros_like(common)
        mesh = replace(shell.space.mesh, inside=names)
        without = replace(shell, space=replace(shell.space, mesh=mesh))
        alone.append(both.unknowns.matrix(without.cells.of(without.patch_stiffness(without.thickness))))
    assert abs(alone[0] + alone[1] - both.stiffness_patch).max() < 1e-12 * abs(both.stiffness_patch).max()
    entries = dict(shell.patch_stiffness(shell.thickness).entries)
    assert np.abs(entries[0, 3][common]).max() < 1e-9 * np.abs(entries[0, 3]).max()
    g = both.compliance(E, NU, 0.05, [300.0])
    assert g[0, 1] == pytest.approx(g[1, 0], rel=1e-9)
