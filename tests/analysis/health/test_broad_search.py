"""A change that moves resonances by more than their widths: where fits of it begin."""

import numpy as np

from analysis.health.naming import BroadRecording, broad_starts
from tests.analysis.health.healthy_panel import measured, recorded, usual_watch

X, Y = 0.175, 0.135


def test_widened_resonances_say_what_a_heavy_mass_is_and_where() -> None:
    """By derivatives of the healthy panel it is a spot of damage, and as a mass 83 mm away."""
    watch = usual_watch()
    heavy = {"mass_at_place": {"mass": 0.008, "x": X, "y": Y}}
    watch.take(recorded(measured(13.2, np.random.default_rng(0), heavy)))
    assert watch.dates[-1].strongest == "local damage"
    (date,) = watch.judged
    starts = broad_starts(watch.baseline, [BroadRecording.of(one) for one in date.recordings], date.temperatures)
    assert min(starts, key=lambda name: starts[name].left) == "mass"
    place = starts["mass"].candidate.shapes
    assert np.hypot(place["x"] - X, place["y"] - Y) < 0.02  # half the distance of its sites
