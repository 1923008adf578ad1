"""The heat equation of a plate against closed forms: slab, fin, a mode that decays, and heat that is kept.

Slab and fin: Carslaw and Jaeger, Conduction of Heat in Solids, 1959, 3.11 and 4.2.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse.linalg import spsolve

from simulation.heat import HeatModel, march, settled
from simulation.meshing.plate_mesh import CURVE_DEGREE, PlateMesh, edges_of
from simulation.shell.space import ShapeSpace

LENGTH, WIDTH, THICKNESS = 0.2, 0.1, 0.003
DENSITY, HEAT, CONDUCTIVITY = 950.0, 1900.0, 0.22
DIFFUSIVITY = CONDUCTIVITY / (DENSITY * HEAT)


def rectangle(along, across, degree):
    """Return a plate of `along` times `across` equal cells."""
    x, y = np.meshgrid(np.linspace(0.0, LENGTH, along + 1), np.linspace(0.0, WIDTH, across + 1))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    first = (np.arange(across)[:, None] * (along + 1) + np.arange(along)).ravel()
    quads = np.stack([first, first + 1, first + along + 2, first + along + 1], axis=1)
    triangles = np.zeros((0, 3), dtype=int)
    edges = edges_of(quads, triangles)
    bow = np.zeros((len(edges), CURVE_DEGREE - 1, 2))
    return ShapeSpace.on(PlateMesh(points, quads, triangles, edges, bow, {}, {}), degree)


def plate(space, conductivity=CONDUCTIVITY, **transfer):
    thickness = np.full(space.mesh.cells, THICKNESS)
    constants = {"density": DENSITY, "specific_heat": HEAT, "conductivity": conductivity}
    return HeatModel.of(space, thickness, **constants, **transfer)


def edge_at(space, x):
    return np.abs(space.mesh.points[space.mesh.edges][:, :, 0] - x).max(axis=1) < 1e-9


def after(model, load, start, duration, steps):
    return list(march(model, load, start, duration / steps, steps))[-1]


@pytest.mark.parametrize("biot", [0.05, 0.5, 2.0])
def test_a_slab_cooled_on_both_faces_follows_its_series(biot):
    """Within 0.5 % of the first difference, at the faces and in the middle, from a fortieth of L²/a on."""
    half = 0.5 * THICKNESS
    transfer = biot * CONDUCTIVITY / half
    space = rectangle(2, 1, 1)
    model = plate(space, front=transfer, back=transfer)
    roots = [
        brentq(lambda b: b * np.sin(b) - biot * np.cos(b), n * np.pi + 1e-9, (n + 0.5) * np.pi) for n in range(40)
    ]
    b = np.array(roots)
    share = 4.0 * np.sin(b) / (2.0 * b + np.sin(2.0 * b))
    for fourier in (0.1, 0.5, 2.0):
        duration = fourier * half**2 / DIFFUSIVITY
        here = after(model, lambda _time: np.zeros(model.capacity.shape[0]), model.uniform(1.0), duration, 200)
        for place, depth in (("middle", 0.0), ("front", 1.0), ("back", 1.0)):
            exact = float(np.sum(share * np.cos(b * depth) * np.exp(-(b**2) * fourier)))
            found = space.values(np.array([[0.07, 0.03]])) @ model.seen(here, place)
            assert found == pytest.approx(exact, abs=0.005), (place, fourier)


def test_the_sun_on_one_face_warms_a_slab_by_its_series():
    """Heat flow into one face, the other and all edges insulated: 3.8 (3) there."""
    space = rectangle(1, 1, 1)
    model, flow = plate(space), 600.0
    load = model.on_face("front", flow)
    for fourier in (0.2, 1.0, 5.0):
        here = after(model, lambda _time: load, model.uniform(0.0), fourier * THICKNESS**2 / DIFFUSIVITY, 200)
        n = np.arange(1, 60)
        for place, x in (("back", 0.0), ("front", 1.0)):
            series = np.sum((-1.0) ** n / n**2 * np.exp(-((n * np.pi) ** 2) * fourier) * np.cos(n * np.pi * x))
            shape = fourier + (3.0 * x**2 - 1.0) / 6.0 - 2.0 / np.pi**2 * series
            exact = flow * THICKNESS / CONDUCTIVITY * shape
            found = space.values(np.array([[0.1, 0.05]])) @ model.seen(here, place)
            assert found == pytest.approx(exact, abs=0.005 * flow * THICKNESS / CONDUCTIVITY), (place, fourier)


def test_bending_weighs_the_thickness_by_its_square():
    """Against a quadrature of T z² of a state with a full profile."""
    space = rectangle(1, 1, 1)
    model = plate(space)
    rng = np.random.default_rng(3)
    parts = rng.standard_normal(model.layers)
    state = np.kron(parts, model.uniform(1.0)[: space.size])
    s, weight = np.polynomial.legendre.leggauss(12)
    exact = np.sum(weight * 1.5 * s**2 * np.polynomial.legendre.legval(s, parts))
    found = space.values(np.array([[0.05, 0.05]])) @ model.seen(state, "bending")
    assert found == pytest.approx(exact, rel=1e-12)


def test_a_fin_held_at_both_ends_is_a_hyperbolic_cosine():
    """Cooled on both faces, warmed through its short edges: within 0.5 % of the difference at the edge."""
    space, conductivity, transfer, contact = rectangle(6, 1, 3), 20.0, 10.0, 4000.0
    ends = edge_at(space, 0.0) | edge_at(space, LENGTH)
    model = plate(space, conductivity, front=transfer, back=transfer, edges=[(ends, contact)])
    here = settled(model, model.on_edges(ends, contact * 50.0))
    m = np.sqrt(2.0 * transfer / (conductivity * THICKNESS))
    x = np.linspace(0.0, LENGTH, 41)
    shape, slope = np.cosh(m * (x - 0.5 * LENGTH)), m * np.sinh(0.5 * m * LENGTH)
    exact = contact * 50.0 / (contact * shape[0] + conductivity * slope) * shape
    found = space.values(np.stack([x, np.full(len(x), 0.04)], axis=1)) @ model.seen(here, "middle")
    np.testing.assert_allclose(found, exact, atol=0.005 * exact[0])
    assert exact.min() < 0.4 * exact.max()


def decayed(degree, along, steps):
    """Error of a cosine along the plate that decays within it."""
    space = rectangle(along, 1, degree)
    model = plate(space)
    wave = np.pi / LENGTH
    time = 1.0 / (DIFFUSIVITY * wave**2)
    moments = space.moments("0", np.cos(wave * space.points[:, 0]))
    flat = spsolve(space.product("0", "0").tocsc(), moments)
    start = np.kron(np.eye(model.layers)[0], flat)
    here = after(model, lambda _time: np.zeros(len(start)), start, time, steps)
    exact = np.exp(-1.0) * np.cos(wave * space.points[:, 0])
    error = space.values(space.points) @ model.seen(here, "middle") - exact
    return float(np.sqrt(np.sum(space.dx * error**2) / np.sum(space.dx * exact**2)))


def test_steps_are_of_second_order():
    errors = np.array([decayed(6, 4, steps) for steps in (4, 8, 16, 32)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders[-1] == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_cells_are_of_one_order_more_than_their_degree(degree):
    errors = np.array([decayed(degree, along, 3000) for along in (2, 4, 8)])
    assert np.log2(errors[-2] / errors[-1]) == pytest.approx(degree + 1.0, abs=0.2)


def test_an_insulated_plate_keeps_its_heat_and_never_comes_to_rest():
    space = rectangle(3, 2, 2)
    model = plate(space)
    load = model.on_face("back", 100.0)
    here = after(model, lambda _time: load, model.uniform(20.0), 300.0, 10)
    kept = model.uniform(1.0) @ (model.capacity @ (here - model.uniform(20.0)))
    assert kept == pytest.approx(100.0 * LENGTH * WIDTH * 300.0, rel=1e-10)
    with pytest.raises(ValueError, match="no face and no edge exchanges heat"):
        settled(model, load)


def test_what_is_faster_than_a_step_dies_out():
    """Steps a hundred times longer than heat needs through the thickness; Crank and Nicolson's would ring on."""
    space = rectangle(1, 1, 1)
    model = plate(space, front=10.0, back=10.0)
    load = model.on_face("front", 500.0)
    step = 100.0 * THICKNESS**2 / DIFFUSIVITY
    end = model.seen(settled(model, load), "front")[0]
    found = np.array(
        [model.seen(one, "front")[0] for one in march(model, lambda _t: load, model.uniform(0.0), step, 6)]
    )
    away = np.abs(found - end)
    assert away[0] < 0.15 * end
    assert (away[1:] < 0.15 * away[:-1]).all()
