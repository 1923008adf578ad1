"""Drive points take power, and two points see each other alike."""

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from analysis.shapes.stabilization import FrfCheck, checks

F = np.linspace(20.0, 400.0, 400)
SHAPE = np.array([[1.0, 0.6, -0.8], [0.5, -0.9, 0.7], [-0.3, 0.8, 0.9]])
"""Of three modes at three points."""
NATURAL = np.array([60.0, 150.0, 290.0])


def receptance(i: int, j: int) -> np.ndarray:
    w, w0 = 2 * np.pi * F, 2 * np.pi * NATURAL[:, None]
    modes = SHAPE[:, i, None] * SHAPE[:, j, None] / (w0**2 - w**2 + 0.02j * w0 * w)
    return modes.sum(axis=0)


def transfer(i: int, j: int, order: int = 2, sign: str = "+", factor: complex = 1.0) -> MeasuredTransfer:
    quantity = ("displacement", "velocity", "acceleration")[order]
    h = factor * receptance(i, j) * (2j * np.pi * F) ** order * (-1.0 if sign == "-" else 1.0)
    return MeasuredTransfer(f"H{i}{j}", f"{i + 1}:{sign}3", f"{j + 1}:+3", quantity, F, h)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("sign", "+-")
def test_a_drive_point_takes_power_whatever_was_measured(order: int, sign: str) -> None:
    (found,) = checks([transfer(1, 1, order, sign)], F)
    assert found.passed
    assert found.value < 1e-9
    assert "takes power" in found.sentence


def test_a_wrong_sign_and_a_wrong_place_are_no_drive_point() -> None:
    (turned,) = checks([transfer(1, 1, factor=-1.0)], F)
    assert turned == FrfCheck(("H11",), 1.0, passed=False)
    elsewhere = transfer(0, 2)
    elsewhere = MeasuredTransfer("H00", "1:+3", "1:+3", "acceleration", F, elsewhere.h)
    (beside,) = checks([elsewhere], F)
    assert not beside.passed
    assert "check the sensor's sign and place" in beside.sentence


def test_reciprocal_frfs_are_compared_once() -> None:
    (same,) = checks([transfer(0, 1), transfer(1, 0, order=1)], F)  # an accelerance and a mobility
    assert same.names == ("H01", "H10")
    assert same.passed
    assert same.value < 1e-12
    (apart,) = checks([transfer(0, 1), transfer(1, 0, factor=1.3)], F)
    assert apart.value == pytest.approx(0.3 / np.sqrt(0.5 * (1 + 1.3**2)))
    assert not apart.passed
    assert "beside its point" in apart.sentence


def test_what_is_no_motion_over_force_is_left_out() -> None:
    strain = MeasuredTransfer("s", "1:+3", "1:+3", "strain", F, receptance(0, 0))
    voltage = MeasuredTransfer("v", "1:+3", "1:+3", "acceleration", F, receptance(0, 0), "voltage")
    assert checks([strain, voltage], F) == []
