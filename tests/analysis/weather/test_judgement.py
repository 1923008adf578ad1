"""Filters in a weather whose field is known."""

import numpy as np
import pytest

from analysis.weather.family import FieldDesign, TiltFamily
from analysis.weather.judged import (
    ONE,
    OWN_TILTED,
    SEVERAL,
    SEVERAL_ROBUST,
    TILTED,
    WAYS,
    WeatherFields,
    judge_weather,
)

PLACES = np.array([[-0.8, 0.0], [0.8, -0.7], [0.8, 0.7]])
LIMITS = (0.0, 60.0)


def weather(warm, planes):
    fields = np.array([warm.tilted(middle, across) for middle, across in planes])
    read = [[m + 0.5 * (x * a[0] + z * a[1]) for x, z in PLACES] for m, a in planes]
    return WeatherFields(60.0 * np.arange(len(planes)), fields, np.array(read), PLACES, ("a", "b", "c"))


@pytest.fixture(scope="module")
def judged(warm):
    design = FieldDesign.of(warm, warm.plate.panel, 64)
    family = TiltFamily.of(design, np.arange(10.0, 51.0, 5.0), 16.0, LIMITS)
    planes = [(20.0, (0.0, 0.0)), (25.0, (16.0, 0.0)), (32.0, (12.0, 6.0)), (40.0, (0.0, -16.0))]
    return judge_weather(design, family, weather(warm, planes), LIMITS, np.random.default_rng(2))


def test_where_the_field_is_known_exactly_nothing_is_lost(judged):
    way = judged.ways.index(TILTED)
    np.testing.assert_allclose(judged.contrast[way, [0, 1, 3]], judged.known[[0, 1, 3]], atol=1e-6)
    np.testing.assert_allclose(judged.level[way, [0, 1, 3]], 0.0, atol=1e-4)


def test_the_less_is_known_the_more_is_lost(judged):
    lost = {way: judged.largest[place, 1] for place, way in enumerate(judged.ways)}
    assert lost[TILTED] < 0.3 * lost[SEVERAL]
    assert lost[SEVERAL] < lost[ONE]
    assert lost[OWN_TILTED] < 0.5 * lost[SEVERAL]
    assert judged.ways == WAYS


def test_the_price_of_robust_filters_is_what_they_lose_on_an_even_panel(judged):
    robust, plain = judged.ways.index(SEVERAL_ROBUST), judged.ways.index(SEVERAL)
    assert judged.lost[robust, 0, 0] > judged.lost[plain, 0, 0]
    assert judged.price[0] >= judged.lost[robust, 0, 0] - 1e-9


def test_what_is_believed_is_told(judged):
    np.testing.assert_allclose(judged.believed[judged.ways.index(TILTED), 2], [32.0, 12.0, 6.0], atol=1e-3)
    np.testing.assert_allclose(
        judged.believed[judged.ways.index(ONE), 2], [32.0 - 0.4 * 12.0, 0.0, 0.0], atol=1e-9
    )
    assert judged.widest == pytest.approx(np.ptp(judged.extent, axis=1).max())
    assert judged.extent[0] == pytest.approx([20.0, 20.0, 20.0])
