"""Groups of temperature."""

import numpy as np
import pytest

from analysis.gap.data.groups import TemperatureGroups, mean_laws
from analysis.material import Material


def test_up_and_down_ramps_meet_at_each_temperature():
    readings = np.array([10.02, 20.03, 30.0, 29.95, 20.01, 9.97])
    groups = TemperatureGroups.of(readings)
    assert groups.of_sweep.tolist() == [0, 1, 2, 2, 1, 0]
    assert groups.reference == pytest.approx([9.995, 20.02, 29.975])


def test_a_slow_drift_does_not_chain_into_one_group():
    groups = TemperatureGroups.of(np.arange(0.0, 5.0, 0.3), tolerance=0.5)
    assert groups.size.max() == 2


def test_groups_start_from_the_mean_of_their_sweeps():
    groups = TemperatureGroups.of(np.array([10.0, 20.0, 10.1]))
    material = Material(np.exp([1.0, 5.0, 3.0]), np.array([0.3, 0.4, 0.32]), np.exp([-3.0, -2.0, -3.2]))
    assert mean_laws(material, groups)[0] == pytest.approx([2.0, 0.31, -3.1])
