"""The reduced model against the full one, over the whole trained box."""

import numpy as np
import pytest

from analysis.material import MaterialBox
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.damped_modes import relative_error, root_mean_square
from simulation.reduction.reduced_model import lowest_modes
from simulation.reduction.vectors.energy_decomposition import mass_orthonormal
from simulation.reduction.vectors.rational_krylov import material_space
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble
from simulation.shell.unknowns import factorize

CORNERS = [(e, nu, eta) for e in (0.8e9, 4e9) for nu in (0.30, 0.48) for eta in (0.02, 0.12)]


def drawn(box, count, seed):
    rng = np.random.default_rng(seed)
    edges = np.array([box.youngs_modulus, box.poisson_ratio, box.loss_factor])
    return [tuple(map(float, row)) for row in rng.uniform(edges[:, 0], edges[:, 1], (count, 3))]


def error_at(model, reduced, material, lines):
    """Largest error over a transfer's rms in the band, at a few lines solved in full."""
    band = np.linspace(*reduced.band, 300)
    rms = np.sqrt(np.mean(np.abs(reduced.compliance(*material, band)) ** 2, axis=-1, keepdims=True))
    wrong = np.abs(reduced.compliance(*material, lines) - model.compliance(*material, lines)) / rms
    return wrong.max()


def test_nominal_twin_keeps_its_promise_over_the_box(nominal_model, nominal):
    """Corners of the box, materials drawn within, frequencies drawn from the band and at its ends."""
    assert nominal.error <= 1e-4
    rng = np.random.default_rng(11)
    for material in CORNERS + drawn(nominal.box, 4, 12):
        assert error_at(nominal_model, nominal, material, [rng.uniform(100.0, 1500.0)]) <= 1e-4
    assert error_at(nominal_model, nominal, CORNERS[0], [100.0, 1500.0]) <= 1e-4


def test_nominal_twin_is_small(nominal):
    """Each evaluation solves a dense eigenproblem of this size."""
    assert nominal.size <= 200


def test_no_rigid_motion_is_carried_along(coarse_model, coarse):
    """A patch pulls at nothing but the plate it sits on: its forces move a free plate nowhere."""
    lowest = np.sqrt(coarse.modal_form(2e9, 0.38, 0.05).poles[0].real) / (2 * np.pi)
    assert lowest == pytest.approx(coarse_model.eigenfrequencies(2e9, 0.38, 7)[6], rel=0.01)


def test_field_equals_the_full_models(coarse_model, coarse):
    lines = [130.0, 365.0, 690.0]
    for material in drawn(coarse.box, 2, 5):
        full = -np.einsum(
            "kn,npf->pfk",
            coarse_model.deflection(coarse.points).toarray(),
            coarse_model.responses(*material, lines),
        )
        reduced = coarse.amplitudes(*material, lines) @ coarse.deflection.T
        assert reduced.shape == (3, 3, 4)
        wrong = np.sqrt(np.mean(np.abs(reduced - full) ** 2, axis=-1))
        assert wrong.max() < 2e-4 * np.sqrt(np.mean(np.abs(full) ** 2))


def test_points_that_only_look_on_change_no_coordinate(coarse_model, coarse):
    plain = reduce(coarse_model, coarse.box, coarse.band)[0]
    seen = reduce(coarse_model, coarse.box, coarse.band, points=coarse.points, field_certified=False)[0]
    np.testing.assert_array_equal(seen.stiffness_1, plain.stiffness_1)
    assert (seen.error, len(plain.deflection)) == (plain.error, 0)
    material, lines = (2e9, 0.38, 0.05), [365.0]
    field, certified = (m.amplitudes(*material, lines) @ m.deflection.T for m in (seen, coarse))
    np.testing.assert_allclose(field, certified, atol=1e-3 * np.abs(certified).max())


def test_modes_are_those_of_the_full_model_with_the_plates_damping(coarse_model, coarse):
    values, shapes = lowest_modes(coarse, 2e9, 0.38, 0.05, 5)
    assert shapes.shape == (coarse.size, 5)
    lowest = coarse_model.eigenfrequencies(2e9, 0.38, 7)[6]
    assert np.sqrt(values[0].real) / (2 * np.pi) == pytest.approx(lowest, rel=0.01)
    assert (values.imag < 0.05 * values.real).all()  # the patches have no losses
    assert (values.imag > 0.03 * values.real).all()


def test_amplitudes_of_chosen_inputs(coarse):
    lines = np.linspace(110.0, 690.0, 7)
    both = coarse.amplitudes(2e9, 0.38, 0.05, lines)
    assert np.array_equal(coarse.amplitudes(2e9, 0.38, 0.05, lines, [2, 0]), both[[2, 0]])


def test_static_content_reciprocity_and_passivity(coarse):
    """The driving point compliance of a passive plate never gives energy: its phase stays in one half."""
    g = coarse.compliance(1.9e9, 0.36, 0.06, np.linspace(100.0, 700.0, 50))
    assert np.allclose(g, g.transpose(1, 0, 2), rtol=1e-6, atol=1e-7 * np.abs(g).max())
    for k in range(3):
        assert np.all(g[k, k].imag < 0.0)


@pytest.mark.parametrize(
    ("material", "lines", "named"),
    [
        ((1.2e9, 0.38, 0.05), [300.0], r"youngs_modulus 1\.2e\+09 .*1\.5e\+09 to 3e\+09"),
        ((2e9, 0.45, 0.05), [300.0], r"poisson_ratio 0\.45 .*0\.34 to 0\.42"),
        ((2e9, 0.38, 0.2), [300.0], r"loss_factor 0\.2 .*0\.03 to 0\.1"),
        ((2e9, 0.38, 0.05), [300.0, 701.0], r"frequency 701 Hz .*100 to 700"),
        ((2e9, 0.38, 0.05), [50.0], r"frequency 50 Hz"),
        ((float("nan"), 0.38, 0.05), [300.0], "youngs_modulus"),
        ((2e9, 0.38, 0.05), [float("nan")], "frequency"),
    ],
)
def test_nothing_is_answered_outside_box_and_band(coarse, material, lines, named):
    for ask in (coarse.compliance, coarse.amplitudes):
        with pytest.raises(ValueError, match=named):
            ask(*material, lines)


