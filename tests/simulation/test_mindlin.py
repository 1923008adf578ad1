"""The shell against closed forms, published benchmarks and its own convergence."""

from itertools import product

import numpy as np
import pytest

from analysis.experiment import Patch, Plate
from simulation.laminate import SHEAR_FACTOR
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.factors import factorize
from simulation.shell.piezo_material import NCE51, VACUUM_PERMITTIVITY

SIMPLY_SUPPORTED = {
    "left": ("u", "v", "w", "thy"),
    "right": ("u", "v", "w", "thy"),
    "bottom": ("u", "v", "w", "thx"),
    "top": ("u", "v", "w", "thx"),
}
"""Hard: the tangential rotation is held. In-plane motion is held too, for it is not asked about."""


def uniform(degree, spacing):
    return MeshRecipe(degree=degree, spacing=spacing, edge_strip=spacing, thinned=False)


def navier(plate, e, nu, count):
    """Exact bending frequencies of the hard simply supported Mindlin plate, Hz, the lowest of each (m, n).

    w = W sin sin, thx = X cos sin, thy = Y sin cos turn the plate's equations into 3 x 3 matrices.
    """
    h, rho = plate.thickness, plate.density
    d, s = e * h**3 / (12 * (1 - nu**2)), SHEAR_FACTOR * e / (2 * (1 + nu)) * h
    found = []
    for m, n in product(range(1, 8), repeat=2):
        p, q = m * np.pi / plate.length_x, n * np.pi / plate.length_y
        k = np.array(
            [
                [s * (p**2 + q**2), s * p, s * q],
                [s * p, d * (p**2 + (1 - nu) / 2 * q**2) + s, d * (1 + nu) / 2 * p * q],
                [s * q, d * (1 + nu) / 2 * p * q, d * (q**2 + (1 - nu) / 2 * p**2) + s],
            ]
        )
        mass = rho * np.diag([h, h**3 / 12, h**3 / 12])
        found.append(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, k)).real.min()) / (2 * np.pi))
    return np.sort(found)[:count]


@pytest.mark.parametrize("thickness", [0.02, 0.002])
def test_degree_convergence_on_the_simply_supported_plate(thickness):
    plate = Plate(length_x=0.2, length_y=0.15, thickness=thickness, mass=0.03 * thickness * 1000)
    exact = navier(plate, 2e9, 0.35, 5)
    errors = []
    for degree in (4, 5, 6):
        model = assemble(plate, recipe=uniform(degree, 0.1), supports=SIMPLY_SUPPORTED)
        errors.append(np.abs(model.eigenfrequencies(2e9, 0.35, 5) / exact - 1).max())
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[1] / 4
    assert errors[2] < 1e-3


def test_mesh_convergence_order_on_the_simply_supported_plate():
    """Eigenvalues of degree p converge with the mesh as h**(2 p)."""
    plate = Plate(length_x=0.2, length_y=0.16, thickness=0.02, mass=0.64)
    exact = navier(plate, 2e9, 0.35, 4)
    errors = [
        np.abs(
            assemble(plate, recipe=uniform(3, h), supports=SIMPLY_SUPPORTED).eigenfrequencies(2e9, 0.35, 4) / exact
            - 1
        )
        for h in (0.04, 0.02)
    ]
    order = np.log2(errors[0] / errors[1])
    assert order.min() > 5.0
    assert errors[1].max() < 1e-5


def test_free_square_plate_is_nafems_fv12():
    """FV12 made ten times smaller in every length: ten times the frequencies (converged Mindlin values)."""
    plate = Plate(length_x=1.0, length_y=1.0, thickness=0.005, mass=8000 * 0.005)
    model = assemble(plate, recipe=MeshRecipe(spacing=0.25))
    reference = 10 * np.array([1.6184, 2.3592, 2.9218, 4.182, 4.182, 7.353])
    assert model.eigenfrequencies(200e9, 0.3, 12)[6:] == pytest.approx(reference, rel=1e-3)


def test_clamped_square_plate_is_leissas():
    """Values of w a^2 sqrt(rho h / D) of a thin plate: 35.985, 73.394 twice, 108.22 (Leissa 1973)."""
    plate = Plate(length_x=1.0, length_y=1.0, thickness=0.002, mass=8000 * 0.002, boundary="clamped")
    d = 200e9 * plate.thickness**3 / (12 * (1 - 0.3**2))
    unit = np.sqrt(d / (plate.density * plate.thickness)) / (2 * np.pi)
    model = assemble(plate, recipe=MeshRecipe(spacing=0.2))
    assert model.eigenfrequencies(200e9, 0.3, 4) / unit == pytest.approx(
        [35.985, 73.394, 73.394, 108.22], rel=1e-3
    )


