"""Plates with patches: laminate theory, capacitance, inertia, reciprocity, and one plate declared in many ways."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.piezo_material import NCE51, VACUUM_PERMITTIVITY
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize


def rigid(model: ShellModel, field: int, factor: Real | float = 1.0) -> Real:
    """Unknowns of a unit translation or rotation field, times a linear function given at the mesh's points."""
    space = model.space
    value = np.zeros(space.size)
    value[: len(space.mesh.points)] = factor
    return model.unknowns.vector({field: value})


def test_patches_near_the_corners_lower_the_first_mode(plate: Plate, coarse_mesh: MeshRecipe) -> None:
    """By 3.6 % with 20 x 20 x 0.5 mm patches 20 mm from opposite corners: mass wins where nothing bends."""
    patches = [
        Patch(id=i, role=role, center=c, size=(0.02, 0.02), thickness=0.0005)
        for i, role, c in (("A", "actuator", (0.02, 0.02)), ("S", "sensor", (0.22, 0.17)))
    ]
    bare, loaded = (
        assemble(plate, some, recipe=coarse_mesh, degree=5).eigenfrequencies(2.26e9, 0.37, 8)
        for some in ((), patches)
    )
    assert loaded[6] / bare[6] - 1 == pytest.approx(-0.036, abs=0.001)


def test_mass_weighs_plate_and_patches(plate: Plate, coarse_model: ShellModel) -> None:
    total = plate.mass + 3 * NCE51.density * 0.02**2 * 0.0005
    for field in range(3):
        motion = rigid(coarse_model, field)
        assert motion @ coarse_model.mass @ motion == pytest.approx(total, rel=1e-10)


def test_rotary_inertia_and_offset_moment(plate: Plate, coarse_model: ShellModel) -> None:
    """Two patches on top, one below: one lever is left."""
    u, tilt = rigid(coarse_model, 0), rigid(coarse_model, 3)
    patch_mass, height, thickness = NCE51.density * 0.02**2 * 0.0005, 0.00175, 0.0005
    assert u @ coarse_model.mass @ tilt == pytest.approx(patch_mass * height, rel=1e-9)
    expected = plate.mass * 0.003**2 / 12 + 3 * patch_mass * (height**2 + thickness**2 / 12)
    assert tilt @ coarse_model.mass @ tilt == pytest.approx(expected, rel=1e-9)


def test_rigid_motion_costs_no_energy(coarse_model: ShellModel) -> None:
    stiffness = coarse_model.stiffness(2e9, 0.38)
    scale = np.abs(stiffness.diagonal()).max()
    x = coarse_model.space.mesh.points[:, 0]
    tilted = rigid(coarse_model, 2, x) - rigid(coarse_model, 3)  # w = x, thx = -1
    for motion in (*(rigid(coarse_model, field) for field in range(3)), tilted):
        assert np.abs(stiffness @ motion).max() < 1e-11 * scale
    assert np.abs(coarse_model.coupling.T @ tilted).max() < 1e-12


def test_reciprocity_between_unequal_patches(plate: Plate, coarse_mesh: MeshRecipe) -> None:
    patches = [
        Patch(id="A", role="actuator", center=(0.05, 0.05), size=(0.03, 0.02), thickness=0.0005, angle=20.0),
        Patch(id="S", role="sensor", center=(0.18, 0.12), diameter=0.02, thickness=0.0003, side="bottom"),
    ]
    g = assemble(plate, patches, recipe=coarse_mesh, degree=4).compliance(2e9, 0.38, 0.06, [150.0, 800.0])
    np.testing.assert_allclose(g[0, 1], g[1, 0], rtol=1e-9)


def test_faces_are_mirror_images(plate: Plate, patches: list[Patch], coarse_mesh: MeshRecipe) -> None:
    below = [p.model_copy(update={"side": "bottom"}) for p in patches]
    top, bottom = (
        assemble(plate, some, recipe=coarse_mesh, degree=3).compliance(2e9, 0.38, 0.06, [220.0, 640.0])
        for some in (patches, below)
    )
    np.testing.assert_allclose(top, bottom, rtol=1e-8)


