from dataclasses import replace

import numpy as np
import pytest

from analysis.identification.modes import Modes, Rejected
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.pole_residue import REAL_E


def modes(f: float = 100.0) -> Modes:
    return Modes(
        poles=2 * np.pi * f * np.array([-0.02 + 1j, -0.06 + 3j]),
        residues=np.array([[1j, 2j]]),
        covariance=np.full((2, 2, 2), 1e-6),
        terms=REAL_E,
        coefficients=np.array([[0.1 + 0j]]),
        status=("kept", "computational"),
        reason=("", "outside"),
        band=(50.0, 200.0),
        misfit=0.01,
        lines=100,
    )


def test_real_are_kept_and_weak_ones() -> None:
    np.testing.assert_array_equal(modes().real, [True, False])
    np.testing.assert_array_equal(replace(modes(), status=("weak", "harmonic")).real, [True, False])


def test_modes_nearer_than_half_their_bandwidth_overlap() -> None:
    both = replace(modes(), status=("kept", "weak"))
    np.testing.assert_array_equal(both.overlapped, [-1, -1])
    close = replace(both, poles=2 * np.pi * 100.0 * np.array([-0.02 + 1j, -0.005 + 1.01j]))
    np.testing.assert_array_equal(close.overlapped, [1, -1])  # half of 4 Hz is more than 1 Hz, half of 1 Hz less
    assert (
        close.read_as("viscous")
        .explanation()[0]
        .endswith("overlaps 101.0 Hz: their damping is known together, not singly")
    )
    assert close.explanation()[1] == "outside"
    np.testing.assert_array_equal(replace(close, status=("kept", "computational")).overlapped, [-1, -1])


@pytest.mark.parametrize(
    ("confirmation", "sure"),
    [
        ((), [True, False]),
        (("confirmed", "confirmed"), [True, False]),
        (("unconfirmed", "confirmed"), [False, False]),
    ],
)
def test_sure_is_kept_and_not_unconfirmed(confirmation: tuple[str, ...], sure: list[bool]) -> None:
    both = replace(modes(), status=("kept", "weak"), confirmation=confirmation)
    np.testing.assert_array_equal(both.sure, sure)


def test_lines_left_out_are_known_again_whatever_rounding_did_to_them() -> None:
    frequency = 40.0 + 0.25 * np.arange(2640)
    gone = tuple(Rejected(2j * np.pi * f, "a tone", "harmonic") for f in frequency[::7])
    left_out = replace(modes(), rejected=(*gone, Rejected(complex(-3.0, 600.0), "BIC"))).left_out(frequency)
    np.testing.assert_array_equal(np.flatnonzero(left_out), np.arange(0, 2640, 7))
    assert not modes().left_out(frequency).any()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"residues": np.ones((1, 3), complex)}, "residues has shape"),
        ({"coefficients": np.ones((1, 2), complex)}, "coefficients has shape"),
        ({"status": ("kept",)}, "2 poles need as many"),
        ({"status": ("kept", "sure")}, "'sure'"),
        ({"confirmation": ("confirmed",)}, "as many confirmations"),
        ({"confirmation": ("confirmed", "maybe")}, "as many confirmations"),
        ({"poles": np.array([1.0 + 5j, -1.0 + 5j])}, "stable"),
    ],
)
def test_nonsense_is_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        replace(modes(), **changes)


def tracked() -> TrackedModes:
    return TrackedModes(
        temperature=np.array([10.0, 20.0]),
        direction=("up", "up"),
        level=np.ones(2),
        channels=("S1",),
        modes=(modes(), modes(90.0)),
        track=np.array([[0, -1], [0, 1]]),
        start=0,
    )


def test_tabulated_values_are_those_of_the_sweeps_and_absent_ones_are_nan() -> None:
    found = tracked()
    read = found.reading("viscous")
    assert read.frequency_hz[1, 0] == pytest.approx(90.0, rel=1e-3)
    assert np.isnan(read.frequency_hz[0, 1])
    assert np.isnan(read.sigma_damping_ratio[0, 1])
    assert found.status == (("kept", "absent"), ("kept", "computational"))
    assert found.residues[1, 0, 1] == 2j
    f = np.array([60.0, 99.0])
    np.testing.assert_array_equal(found.synthesis(f)[1], modes(90.0).synthesis(f))


def test_tracks_must_fit_the_poles() -> None:
    with pytest.raises(ValueError, match="sweep 1"):
        replace(tracked(), track=np.array([[0, -1], [0, 2]]))
    with pytest.raises(ValueError, match="sweep 0"):
        replace(tracked(), track=np.array([[0, 0], [0, 1]]))
    with pytest.raises(ValueError, match="hold 1"):
        replace(tracked(), temperature=np.array([10.0]))


def test_a_heavily_damped_pole_is_read_as_was_chosen() -> None:
    """At a damping ratio of 20 % the frequency of the storage modulus is 4 % below that of |pole|."""
    pole = 2 * np.pi * 100.0 * complex(-0.2, np.sqrt(1.0 - 0.04))
    one = replace(modes(), poles=np.array([pole, 3 * pole]))
    assert one.reading().frequency_hz[0] == pytest.approx(100.0 * np.sqrt(0.92))
    viscous = one.read_as("viscous")
    assert viscous.reading().frequency_hz[0] == pytest.approx(100.0)
    assert viscous.reading().loss_factor[0] == pytest.approx(0.4)
    assert viscous.reading("hysteretic").frequency_hz[0] == one.reading().frequency_hz[0]
    with pytest.raises(ValueError, match="damping 'dry': hysteretic or viscous"):
        replace(one, damping="dry")  # type: ignore[arg-type]


def test_tracked_modes_are_read_as_the_modes_of_their_sweeps() -> None:
    both = TrackedModes(
        temperature=np.array([20.0, 30.0]), direction=("up", "up"), level=np.ones(2), channels=("S1",),
        modes=(modes(), modes(90.0)), track=np.array([[0], [0]]), start=0,
    ).read_as("viscous")  # fmt: skip
    assert [one.damping for one in (both, *both.modes)] == ["viscous"] * 3
    np.testing.assert_allclose(both.reading().frequency_hz[:, 0], np.array([100.0, 90.0]) * np.hypot(1.0, 0.02))
