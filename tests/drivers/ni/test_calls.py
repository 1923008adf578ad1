"""The calls nidaqmx makes, held against those recorded: a release that needs others is noticed."""

from pathlib import Path

import nidaqmx
import numpy as np
import pytest
from nidaqmx._stubs.nidaqmx_pb2_grpc import NiDAQmxServicer
from numpy.typing import NDArray

from drivers.ni.cards import DaqError
from drivers.ni.connection import Connection
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ni.simulated.servicer import InProcessChannel, Refusals, SimulatedDaq
from drivers.ni.wiring import Wiring

RECORDED = Path(__file__).with_name("calls.txt")


def test_a_campaign_makes_the_recorded_calls_and_no_other(
    wiring: Wiring, channel: InProcessChannel, server: SimulatedDaq, drive: NDArray[np.float64]
) -> None:
    with DaqmxCards(wiring, channel) as cards:
        cards.temperatures()
        cards.sweep(drive)
        server.inject(Faults(calls=(FailingCall("ReadAnalogF64", -200279),)))
        with pytest.raises(DaqError):
            cards.sweep(drive)
        server.inject(Faults(calls=(FailingCall("CfgSampClkTiming", -200452),)))
        cards.zero()
    Connection(channel=channel).devices()
    assert server.lacking == set()
    assert sorted(server.calls) == RECORDED.read_text(encoding="utf-8").split()


def test_every_recorded_call_is_simulated_and_is_one_of_the_vendors() -> None:
    for call in RECORDED.read_text(encoding="utf-8").split():
        vendors = getattr(NiDAQmxServicer, call)
        assert getattr(SimulatedDaq, call) not in (vendors, vars(Refusals)[call]), call


def test_every_simulated_call_is_one_of_the_vendors() -> None:
    """One that is misspelt, or dropped from the service, would never be made."""
    refused = vars(Refusals)
    capital = [n for n in dir(SimulatedDaq) if n[0].isupper() and getattr(SimulatedDaq, n) is not refused.get(n)]
    assert 50 < len(capital) < 100
    assert [name for name in capital if not hasattr(NiDAQmxServicer, name)] == []


def test_call_and_property_that_are_lacking_are_remembered(
    server: SimulatedDaq, channel: InProcessChannel
) -> None:
    with nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(channel, "")) as task:
        task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
        task.timing.cfg_samp_clk_timing(2000.0)
        with pytest.raises(nidaqmx.errors.DaqError, match=r"Not simulated by Flexura's cards: Get.*IMPEDANCE"):
            _ = task.ai_channels[0].ai_impedance
        with pytest.raises(nidaqmx.errors.DaqError, match="CfgChangeDetectionTiming"):
            task.timing.cfg_change_detection_timing()
        with pytest.raises(nidaqmx.errors.DaqError, match="SAMP_CLK_MAX_RATE"):
            _ = task.timing.samp_clk_max_rate
    assert server.lacking == {
        "GetChanAttributeDouble CHANNEL_ATTRIBUTE_AI_IMPEDANCE",
        "CfgChangeDetectionTiming",
        "GetTimingAttributeDouble TIMING_ATTRIBUTE_SAMP_CLK_MAX_RATE",
    }
