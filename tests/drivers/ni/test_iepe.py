"""Sensors that live on a current from their input: fed, settled, and only where the module can."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError

from drivers.ni.cards import Action, DaqError
from drivers.ni.connection import Connection
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.modules import NI_9215, NI_9234
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring

SENSOR = "cDAQ1Mod1/ai2"


@pytest.fixture
def fed(surroundings: Surroundings) -> Surroundings:
    return replace(surroundings, iepe_sensors=frozenset({SENSOR}))


def declared(wiring: Wiring, **changes: object) -> Wiring:
    return Wiring(**{**wiring.model_dump(), "coupling": "AC", **changes})


def test_a_sensor_that_is_fed_answers_in_volts_and_its_bias_has_gone(
    wiring: Wiring, fed: Surroundings, drive: NDArray[np.float64]
) -> None:
    server = SimulatedDaq(fed, seed=3)
    cards = DaqmxCards(declared(wiring, iepe=[SENSOR]), InProcessChannel(server))
    record = cards.sweep(drive)
    assert record.drive.size == drive.size
    assert record.full_scale == 5.0
    assert not record.overloaded.any()
    grid = np.fft.rfftfreq(drive.size, 1.0 / cards.sample_rate)
    inside = (grid > 150.0) & (grid < 1300.0)
    ratio = (np.fft.rfft(record.responses[1]) / np.fft.rfft(record.drive))[inside]
    assert np.abs(ratio + 0.5).max() < 1e-3
    assert abs(record.responses[1][-1000:].mean()) < 1e-4  # of 12 V of bias, some seconds before


def test_without_a_pause_the_bias_is_in_the_record(
    wiring: Wiring, fed: Surroundings, drive: NDArray[np.float64]
) -> None:
    at_once = declared(wiring, iepe=[SENSOR], iepe_settling=0.0)
    record = DaqmxCards(at_once, InProcessChannel(SimulatedDaq(fed))).sweep(drive)
    assert record.overloaded.tolist() == [False, False, True]


def test_a_sensor_that_is_not_fed_is_silent(wiring: Wiring, fed: Surroundings, drive: NDArray[np.float64]) -> None:
    record = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(fed))).sweep(drive)
    assert np.std(record.responses[1]) == pytest.approx(NI_9234.noise, rel=0.05)


def test_a_module_that_feeds_nothing_is_refused_with_those_that_do(wiring: Wiring, fed: Surroundings) -> None:
    other = replace(fed, modules=fed.modules | {4: NI_9215})
    wrong = declared(
        wiring, responses=["cDAQ1Mod1/ai1", "cDAQ1Mod4/ai0"], iepe=["cDAQ1Mod4/ai0"], sample_rate=51_200.0
    )
    with pytest.raises(DaqError, match="is on an NI 9215, which feeds no IEPE sensor") as caught:
        DaqmxCards(wrong, InProcessChannel(SimulatedDaq(other)))
    assert caught.value.action is Action.STOP
    assert "NI 9234" in caught.value.next_step


def test_the_simulated_driver_refuses_it_too(wiring: Wiring, fed: Surroundings) -> None:
    """What a module unknown to Flexura would be told by NI-DAQmx."""
    from nidaqmx.constants import ExcitationSource
    from nidaqmx.errors import DaqError as VendorsError

    other = replace(fed, modules=fed.modules | {4: NI_9215})
    with (
        Connection(channel=InProcessChannel(SimulatedDaq(other))) as connection,
        connection.task("inputs", "cDAQ1Mod4/ai0") as task,
        pytest.raises(VendorsError, match="Excit"),
    ):
        task.ai_channels.add_ai_accel_chan("cDAQ1Mod4/ai0", current_excit_source=ExcitationSource.INTERNAL)


def test_what_is_fed_has_to_be_an_input_and_coupled_as_the_others_are(wiring: Wiring) -> None:
    with pytest.raises(ValidationError, match="iepe names 'cDAQ1Mod1/ai3', which is none of the inputs"):
        declared(wiring, iepe=["cDAQ1Mod1/ai3"])
    with pytest.raises(ValidationError, match='set coupling = "AC"'):
        declared(wiring, iepe=[SENSOR], coupling="DC")
    assert declared(wiring, iepe=list(wiring.inputs), coupling="DC").settling == 5.0
    assert wiring.settling == 0.0


def test_a_campaign_without_it_declares_what_it_did_before(wiring: Wiring) -> None:
    assert not {"iepe", "iepe_settling"} & set(wiring.model_dump())
    assert declared(wiring, iepe=[SENSOR]).model_dump()["iepe"] == (SENSOR,)
