"""A channel of the wrong sign is found whichever it is, and a twin that fits badly inverts none."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.recordings.frf import Frf
from analysis.updating.update import polarity_corrected, update

TEMPERATURE = np.linspace(5.0, 55.0, 5)


def measured(twin, seed: int) -> Frf:
    laws = zip(2.8e9 * np.exp(-0.02 * TEMPERATURE), 0.34 + 0.002 * TEMPERATURE, 5 * [0.05], strict=True)
    return twin.measured(TEMPERATURE, laws, 12.0, np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("sensors", "inverted"),
    [(1, ()), (1, ("S1",)), (3, ()), (3, ("S2",)), (3, ("S1", "S3")), (3, ("S1", "S2", "S3"))],
)
def test_inverted_channels_are_found(affine_modes, sensors: int, inverted: tuple[str, ...]) -> None:
    twin = affine_modes(np.random.default_rng(7), sensors=sensors)
    right = measured(twin, 1)
    wrong = replace(right.turned(inverted), notes=())
    found, begin = polarity_corrected(wrong, twin)
    np.testing.assert_array_equal(found.h, right.h)
    said = " ".join(found.notes)
    if 1 < len(inverted) == sensors:
        assert f"all {sensors} channels are inverted" in said
    else:
        assert [name for name in right.channels if name in said] == list(inverted)
    result = update(found, twin, begin=begin)
    np.testing.assert_allclose(result.misfit, result.noise_floor, rtol=0.2)


def test_another_plate_is_not_taken_for_an_inverted_channel(affine_modes) -> None:
    twin = affine_modes(np.random.default_rng(7), sensors=2)
    frf = measured(affine_modes(np.random.default_rng(8), sensors=2), 2)
    assert polarity_corrected(frf, twin)[0] is frf
