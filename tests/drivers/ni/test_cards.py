import numpy as np
import pytest

from drivers.ni.cards import Cards, Record
from drivers.ni.daqmx import DaqmxCards


def test_overload_is_told_by_channel() -> None:
    record = Record(np.array([0.1, -0.2]), np.array([[4.996, 0.0], [4.99, -4.99], [0.0, -5.0]]), 8533.3, 5.0)
    assert record.overloaded.tolist() == [False, True, False, True]


@pytest.mark.parametrize(
    ("drive", "responses", "rate"),
    [
        (np.zeros(3), np.zeros((1, 4)), 100.0),
        (np.zeros((1, 3)), np.zeros((1, 3)), 100.0),
        (np.zeros(3), np.zeros(3), 100.0),
        (np.zeros(3), np.zeros((1, 3)), 0.0),
    ],
)
def test_shapes_that_do_not_belong_together_are_refused(
    drive: np.ndarray, responses: np.ndarray, rate: float
) -> None:
    with pytest.raises(ValueError, match=r"shape|rate"):
        Record(drive, responses, rate, 5.0)


def test_the_real_cards_are_cards(cards: DaqmxCards) -> None:
    as_seen_by_a_rig: Cards = cards
    assert as_seen_by_a_rig.sample_rate > 0.0
