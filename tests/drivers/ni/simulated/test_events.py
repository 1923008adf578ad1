"""Callbacks: a program that only waits for them still sees time pass."""

import threading
from collections.abc import Callable, Iterator
from typing import Any

import grpc
import nidaqmx
import pytest
from nidaqmx.constants import AcquisitionType
from nidaqmx.errors import DaqError

from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq, serving


@pytest.fixture(params=["in process", "loopback"])
def task(request: pytest.FixtureRequest, server: SimulatedDaq) -> Iterator[Any]:
    if request.param == "in process":
        with nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(InProcessChannel(server), "")) as made:
            yield made
        return
    with (
        serving(server) as address,
        grpc.insecure_channel(address) as channel,
        nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(channel, "")) as made,
    ):
        yield made


def test_every_so_many_samples(task: Any) -> None:
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
    task.timing.cfg_samp_clk_timing(51_200.0, sample_mode=AcquisitionType.CONTINUOUS)
    lengths: list[int] = []
    enough = threading.Event()

    def came(_task: object, _kind: int, count: int, _data: object) -> int:
        lengths.append(len(task.read(count)))
        if len(lengths) == 20:
            enough.set()
        return 0

    task.register_every_n_samples_acquired_into_buffer_event(5120, came)
    task.start()
    assert enough.wait(30.0)
    task.stop()
    assert lengths[:20] == [5120] * 20


def test_done(task: Any, server: SimulatedDaq) -> None:
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
    task.timing.cfg_samp_clk_timing(51_200.0, samps_per_chan=51_200 * 60)
    done: list[int] = []
    ended = threading.Event()

    def came(_task: object, status: int, _data: object) -> int:
        done.append(status)
        ended.set()
        return 0

    task.register_done_event(came)
    task.start()
    assert ended.wait(30.0)
    assert done == [0]
    assert server.clock.now() == pytest.approx(60.0, abs=0.01)


def test_registration_that_is_refused_is_an_error(task: Any, server: SimulatedDaq) -> None:
    server.inject(Faults(calls=(FailingCall("RegisterDoneEvent", -200452),)))
    with pytest.raises(DaqError) as caught:
        task.register_done_event(lambda *_: 0)
    assert caught.value.error_code == -200452


def test_unregistered_event_does_not_come(task: Any, server: SimulatedDaq) -> None:
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
    task.timing.cfg_samp_clk_timing(51_200.0, samps_per_chan=51_200)
    came: list[int] = []
    callback: Callable[..., int] = lambda *_: came.append(1) or 0  # noqa: E731
    task.register_done_event(callback)
    task.register_done_event(None)
    task.start()
    task.read(51_200)
    task.stop()
    assert came == []
