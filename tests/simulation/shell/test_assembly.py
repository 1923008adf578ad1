"""Bare plates against closed forms, published benchmarks and their own convergence."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.declaration.outline import CircleOutline
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import BorderEdges, MeshRecipe, PlateMesh, edges_of
from simulation.shell.assembly import assemble, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.shell_model import ShellModel
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns
from tests.simulation.verification.exact_plates import HardRectangle, LevyPlate

HARD = ({"kind": "hard-simple", "edge": "all"},)
E, NU = 2e9, 0.35


def rectangle(thickness: float, a: float = 0.2, b: float = 0.15, density: float = 1000.0, **more) -> Plate:
    return Plate(length_x=a, length_y=b, thickness=thickness, mass=density * a * b * thickness, **more)


def unit(plate: Plate, e: float = E, nu: float = NU) -> float:
    """sqrt(D / (rho h)) / (2 pi a**2), Hz."""
    d = e * plate.thickness**3 / (12 * (1 - nu**2))
    return float(np.sqrt(d / (plate.density * plate.thickness))) / (2 * np.pi * plate.length_x**2)


def bending(model: ShellModel, count: int, e: float = E, nu: float = NU) -> Real:
    """Lowest frequencies of a flat bare plate's deflection and rotations, Hz; its plane moves apart from them."""
    kept = np.flatnonzero(model.unknowns.chosen // model.space.size >= 2)
    parts = {
        name: getattr(model, name)[kept][:, kept]
        for name in ("stiffness_1", "stiffness_2", "stiffness_patch", "mass")
    }
    unknowns = Unknowns(model.space, model.unknowns.chosen[kept])
    return replace(model, unknowns=unknowns, **parts).eigenfrequencies(e, nu, count)


def on_grid(plate: Plate, count: tuple[int, int], degree: int) -> ShellPlate:
    """Rectangle of equal quadrilaterals, without any strip."""
    nx, ny = count
    number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    x, y = np.meshgrid(
        np.linspace(0, plate.length_x, nx + 1), np.linspace(0, plate.length_y, ny + 1), indexing="ij"
    )
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    quads, triangles = np.stack([c.ravel() for c in corners], axis=1), np.zeros((0, 3), int)
    edges = edges_of(quads, triangles)
    sides = (number[:, 0], number[-1, :], number[::-1, -1], number[0, ::-1])
    pairs = [np.stack([side[:-1], side[1:]], axis=1) for side in sides]
    found = [np.flatnonzero((edges == np.sort(pair)).all(axis=1))[0] for side in pairs for pair in side]
    spans = [np.stack([t[:-1], t[1:]], axis=1) for t in (np.linspace(0, 1, len(side)) for side in sides)]
    curve = np.repeat(np.arange(4), [len(side) for side in pairs])
    border = BorderEdges(np.array(found), curve, np.vstack(spans))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    bow = np.zeros((len(edges), 7, 2))
    mesh = PlateMesh(
        points, quads, triangles, edges, bow, {"outline": np.ones(len(quads), bool)}, {"outline": border}
    )
    return ShellPlate(plate, (), ShapeSpace.on(mesh, degree))


def gridded(plate: Plate, count: tuple[int, int], degree: int, monkeypatch: pytest.MonkeyPatch) -> ShellModel:
    monkeypatch.setattr(ShellPlate, "of", lambda *_, degree, **__: on_grid(plate, count, degree))
    return assemble(plate, degree=degree)


@pytest.mark.parametrize("thickness", [0.02, 0.002])
def test_degree_converges_exponentially_on_hard_supports(
    thickness: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plate = rectangle(thickness, support=HARD)
    exact = unit(plate) * HardRectangle(thickness / 0.2, NU, 0.75).lowest(5)
    errors = [
        np.abs(bending(gridded(plate, (2, 2), degree, monkeypatch), 5) / exact - 1).max() for degree in (4, 5, 6)
    ]
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[1] / 4
    assert errors[2] < 1e-3


def test_order_of_convergence_on_hard_supports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Eigenvalues of degree p converge with the mesh as h**(2 p)."""
    plate = rectangle(0.02, b=0.16, support=HARD)
    exact = unit(plate) * HardRectangle(0.1, NU, 0.8).lowest(4)
    errors = [np.abs(bending(gridded(plate, count, 3, monkeypatch), 4) / exact - 1) for count in ((5, 4), (10, 8))]
    order = np.log2(errors[0] / errors[1])
    assert order.min() > 5.0
    assert errors[1].max() < 1e-5


@pytest.mark.parametrize(
    ("edges", "lower", "upper"),
    [
        ({}, "free", "free"),
        ({"bottom": "clamped"}, "clamped", "free"),
        ({"bottom": "soft-simple", "top": "clamped"}, "soft", "clamped"),
    ],
)
def test_levys_plates_on_the_mesh_of_any_outline(edges: dict[str, str], lower: str, upper: str) -> None:
    """Hard simple supports left and right."""
    sides = {"left": "hard-simple", "right": "hard-simple", **edges}
    supports = tuple({"kind": kind, "edge": edge} for edge, kind in sides.items())
    plate = rectangle(0.01, support=supports)
    exact = unit(plate) * LevyPlate(0.05, NU, 0.75, lower, upper).lowest(5)
    model = assemble(plate, recipe=MeshRecipe(spacing=0.06), degree=6)
    assert bending(model, 5) == pytest.approx(exact, rel=3e-4)


def test_free_square_plate_is_nafems_fv12() -> None:
    """FV12 made ten times smaller in every length: ten times the frequencies (converged Mindlin values)."""
    plate = rectangle(0.005, 1.0, 1.0, 8000.0)
    model = assemble(plate, recipe=MeshRecipe(spacing=0.25))
    reference = 10 * np.array([1.6184, 2.3592, 2.9218, 4.182, 4.182, 7.3532])
    found = model.eigenfrequencies(200e9, 0.3, 12)
    assert np.all(found[:6] < 1e-3)  # three translations, three rotations
    assert found[6:] == pytest.approx(reference, rel=1e-4)


def test_clamped_square_plate_is_leissas() -> None:
    """Values of w a^2 sqrt(rho h / D) of a thin plate: 35.985, 73.394 twice, 108.22 (Leissa 1973)."""
    plate = rectangle(0.002, 1.0, 1.0, 8000.0, boundary="clamped")
    model = assemble(plate, recipe=MeshRecipe(spacing=0.25))
    found = model.eigenfrequencies(200e9, 0.3, 4) / unit(plate, 200e9, 0.3)
    assert found == pytest.approx([35.985, 73.394, 73.394, 108.22], rel=1e-3)


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


@pytest.fixture(scope="module")
def bare(plate: Plate) -> ShellModel:
    return assemble(plate, recipe=MeshRecipe(spacing=0.06))


@pytest.mark.parametrize("constants", PAPER_PLATE)
def test_papers_bare_plate(bare: ShellModel, constants: tuple[float, float]) -> None:
    reference = np.array(PAPER_PLATE[constants].split(), float)
    found = bare.eigenfrequencies(*constants, 22)
    assert np.all(found[:6] < 0.01)
    assert found[6:] == pytest.approx(reference, rel=3e-3)


ZONES: dict[str, Callable[[float], dict]] = {
    "rectangle": lambda h: {"kind": "rectangle", "center": (0.1, 0.075), "size": (0.1, 0.08), "thickness": h},
    "ellipse": lambda h: {"kind": "ellipse", "center": (0.1, 0.075), "radii": (0.06, 0.04), "thickness": h},
}


@pytest.mark.parametrize("kind", ZONES)
def test_a_zone_of_the_plates_own_thickness_is_none(kind: str) -> None:
    plain = bending(assemble(rectangle(0.004), recipe=MeshRecipe(spacing=0.08)), 12)[3:]
    zoned = assemble(rectangle(0.004, zone=(ZONES[kind](0.004),)), recipe=MeshRecipe(spacing=0.08))
    assert bending(zoned, 12)[3:] == pytest.approx(plain, rel=1e-4)


def test_a_zone_over_all_of_a_plate_is_a_plate_of_its_thickness() -> None:
    a, b = 0.2, 0.15
    zone = {"kind": "rectangle", "center": (a / 2, b / 2), "size": (a, b), "thickness": 0.004}
    zoned = rectangle(0.003, zone=(zone,))
    whole = rectangle(0.004).model_copy(update={"mass": zoned.mass})
    recipe = MeshRecipe(spacing=0.08)
    found, wanted = (bending(assemble(plate, recipe=recipe), 10)[3:] for plate in (zoned, whole))
    assert found == pytest.approx(wanted, rel=1e-4)


def test_a_stepped_strip_bends_as_a_stepped_beam() -> None:
    """Free Euler beam of two halves, 2 and 3 mm: eight conditions on cos, sin, cosh and sinh of both halves."""
    length, width, density, nu = 0.4, 0.02, 1000.0, 0.0
    thickness = np.array([0.002, 0.003])
    zone = {"kind": "rectangle", "center": (0.3, 0.01), "size": (0.2, width), "thickness": thickness[1]}
    mass = density * width * 0.5 * length * thickness.sum()
    plate = Plate(length_x=length, length_y=width, thickness=thickness[0], mass=mass, zone=(zone,))
    rigidity, weight = E * thickness**3 / 12.0, density * thickness  # per width

    def determinant(frequency: float) -> float:
        rows = np.zeros((8, 8))
        for half, (d, m) in enumerate(zip(rigidity, weight, strict=True)):
            k = (m * (2 * np.pi * frequency) ** 2 / d) ** 0.25
            s = k * 0.5 * length * np.array([0.0, 1.0])
            c, ch = np.exp(1j * s), np.stack([np.exp(s - s[1]), np.exp(-s)])
            shapes = [
                np.stack([(1j**n * c).real, (1j**n * c).imag, ch[0], (-1) ** n * ch[1]]) * (k * length) ** n
                for n in range(4)
            ]
            free, joint = (0, 1) if half == 0 else (1, 0)
            columns = slice(4 * half, 4 * half + 4)
            rows[2 * half, columns], rows[2 * half + 1, columns] = shapes[2][:, free], shapes[3][:, free]
            for n in range(4):
                rows[4 + n, columns] = (1 - 2 * half) * shapes[n][:, joint] * (d / rigidity[0] if n > 1 else 1.0)
        return float(np.linalg.det(rows / np.linalg.norm(rows, axis=1, keepdims=True)))

    at = np.linspace(2.0, 120.0, 3000)
    sign = np.sign([determinant(f) for f in at])
    beam = at[:-1][sign[1:] != sign[:-1]][:3]
    found = bending(assemble(plate, recipe=MeshRecipe(spacing=0.1, edge_strip=2.0)), 12, E, nu)[3:]
    for frequency in beam:
        assert np.abs(found / frequency - 1.0).min() < 3e-3


def test_a_round_plate_is_assembled_with_progress_from_nothing_to_all() -> None:
    """At the degree from which functions are chosen: curved triangles need a rule of order 20."""
    outline = CircleOutline(kind="circle", center=(0.3, -0.1), radius=0.06)
    plate = Plate(outline=outline, thickness=0.003, mass=0.032)
    patch = Patch(id="A1", role="actuator", center=(0.31, -0.09), diameter=0.02, thickness=5e-4)
    shares: list[float] = []
    box = MaterialBox((1e9, 3e9), (0.35, 0.43), (0.03, 0.1))
    model = assemble_for(
        plate, [patch], box, (100.0, 500.0), fineness=Fineness(tolerance=1e-7), progress=shares.append
    )
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert len(shares) == 6
    assert 0 < model.size < 5 * model.shell.space.size
    assert abs(model.shell.space.dx.sum() / plate.area - 1.0) < 1e-9
