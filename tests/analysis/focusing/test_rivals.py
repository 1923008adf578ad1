import numpy as np
import pytest

from analysis.focusing.methods import invert, modal_control, nearest_actuator, time_reversal
from analysis.focusing.performance import contrast


def test_time_reversal_adds_all_actuators_up_in_phase_at_the_centre(supported):
    frequency = np.linspace(100.0, 800.0, 13)
    amplitude = supported.amplitudes(2.2e9, 0.33, 0.06, frequency)
    response = supported.space.at_point(amplitude, supported.grid.center).T[None]
    total = np.sum(response * time_reversal(response), axis=-1)
    np.testing.assert_allclose(total.imag, 0.0, atol=1e-12 * np.abs(total).max())
    np.testing.assert_allclose(total.real, np.sum(np.abs(response) ** 2, axis=-1))


def test_modal_control_reaches_the_modal_amplitudes_it_asks_for(make_plate, make_panel):
    """A plate of four modes and four actuators: the field is the target's projection, as STIF's is."""
    plate = make_plate(make_panel(((0.05, 0.05), (0.06, 0.14), (0.16, 0.05), (0.17, 0.13))), orders=2)
    frequency = np.linspace(100.0, 500.0, 9)
    space = plate.space
    overlap = space.plate.T @ space.plate
    filters = modal_control(overlap, plate.eigenvalues(2.2e9), plate.forces, space.aim, frequency)
    reached = np.einsum("nfr,fn->fr", plate.amplitudes(2.2e9, 0.33, 0.06, frequency), filters)
    wanted = np.linalg.solve(overlap, space.aim)
    np.testing.assert_allclose(reached, np.broadcast_to(wanted, reached.shape), rtol=1e-9)
    inverse = invert(space.forms([plate.amplitudes(2.2e9, 0.33, 0.06, frequency)]), 1e-7).filters[0]
    np.testing.assert_allclose(filters, inverse, rtol=1e-4)


def test_modal_control_is_held_to_the_modes_known(supported):
    space = supported.space
    with pytest.raises(ValueError, match="36 are known"):
        modal_control(
            space.plate.T @ space.plate, supported.eigenvalues(2e9), supported.forces, space.aim, np.ones(1), 37
        )


def test_stif_focuses_better_than_its_rivals(supported):
    """The order of the paper's Fig. 4, on another plate."""
    frequency = np.linspace(100.0, 540.0, 45)
    amplitude = supported.amplitudes(2.2e9, 0.33, 0.06, frequency)
    space = supported.space
    forms = space.forms([amplitude])
    response = space.at_point(amplitude, supported.grid.center).T[None]
    centers = np.array([patch.center for patch in supported.panel.patch])
    alone = nearest_actuator(centers, supported.grid.center, len(frequency))
    assert np.flatnonzero(alone.any(axis=0)).tolist() == [
        np.argmin(np.hypot(*(centers - supported.grid.center).T))
    ]
    stif = contrast(forms, invert(forms, 0.01).filters).mean()
    reversal = contrast(forms, time_reversal(response)).mean()
    uncontrolled = contrast(forms, alone).mean()
    assert stif > 1.5 * reversal
    assert stif > 1.5 * uncontrolled