PAPER_PLATE = {
    (
        3.25e9,
        0.34,
    ): "77.3 98.4 167.7 186.5 220.7 289.5 363.0 372.9 454.1 513.5 559.0 582.0 624.9 682.6 854.4 898.2",
    (
        2.26e9,
        0.37,
    ): "63.8 82.0 141.4 154.8 183.2 244.1 302.2 310.3 381.7 430.8 470.2 485.2 521.7 572.6 713.7 750.0",
    (
        1.00e9,
        0.475,
    ): "41.1 54.3 98.8 101.3 119.9 169.9 200.0 205.7 262.5 294.4 324.4 324.4 350.5 391.8 480.6 504.8",
}
"""Elastic modes of the bare plate at 0, 20 and 60 degrees Celsius, Hz, from an independent prototype."""


@pytest.mark.parametrize("constants", PAPER_PLATE)
def test_papers_bare_plate(plate, constants):
    reference = np.array(PAPER_PLATE[constants].split(), float)
    found = assemble(plate).eigenfrequencies(*constants, 22)
    assert np.all(found[:6] < 0.01)
    assert found[6:] == pytest.approx(reference, rel=3e-3)


def test_patches_near_the_corners_lower_the_first_mode(plate):
    """By 3.6 % with 20 x 20 x 0.5 mm patches 20 mm from opposite corners: mass wins where nothing bends."""
    patches = [
        Patch(id=i, role=role, center=c, size=(0.02, 0.02), thickness=0.0005)
        for i, role, c in (("A", "actuator", (0.02, 0.02)), ("S", "sensor", (0.22, 0.17)))
    ]
    bare = assemble(plate).eigenfrequencies(2.26e9, 0.37, 8)
    loaded = assemble(plate, patches).eigenfrequencies(2.26e9, 0.37, 8)
    assert loaded[6] / bare[6] - 1 == pytest.approx(-0.036, abs=0.001)


def rigid(model, field, component=0):
    """Unknowns of a unit translation or rotation field: one at every vertex, or the vertex's x."""
    space, vertices = model.space, model.space.basis.mesh.p.shape[1]
    value = np.zeros((5, space.size))
    value[field, :vertices] = 1.0 if component == 0 else space.basis.mesh.p[0]
    return value.ravel()[model.unknowns]


def test_mass_weighs_plate_and_patches(plate, nominal_model):
    total = plate.mass + 2 * NCE51.density * 0.02**2 * 0.0005
    for field in range(3):
        motion = rigid(nominal_model, field)
        assert motion @ nominal_model.mass @ motion == pytest.approx(total, rel=1e-10)


def test_rotary_inertia_and_offset_moment(plate, nominal_model):
    u, tilt = rigid(nominal_model, 0), rigid(nominal_model, 3)
    patch_mass, height, thickness = NCE51.density * 0.02**2 * 0.0005, 0.00175, 0.0005
    assert u @ nominal_model.mass @ tilt == pytest.approx(2 * patch_mass * height, rel=1e-9)
    expected = plate.mass * 0.003**2 / 12 + 2 * patch_mass * (height**2 + thickness**2 / 12)
    assert tilt @ nominal_model.mass @ tilt == pytest.approx(expected, rel=1e-9)


def test_rigid_motion_costs_no_energy(nominal_model):
    stiffness = nominal_model.stiffness(2e9, 0.38)
    scale = np.abs(stiffness.diagonal()).max()
    tilted = rigid(nominal_model, 2, component=1) - rigid(nominal_model, 3)  # w = x, thx = -1
    for motion in (*(rigid(nominal_model, field) for field in range(3)), tilted):
        assert np.abs(stiffness @ motion).max() < 1e-11 * scale
    assert np.abs(nominal_model.coupling.T @ tilted).max() < 1e-12


def test_reciprocity_between_unequal_patches(plate):
    patches = [
        Patch(id="A", role="actuator", center=(0.05, 0.05), size=(0.03, 0.02), thickness=0.0005),
        Patch(id="S", role="sensor", center=(0.18, 0.12), size=(0.015, 0.025), thickness=0.0003, side="bottom"),
    ]
    recipe = MeshRecipe(degree=4, spacing=0.08)
    g = assemble(plate, patches, recipe=recipe).compliance(2e9, 0.38, 0.06, [150.0, 800.0])
    assert np.allclose(g[0, 1], g[1, 0], rtol=1e-9)


def test_faces_are_mirror_images(plate, patches):
    recipe = MeshRecipe(degree=3, spacing=0.08)
    below = [p.model_copy(update={"side": "bottom"}) for p in patches]
    lines = [220.0, 640.0]
    top = assemble(plate, patches, recipe=recipe).compliance(2e9, 0.38, 0.06, lines)
    bottom = assemble(plate, below, recipe=recipe).compliance(2e9, 0.38, 0.06, lines)
    assert np.allclose(top, bottom, rtol=1e-8)