def test_patch_on_a_plate_of_no_stiffness_has_the_free_capacitance(
    plate: Plate, patches: list[Patch], coarse_mesh: MeshRecipe
) -> None:
    """Charge per volt at rest is Cp + b' K^-1 b: with nothing to hold the patch, eps33T A / h."""
    model = assemble(plate, patches[:1], recipe=coarse_mesh, degree=4)
    stiffness = model.stiffness(1e3, 0.3) + 1e-2 * model.mass  # the mass holds the rigid motion
    give = model.coupling[:, 0] @ factorize(stiffness).solve(model.coupling[:, 0])
    free = 1850 * VACUUM_PERMITTIVITY * 0.02**2 / 0.0005
    assert model.capacitance[0] + give == pytest.approx(free, rel=1e-4)
    held = model.stiffness(1e15, 0.3) + 1e-2 * model.mass
    assert model.coupling[:, 0] @ factorize(held).solve(model.coupling[:, 0]) < 1e-3 * free


@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_fully_covered_plate_bends_as_laminate_theory_says(angle: float) -> None:
    """A free plate under a whole-face patch strains and curves alike in all directions: two equations."""
    outline = {"kind": "rectangle", "center": (0.05, 0.04), "size": (0.1, 0.08), "angle": angle}
    plate = Plate(outline=outline, thickness=0.003, mass=0.0228)
    patch = Patch(id="A", role="actuator", center=(0.05, 0.04), size=(0.1, 0.08), thickness=0.0005, angle=angle)
    model = assemble(plate, [patch], recipe=MeshRecipe(spacing=0.08, grading=0.0, pieces=1), degree=4)
    e, nu = 2.2e9, 0.37
    answer = factorize(model.stiffness(e, nu) + 1e-3 * model.mass).solve(model.coupling[:, 0])
    biaxial, z = np.array([e / (1 - nu), NCE51.youngs_modulus / (1 - NCE51.poisson_ratio)]), 0.00175
    a = biaxial @ [0.003, 0.0005]
    b = biaxial[1] * 0.0005 * z
    d = biaxial @ [0.003**3 / 12, 0.0005 * z**2 + 0.0005**3 / 12]
    strain, curvature = np.linalg.solve([[a, b], [b, d]], NCE51.e31 * np.array([1.0, z]))
    expected = NCE51.e31 * 2 * (strain + z * curvature) * 0.1 * 0.08
    assert model.coupling[:, 0] @ answer == pytest.approx(expected, rel=1e-6)
    sag = model.deflection(np.array([(0.01, 0.04), (0.05, 0.04), (0.09, 0.04)])) @ answer
    assert sag[1] - 0.5 * (sag[0] + sag[2]) == pytest.approx(0.5 * curvature * 0.04**2, rel=1e-6)


def test_affine_parts_add_up_to_any_material(coarse_model: ShellModel) -> None:
    """K is linear in C1 and C2: three materials determine a fourth."""
    whole = coarse_model.stiffness(3e9, 0.4, 0.1)
    c1 = 3e9 / (1 - 0.16)
    parts = (1 + 0.1j) * c1 * (coarse_model.stiffness_1 + 0.4 * coarse_model.stiffness_2)
    assert abs(whole - parts - coarse_model.stiffness_patch).max() < 1e-12 * abs(whole).max()
    assert abs(coarse_model.mass - coarse_model.mass.T).max() <= 1e-15 * abs(coarse_model.mass).max()


def test_deflection_at_points(coarse_model: ShellModel) -> None:
    points = np.array([(0.0, 0.0), (0.24, 0.0), (0.24, 0.19), (0.0, 0.19), (0.2, 0.155), (0.03, 0.035)])
    probe = coarse_model.deflection(points)
    x = coarse_model.space.mesh.points[:, 0]
    assert probe @ rigid(coarse_model, 2) == pytest.approx(np.ones(len(points)))
    assert probe @ rigid(coarse_model, 2, x) == pytest.approx(points[:, 0])
    assert np.abs(probe @ rigid(coarse_model, 0)).max() == 0.0
    with pytest.raises(ValueError, match=r"\(0\.1, 0\.2\) m is off the plate"):
        coarse_model.deflection(np.array([(0.1, 0.2)]))


