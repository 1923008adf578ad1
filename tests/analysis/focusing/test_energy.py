import numpy as np
import pytest

from analysis.focusing.energy import EnergyForms, FieldSpace


@pytest.fixture
def swept(supported):
    frequency = np.linspace(60.0, 850.0, 9)
    return frequency, [supported.amplitudes(e, 0.33, 0.06, frequency) for e in (2.0e9, 1.1e9)]


def test_forms_equal_the_integrals_over_the_dense_field(supported, swept):
    _, amplitudes = swept
    space, grid = supported.space, supported.grid
    forms = space.forms(amplitudes, displacement=2.0)
    for t, amplitude in enumerate(amplitudes):
        field = np.einsum("kr,nfr->fkn", space.deflection, amplitude)
        whole = np.einsum("fkn,k,fkm->fnm", field.conj(), grid.area, field)
        inside = np.einsum("fkn,k,fkm->fnm", field.conj(), grid.area * grid.target, field)
        aim = np.einsum("fkn,k->fn", field.conj(), 2.0 * grid.area * grid.target)
        np.testing.assert_allclose(forms.plate[t], whole, rtol=1e-11, atol=1e-13 * np.abs(whole).max())
        np.testing.assert_allclose(forms.target[t], inside, rtol=1e-11, atol=1e-13 * np.abs(whole).max())
        np.testing.assert_allclose(forms.aim[t], aim, rtol=1e-11, atol=1e-13 * np.abs(aim).max())


def test_the_energy_of_one_mode_is_that_of_its_closed_form(supported):
    # ∫ sin² sin² = Lx Ly / 4, and the mode is scaled by 2/√m: energy Lx Ly / m.
    amplitude = np.zeros((1, 1, 36), dtype=complex)
    amplitude[0, 0, 7] = 3.0j
    forms = supported.space.forms([amplitude])
    assert forms.plate.real.item() == pytest.approx(9.0 * 0.24 * 0.19 / 0.12996, rel=1e-12)


def test_a_part_of_the_forms(supported, swept):
    forms = supported.space.forms(swept[1])
    lines = swept[0] > 400.0
    part = forms.at(np.array([1]), lines)
    np.testing.assert_array_equal(part.plate[0], forms.plate[1][lines])
    assert part.aim.shape == (1, lines.sum(), 6)


def test_the_deflection_at_a_point_is_the_modal_sum_there(supported, swept):
    frequency, amplitudes = swept
    point = supported.grid.points[417]
    there = supported.space.at_point(amplitudes[0], tuple(point + 1e-4))
    exact = amplitudes[0] @ supported.shapes([point])[0]
    np.testing.assert_allclose(there, exact)
    assert there.shape == (6, len(frequency))


def test_foreign_shapes_are_refused(supported, swept):
    with pytest.raises(ValueError, match="grid of 1200 points"):
        FieldSpace.of(np.zeros((7, 3)), supported.grid)
    forms = supported.space.forms(swept[1])
    with pytest.raises(ValueError, match=r"\(T, F, N\)"):
        EnergyForms(forms.plate, forms.target, forms.aim[:, :, :-1])