def test_patch_on_a_plate_of_no_stiffness_has_the_free_capacitance(plate, patches):
    """Charge per volt at rest is Cp + b' K^-1 b: with nothing to hold the patch, eps33T A / h."""
    model = assemble(plate, patches[:1], recipe=MeshRecipe(degree=4, spacing=0.08))
    stiffness = model.stiffness(1e3, 0.3) + 1e-2 * model.mass  # the mass holds the rigid motion
    give = model.coupling[:, 0] @ factorize(stiffness).solve(model.coupling[:, 0])
    free = 1850 * VACUUM_PERMITTIVITY * 0.02**2 / 0.0005
    assert model.capacitance[0] + give == pytest.approx(free, rel=1e-4)
    held = model.stiffness(1e15, 0.3) + 1e-2 * model.mass
    assert model.coupling[:, 0] @ factorize(held).solve(model.coupling[:, 0]) < 1e-3 * free


def test_fully_covered_plate_bends_as_laminate_theory_says():
    """A free plate under a whole-face patch strains and curves alike in all directions: two equations."""
    plate = Plate(length_x=0.1, length_y=0.08, thickness=0.003, mass=0.0228)
    patch = Patch(id="A", role="actuator", center=(0.05, 0.04), size=(0.1, 0.08), thickness=0.0005)
    model = assemble(plate, [patch], recipe=MeshRecipe(degree=4))
    e, nu = 2.2e9, 0.37
    answer = factorize(model.stiffness(e, nu) + 1e-3 * model.mass).solve(model.coupling[:, 0])
    biaxial, z = np.array([e / (1 - nu), NCE51.youngs_modulus / (1 - NCE51.poisson_ratio)]), 0.00175
    a = biaxial @ [0.003, 0.0005]
    b = biaxial[1] * 0.0005 * z
    d = biaxial @ [0.003**3 / 12, 0.0005 * z**2 + 0.0005**3 / 12]
    strain, curvature = np.linalg.solve([[a, b], [b, d]], NCE51.e31 * np.array([1.0, z]))
    expected = NCE51.e31 * 2 * (strain + z * curvature) * 0.1 * 0.08
    assert model.coupling[:, 0] @ answer == pytest.approx(expected, rel=1e-6)
    sag = model.deflection([(0.0, 0.04), (0.05, 0.04), (0.1, 0.04)]) @ answer
    assert sag[1] - 0.5 * (sag[0] + sag[2]) == pytest.approx(0.5 * curvature * 0.05**2, rel=1e-6)


def test_affine_parts_add_up_to_any_material(plate, patches):
    """K is linear in C1 and C2: three materials determine a fourth."""
    model = assemble(plate, patches, recipe=MeshRecipe(degree=3, spacing=0.1))
    whole = model.stiffness(3e9, 0.4, 0.1)
    c1 = 3e9 / (1 - 0.16)
    parts = (1 + 0.1j) * c1 * (model.stiffness_1 + 0.4 * model.stiffness_2) + model.stiffness_patch
    assert abs(whole - parts).max() < 1e-12 * abs(whole).max()
    assert abs(model.mass - model.mass.T).max() == 0.0


def test_deflection_at_points(nominal_model):
    points = np.array(
        [(0.0, 0.0), (0.24, 0.0), (0.24, 0.19), (0.0, 0.19), (0.2, 0.155), (0.03, 0.035), (0.1, 0.08)]
    )
    probe = nominal_model.deflection(points)
    assert probe @ rigid(nominal_model, 2) == pytest.approx(np.ones(len(points)))
    assert probe @ rigid(nominal_model, 2, component=1) == pytest.approx(points[:, 0])
    assert np.abs(probe @ rigid(nominal_model, 0)).max() == 0.0
    with pytest.raises(ValueError, match=r"off the plate.*0\.24, 0\.19"):
        nominal_model.deflection([(0.1, 0.2)])


@pytest.mark.slow
def test_patch_to_patch_transfer_has_converged(plate, patches, nominal_model):
    """Against degree 8 on 128 000 unknowns: within 0.2 % of rms at 0, 20 and 60 degrees Celsius."""
    fine = assemble(
        plate,
        patches,
        recipe=MeshRecipe(degree=8, spacing=0.025, strip=0.0015, edge_strip=0.002, thinned=False),
    )
    lines = np.linspace(110.0, 1490.0, 6)
    for material in ((3.248e9, 0.340, 0.0485), (2.2605e9, 0.370, 0.0817), (1.0005e9, 0.4747, 0.035)):
        truth = fine.compliance(*material, lines)[0, 1]
        wrong = nominal_model.compliance(*material, lines)[0, 1] - truth
        assert np.linalg.norm(wrong) < 2e-3 * np.linalg.norm(truth)
