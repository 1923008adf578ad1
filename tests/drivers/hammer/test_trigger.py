"""The trigger in software: the same hits however the samples are cut into blocks, with what came before them."""

import numpy as np
import pytest

from analysis.arrays import Real
from drivers.hammer.hammer_rig import SPARE_TIME, HitTrigger, TriggerSettings

RATE = 2000.0
SETTINGS = TriggerSettings(level=0.1, pretrigger=0.05, duration=0.5)
BEFORE, WHOLE = (
    round((0.05 + SPARE_TIME) * RATE),
    round((0.05 + SPARE_TIME) * RATE) + round((0.45 + SPARE_TIME) * RATE),
)


def recording(hits: list[int], samples: int, offset: float = 0.0, height: float = 1.0) -> Real:
    """Two channels: half sines of eleven samples, and the number of the sample."""
    force = np.full(samples, offset)
    for first in hits:
        force[first : first + 11] += height * np.sin(np.pi * (np.arange(11) + 0.5) / 11.0)
    return np.stack([force, np.arange(samples, dtype=float)])


def heard(signals: Real, block: int, trigger: HitTrigger | None = None) -> list[Real]:
    trigger = trigger or HitTrigger(SETTINGS, RATE)
    found = (trigger.feed(signals[:, n : n + block]) for n in range(0, signals.shape[1], block))
    return [record for record in found if record is not None]


@pytest.mark.parametrize("block", [1, 7, 200, 333])
def test_hits_are_the_same_in_blocks_of_any_length(block: int) -> None:
    records = heard(recording([1500, 4000, 5200], 8000), block)
    assert [record.shape for record in records] == [(2, WHOLE)] * 3
    # the level of 0.1 is passed at the first sample of each half sine
    assert [int(record[1, 0]) for record in records] == [hit - BEFORE for hit in (1500, 4000, 5200)]


@pytest.mark.parametrize("offset", [0.5, -0.3])
def test_the_level_counts_from_where_the_force_is_at_rest(offset: float) -> None:
    (record,) = heard(recording([3000], 6000, offset), 200)
    assert int(record[1, 0]) == 3000 - BEFORE


def test_a_second_hit_within_the_block_belongs_to_the_first() -> None:
    records = heard(recording([3000, 3100], 8000), 200)
    assert len(records) == 1
    assert np.sum(np.diff((records[0][0] > 0.5).astype(int)) > 0) == 2


def test_a_force_of_the_wrong_sign_triggers_too() -> None:
    assert len(heard(recording([3000], 6000, height=-1.0), 200)) == 1


def test_a_hit_before_it_was_armed_does_not_count() -> None:
    signals = recording([1500, 3000], 6000)
    trigger = HitTrigger(SETTINGS, RATE)
    assert heard(signals[:, :1600], 100, trigger) == []
    assert trigger.under_way
    trigger.arm()
    assert not trigger.under_way
    (record,) = heard(signals[:, 1600:], 100, trigger)
    assert int(record[1, 0]) == 3000 - BEFORE


def test_a_hit_with_too_little_before_it_is_left_out() -> None:
    assert heard(recording([20], 4000), 100) == []


def test_it_holds_no_more_than_it_needs() -> None:
    trigger = HitTrigger(SETTINGS, RATE)
    for _ in range(100):
        trigger.feed(np.zeros((2, 500)))
    assert trigger._held is not None
    assert trigger._held.shape[1] < 2.0 * RATE
