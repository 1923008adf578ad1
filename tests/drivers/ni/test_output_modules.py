import pytest

from drivers.ni.modules import NI_9260, NI_9263


def test_9260_shares_the_ladder_of_the_9234() -> None:
    assert NI_9260.coerced_rate(8500.0) == pytest.approx(51_200.0 / 6.0, rel=1e-12)
    assert NI_9260.coerced_rate(51_200.0 / 6.0) == pytest.approx(51_200.0 / 6.0, rel=1e-12)


def test_9263_divides_the_clock_of_the_chassis() -> None:
    assert NI_9263.coerced_rate(51_200.0 / 6.0) == pytest.approx(80e6 / 9375, rel=1e-12)
    assert NI_9263.coerced_rate(51_200.0) == pytest.approx(80e6 / 1562, rel=1e-12)


@pytest.mark.parametrize(("module", "rate"), [(NI_9260, 51_300.0), (NI_9260, 1_500.0), (NI_9263, 100_100.0)])
def test_rate_out_of_reach_is_refused_with_the_range(module: object, rate: float) -> None:
    with pytest.raises(ValueError, match=f"{rate:g} Hz; NI-92.* allows"):
        module.coerced_rate(rate)  # type: ignore[attr-defined]


def test_quantum_is_the_whole_range_over_the_codes() -> None:
    assert NI_9263.quantum == pytest.approx(20.0 / 65_536)
