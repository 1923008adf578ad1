"""Spots of less stiffness against what a disc of uniform strain holds."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from analysis.experiment import Plate
from analysis.material import LocalLaws, MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.composition import COMPLEX_STEP, Coefficients, Composite, composed
from simulation.reduction.effect_operators import BENDING_DEGREE, EffectOperators
from simulation.reduction.effect_reduction import project
from simulation.shell.assembly import assemble
from simulation.state.damaged_spots import coverage, in_plane_yielding, spots_slope, with_spots
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import Disc, PlateState
from simulation.state.state_matrices import FullPlate, StateMatrices

H, RADIUS = 0.003, 0.012
E, NU, ETA = 2e9, 0.38, 0.07


@pytest.fixture(scope="module")
def ops() -> EffectOperators:
    """Make a plate of 0.24 x 0.19 m with two coordinates: curvature 1/m along x, and twist 1/m."""
    x, y = (np.arange(n) * 0.004 + 0.002 for n in (60, 48))
    points = np.array([(a, b) for a in x for b in y])
    strain = np.zeros((8, len(points), 2))
    strain[3, :, 0] = 1.0
    strain[5, :, 1] = 1.0
    empty = {entry.name: np.zeros((1, 2, 2)) for entry in fields(EffectOperators)}
    values = {
        "strain": strain,
        "sheet": np.ones(3),
        "strain_points": points,
        "cell": 1.6e-5,
        "thickness": H,
        "normal": np.zeros((2, 2)),
    }
    box = MaterialBox((1e9, 4e9), (0.3, 0.45), (0.01, 0.1))
    return EffectOperators(
        **{**empty, **values, "box": box, "band": (100.0, 1500.0), "offset_range": 0.0, "error": 0.0}
    )


def two_curvatures(ops: EffectOperators) -> EffectOperators:
    """Take curvature along y for the second coordinate."""
    strain = np.zeros_like(ops.strain)
    strain[3, :, 0] = strain[4, :, 1] = 1.0
    return replace(ops, strain=strain)


def state(*discs: Disc) -> PlateState:
    laws = LocalLaws.of_material(E, NU, ETA)
    return replace(PlateState.baseline(np.zeros(1), np.zeros(1), laws, 20.0, np.array([500.0])), discs=discs)


def nothing() -> Composite:
    return Composite(*(np.zeros((2, 2)) for _ in range(5)))


@pytest.mark.parametrize("place", [(0.1, 0.09), (0.1013, 0.0927), (0.012, 0.178)])
def test_a_disc_covers_its_area(ops, place):
    share = coverage(ops, Disc(*place, RADIUS, 0.1))
    assert ops.cell * share.sum() == pytest.approx(np.pi * RADIUS**2)
    assert share.min() >= 0.0
    assert share.max() < 1.1
    centre = share @ ops.strain_points / share.sum()
    assert centre == pytest.approx(np.array(place), abs=3e-4)


def test_weak_spots_lose_what_the_disc_held(ops):
    loss = 1e-6
    lost = with_spots(ops, nothing(), state(Disc(0.1, 0.09, RADIUS, loss)))
    bending = loss * E * H**3 / 12.0 / (1.0 - NU**2) * np.pi * RADIUS**2
    assert -lost.plate[0, 0] == pytest.approx(bending)
    assert -lost.plate[1, 1] == pytest.approx(0.5 * (1.0 - NU) * bending)
    assert lost.plate[0, 1] == pytest.approx(0.0, abs=1e-9 * bending)
    assert lost.plate_loss == pytest.approx(ETA * lost.plate)


@pytest.mark.parametrize("loss", [0.1, 0.5])
def test_soft_spots_strain_more_than_their_surroundings(ops, loss):
    """A wide plate bent alike in all directions, and alike and opposite in two, with a soft disc in it."""
    lost = -with_spots(two_curvatures(ops), nothing(), state(Disc(0.1, 0.09, RADIUS, loss))).plate
    rigidity = E * H**3 / 12.0 / (1.0 - NU**2) * np.pi * RADIUS**2
    alike, opposite = np.array([1.0, 1.0]), np.array([1.0, -1.0])
    held = 2.0 * (1.0 + NU) * rigidity * curvature_in_disc(loss)
    assert alike @ lost @ alike == pytest.approx(loss * held)
    held = 2.0 * (1.0 - NU) * rigidity * twofold_curvature_in_disc(loss)
    assert opposite @ lost @ opposite == pytest.approx(loss * held)


def curvature_in_disc(loss: float) -> float:
    """Kirchhoff plate, w = r2/2 + b ln r outside the unit disc and c r2/2 inside; slope and moment go on."""
    soft = 1.0 - loss
    continuity = np.array([[-1.0, 1.0], [1.0 - NU, soft * (1.0 + NU)]])
    return float(np.linalg.solve(continuity, np.array([1.0, 1.0 + NU]))[1])


def twofold_curvature_in_disc(loss: float) -> float:
    """Likewise (r2/2 + b + c/r2) cos 2t outside, (f r2/2 + g r4) cos 2t inside; deflection and shear go on too."""
    soft, minus = 1.0 - loss, 1.0 - NU
    continuity = np.array(
        [
            [1.0, 1.0, -0.5, -1.0],
            [0.0, -2.0, -1.0, -4.0],
            [-4.0 * NU, 6.0 * minus, -soft * minus, -12.0 * soft],
            [8.0 + 4.0 * minus, 12.0 * minus, 2.0 * soft * minus, -soft * (24.0 - 12.0 * minus)],
        ]
    )
    found = np.linalg.solve(continuity, np.array([-0.5, -1.0, -minus, 2.0 * minus]))
    assert found[3] == pytest.approx(0.0, abs=1e-12)  # the curvature inside is uniform
    return float(found[2])


def test_without_loss_nothing_is_lost(ops):
    assert not with_spots(ops, nothing(), state(Disc(0.1, 0.09, RADIUS, 0.0))).plate.any()
    assert with_spots(ops, nothing(), state()).plate is not None


@pytest.mark.parametrize("moved", ["x", "y", "loss", "radius"])
def test_derivatives_follow_the_spot(ops, moved):
    varied = replace(
        ops, strain=ops.strain * (1.0 + 20.0 * ops.strain_points[:, :1] + 9.0 * ops.strain_points[:, 1:])
    )
    disc = Disc(0.1013, 0.0927, RADIUS, 0.2)
    stepped = replace(disc, **{moved: getattr(disc, moved) + 1j * COMPLEX_STEP})
    rate = spots_slope(varied, nothing(), state(stepped), np.eye(2)).plate
    d = 1e-6
    high, low = (
        with_spots(varied, nothing(), state(replace(disc, **{moved: getattr(disc, moved) + s * d}))).plate
        for s in (1, -1)
    )
    assert rate == pytest.approx((high - low) / (2 * d), rel=1e-6, abs=1e-6 * np.abs(rate).max())


def test_what_of_a_disc_lies_beside_the_plate_is_lost(ops):
    half = coverage(ops, Disc(0.0, 0.09, RADIUS, 0.1))
    assert ops.cell * half.sum() == pytest.approx(0.5 * np.pi * RADIUS**2, rel=0.1)
    assert not coverage(ops, Disc(-0.1, 0.09, RADIUS, 0.1)).any()


def test_a_disc_in_an_isotropic_sheet_yields_as_eshelby_found() -> None:
    """(1 + nu)/2 of strain alike in all directions, (3 - nu)/4 of the rest (Mura 1987, 11.22, in plane stress)."""
    q = np.array([[1.0, NU, 0.0], [NU, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - NU)]])
    share = in_plane_yielding(q) @ q
    assert share @ [1.0, 1.0, 0.0] == pytest.approx(0.5 * (1.0 + NU) * np.array([1.0, 1.0, 0.0]))
    for strain in ([1.0, -1.0, 0.0], [0.0, 0.0, 1.0]):
        assert share @ strain == pytest.approx(0.25 * (3.0 - NU) * np.array(strain))


ORTHOTROPY = {"delta_e": -0.5, "delta_g": 0.4, "angle": 35.0}


@pytest.mark.parametrize(
    ("loss", "orthotropy"),
    [
        (0.2, None),
        pytest.param(0.5, None, marks=pytest.mark.slow),
        pytest.param(0.2, ORTHOTROPY, marks=pytest.mark.slow),
        pytest.param(0.5, ORTHOTROPY, marks=pytest.mark.slow),
    ],
)
def test_a_spot_shifts_frequencies_as_a_disc_of_softer_cells_does(loss: float, orthotropy: dict | None) -> None:
    """The full plate, meshed around the disc and softened there by a temperature of its own."""
    place, slope = (0.095, 0.06), -0.05
    zone = {"kind": "circle", "center": place, "radius": RADIUS, "thickness": H}
    sheet = None if orthotropy is None else {"orthotropy": orthotropy}
    plate = Plate(length_x=0.16, length_y=0.12, thickness=H, mass=0.0519, zone=(zone,), material=sheet)
    model = assemble(plate, recipe=MeshRecipe(spacing=0.08, growth=2.0, grading=0.0), degree=4)
    full = FullPlate.of(model)
    laws = LocalLaws.of_material(E, NU, ETA, slope=(slope, 0.0, 0.0))

    def frequencies(matrices: StateMatrices) -> tuple[np.ndarray, np.ndarray]:
        shift = (2 * np.pi * 5.0) ** 2
        values, vectors = eigsh(
            matrices.plate + shift * matrices.mass,
            14,
            matrices.mass,
            sigma=0.0,
            v0=np.random.default_rng(0).standard_normal(full.unknowns.size),
        )
        return np.sqrt(np.abs(values - shift))[6:], vectors

    whole = PlateState.baseline(*full.sampling, laws, laws.reference, np.array([500.0]))
    under = full.shell.space.spread(full.shell.space.mesh.inside["zone 1"])
    soft = whole.with_(temperature=np.where(under, laws.reference + np.log(1.0 - loss) / slope, laws.reference))
    intact, vectors = frequencies(full.matrices(whole))
    damaged, _ = frequencies(full.matrices(soft))
    places = np.array([(0.02, 0.02)])
    box = MaterialBox((1e9, 4e9), (0.3, 0.45), (0.01, 0.1))
    probe = model.deflection(places).toarray()
    operators = project(full, vectors, model, places, probe, box, (100.0, 900.0), lambda: None)
    basis = field_basis(BENDING_DEGREE)
    spotted = PlateState.baseline(basis.xi, basis.zeta, laws, laws.reference, np.array([500.0]))
    spotted = spotted.with_(discs=(Disc(*place, RADIUS, loss),))
    found = with_spots(operators, composed(operators, Coefficients.of(spotted, operators)), spotted)
    squares = eigh(found.plate + found.fixed, found.mass, eigvals_only=True)[6:]
    shift, wanted = np.sqrt(squares) / intact - 1.0, damaged / intact - 1.0
    assert wanted.min() < -0.004 * loss
    assert shift == pytest.approx(wanted, abs=0.08 * np.abs(wanted).max())