LINES = np.array([260.0, 700.0, 1150.0])
SIZE = (0.12, 0.1)
PLACES = {"A": (0.035, 0.03), "S": (0.09, 0.06)}
SHAPES = {"A": {"size": (0.018, 0.014)}, "S": {"size": (0.016, 0.016)}}
ROLES = {"A": "actuator", "S": "sensor"}


def transfers(plate: Plate, places: dict[str, tuple[float, float]], angle: float = 0.0) -> NDArray[np.complex128]:
    """Compliance b' Z**-1 b between A and S, in this order, (2, 2, F), with functions of one degree."""
    patches = [
        Patch(id=k, role=ROLES[k], center=place, thickness=0.0005, angle=angle, **SHAPES[k])
        for k, place in places.items()
    ]
    model = assemble(plate, patches, degree=6)
    order = [list(places).index(k) for k in "AS"]
    return model.compliance(2e9, 0.38, 0.06, LINES)[np.ix_(order, order)]


@pytest.fixture(scope="module")
def declared() -> NDArray[np.complex128]:
    return transfers(Plate(length_x=SIZE[0], length_y=SIZE[1], thickness=0.003, mass=0.0342), PLACES)


def polygon(angle: float) -> tuple[Plate, dict[str, tuple[float, float]]]:
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    turn = np.array([[c, -s], [s, c]])
    corners = np.array([(0, 0), (SIZE[0], 0), SIZE, (0, SIZE[1])]) @ turn.T + 0.2
    outline = {"kind": "polygon", "points": tuple(map(tuple, corners.tolist()))}
    places = {k: tuple((turn @ place + 0.2).tolist()) for k, place in PLACES.items()}
    return Plate(outline=outline, thickness=0.003, mass=0.0342), places


@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_a_rectangle_is_a_polygon_at_any_angle(declared: NDArray[np.complex128], angle: float) -> None:
    found = transfers(*polygon(angle), angle)
    rms = np.sqrt(np.mean(np.abs(declared) ** 2, axis=-1, keepdims=True))
    assert (np.abs(found - declared) / rms).max() < 5e-4


def test_a_mirror_image_answers_alike_whatever_the_order_of_patches(declared: NDArray[np.complex128]) -> None:
    plate = Plate(length_x=SIZE[0], length_y=SIZE[1], thickness=0.003, mass=0.0342)
    places = {k: (SIZE[0] - PLACES[k][0], PLACES[k][1]) for k in ("S", "A")}
    found = transfers(plate, places)
    rms = np.sqrt(np.mean(np.abs(declared) ** 2, axis=-1, keepdims=True))
    assert (np.abs(found - declared) / rms).max() < 5e-4


@pytest.mark.slow
def test_patch_to_patch_transfer_has_converged(
    plate: Plate, patches: list[Patch], nominal_model: ShellModel
) -> None:
    """Against other cells, degree 9 and over twice as many unknowns, at 0, 20 and 60 degrees Celsius."""
    mesh = MeshRecipe(spacing=0.025, strip=0.6, edge_strip=0.7)
    box = MaterialBox((0.8e9, 4e9), (0.30, 0.48), (0.02, 0.12))
    fine = assemble_for(plate, patches, box, (100.0, 1500.0), fineness=Fineness(mesh, degree=9, tolerance=1e-10))
    assert fine.size > 2.0 * nominal_model.size
    lines = np.linspace(110.0, 1490.0, 6)
    for material in ((3.248e9, 0.340, 0.0485), (2.2605e9, 0.370, 0.0817), (1.0005e9, 0.4747, 0.035)):
        truth = fine.compliance(*material, lines)[0, 1]
        wrong = nominal_model.compliance(*material, lines)[0, 1] - truth
        assert np.linalg.norm(wrong) < 1e-3 * np.linalg.norm(truth)