def test_krylov_space_holds_the_damped_transfers_of_its_material(coarse_model):
    vectors = material_space(
        coarse_model,
        2e9,
        0.38,
        shifts=np.array([100.0, 700.0]),
        lines=np.linspace(100.0, 700.0, 60),
        loss_factor=0.03,
        tolerance=1e-6,
    )
    lines = np.array([160.0, 410.0, 655.0])
    basis = np.linalg.qr(vectors)[0]
    b = coarse_model.coupling
    small, full = [], []
    for f in lines:
        z = (1 + 0.03j) * coarse_model.stiffness(2e9, 0.38) - (2 * np.pi * f) ** 2 * coarse_model.mass
        small.append((basis.T @ b).T @ np.linalg.solve(basis.T @ (z @ basis), basis.T @ b))
        full.append(b.T @ factorize(z).solve(b.astype(complex)))
    assert relative_error(np.stack(small, -1), np.stack(full, -1)) < 1e-5


def test_mass_orthonormal_drops_what_is_dependent(coarse_model):
    rng = np.random.default_rng(4)
    energy = coarse_model.stiffness(2e9, 0.38) + 1e4 * coarse_model.mass
    vectors = rng.standard_normal((coarse_model.size, 5))
    both = np.hstack([vectors, 1e3 * vectors @ rng.standard_normal((5, 3))])
    basis = mass_orthonormal(both, energy, coarse_model.mass)
    assert basis.shape[1] == 5
    assert basis.T @ (coarse_model.mass @ basis) == pytest.approx(np.eye(5), abs=1e-10)
    assert basis @ (basis.T @ (coarse_model.mass @ both)) == pytest.approx(both, rel=1e-6, abs=1e-6)


def test_trained_materials_leave_no_gap():
    box = MaterialBox((0.5e9, 6e9), (0.2, 0.48), (0.02, 0.1))
    solved, *corrected = BasisTraining().materials(box)
    further = [material for materials in corrected for material in materials]
    e, nu = np.array(solved + further).T
    assert e.min() == pytest.approx(0.5e9)
    assert e.max() == pytest.approx(6e9)
    assert np.diff(np.log(np.unique(e))).max() <= np.log(1.72)
    assert np.diff(np.unique(nu)).max() <= 0.2
    assert {e for e, _ in solved} == {0.5e9}
    assert {(6e9, 0.2), (6e9, 0.48)} <= set(further)
    assert [e for e, _ in further] == sorted(e for e, _ in further)


def test_one_material_needs_no_corrections():
    assert BasisTraining().materials(MaterialBox((2e9, 2e9), (0.3, 0.3), (0.02, 0.1))) == [[(2e9, 0.3)]]


@pytest.mark.slow
def test_resonances_at_the_corners_of_the_box(coarse_model):
    """With little damping: the error measured visits no corner, where it was 3e-3 without corrections."""
    box, band = MaterialBox((0.8e9, 4e9), (0.30, 0.49), (0.005, 0.15)), (100.0, 700.0)
    reduced, _ = reduce(coarse_model, box, band)
    for material in [(e, nu, 0.005) for e in (0.8e9, 4e9) for nu in (0.30, 0.395, 0.49)]:
        lines = np.sqrt(np.abs(reduced.modal_form(*material).poles.real)) / (2 * np.pi)
        lines = lines[(lines > band[0]) & (lines < band[1])]
        full, found = (model.compliance(*material, lines) for model in (coarse_model, reduced))
        over = reduced.damped_modes(*material[:2]).lines(0.005, np.linspace(*band, 200))
        rms = root_mean_square(reduced.compliance(*material, over), over)
        assert (np.abs(found - full) / rms[..., None]).max() <= 1e-4, material


@pytest.mark.parametrize(
    ("box", "band", "named"),
    [
        (MaterialBox((1e9, 4e9), (0.3, 0.5), (0.02, 0.1)), (100.0, 500.0), "material box"),
        (MaterialBox((1e9, 4e9), (0.3, 0.4), (0.02, 0.1)), (500.0, 100.0), "band"),
    ],
)
def test_nonsense_is_refused(coarse_model, box, band, named):
    with pytest.raises(ValueError, match=named):
        reduce(coarse_model, box, band)


def test_a_plate_without_patches_is_refused(plate, coarse_mesh):
    bare = assemble(plate, recipe=coarse_mesh, degree=3)
    with pytest.raises(ValueError, match="neither patch nor force"):
        reduce(bare, MaterialBox((1e9, 2e9), (0.3, 0.4), (0.02, 0.1)), (100.0, 300.0))


@pytest.mark.slow
def test_a_tolerance_out_of_reach_is_said(coarse_model):
    box = MaterialBox((2e9, 2.1e9), (0.37, 0.38), (0.05, 0.06))
    with pytest.raises(RuntimeError, match="converge"):
        reduce(coarse_model, box, (100.0, 300.0), training=BasisTraining(tolerance=1e-18))


def test_progress_ends_at_one(coarse_model):
    shares = []
    box = MaterialBox((2e9, 2.2e9), (0.36, 0.38), (0.05, 0.06))
    reduce(coarse_model, box, (100.0, 300.0), progress=lambda stage, share: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
