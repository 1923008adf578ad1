import pytest

from drivers.ni.modules import NI_9234, find_module


def test_ladder_of_the_9234() -> None:
    rates = NI_9234.rates()
    assert len(rates) == 31
    assert rates[0] == 51_200.0
    assert rates[-1] == pytest.approx(1651.6, abs=0.05)  # the data sheet's 1.652 kS/s
    assert list(rates) == sorted(rates, reverse=True)


def test_what_the_paper_asked_for_is_not_what_it_got() -> None:
    assert not NI_9234.can_run_at(8500.0)
    rate, divisor = NI_9234.nearest_rate(8500.0)
    assert rate == pytest.approx(8533.333333, rel=1e-9)
    assert divisor == 6
    assert NI_9234.can_run_at(rate)


def test_takes_a_neighbours_clock() -> None:
    assert NI_9234.can_run_at(50_000.0 / 3)
    assert not NI_9234.can_run_at(50_000.0 / 32)


def test_quantum_is_ten_volts_over_24_bits() -> None:
    assert NI_9234.quantum == pytest.approx(5.96e-7, rel=1e-3)


@pytest.mark.parametrize("name", ["NI-9234", "NI 9234", "ni9234", "9234"])
def test_module_is_found_however_its_name_is_spaced(name: str) -> None:
    assert find_module(name) is NI_9234


@pytest.mark.parametrize("name", ["", "NI", "NI-9243", "34", "NI-92345"])
def test_other_names_are_unknown(name: str) -> None:
    assert find_module(name) is None


@pytest.mark.parametrize(("asked", "divisor"), [(8500.0, 6), (51_200.0, 1), (7_500.0, 6), (7_314.0, 7), (1.0, 31)])
def test_driver_takes_the_next_rate_that_is_fast_enough(asked: float, divisor: int) -> None:
    assert NI_9234.coerced_rate(asked) == pytest.approx(51_200.0 / divisor, rel=1e-12)


@pytest.mark.parametrize("asked", [51_300.0, 0.0, -1.0, float("nan")])
def test_rate_that_cannot_be_is_refused(asked: float) -> None:
    with pytest.raises(ValueError, match=r"NI-9234 allows 1651\.6 to 51200 Hz"):
        NI_9234.coerced_rate(asked)


def test_delay_is_of_samples_and_of_time() -> None:
    assert NI_9234.delay(51_200.0) == pytest.approx(753.2e-6)
    assert NI_9234.delay(51_200.0 / 6) - 3.2e-6 == pytest.approx(6 * (NI_9234.delay(51_200.0) - 3.2e-6))
