"""The simulated cards: how much faster than the clock they stream, what a call costs, what a campaign keeps.

    python benchmarks/simulated_daq.py

Four channels at 51.2 kS/s are read continuously for 60 s of virtual time, over a loopback port and inside
the process, and every sample must be the same. The plain way of getting such a record is to wait for it.
"""

import json
import resource
import time
from operator import itemgetter
from pathlib import Path
from typing import Any

import grpc
import nidaqmx
import numpy as np
from nidaqmx.constants import AcquisitionType
from nidaqmx.stream_readers import AnalogMultiChannelReader
from numpy.typing import NDArray

from drivers.ni.connection import MESSAGE_LIMITS
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq, serving
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring

ROOT = Path(__file__).resolve().parents[1]
RATE, BLOCK, SECONDS = 51_200, 5_120, 60


def wire(drive: NDArray[np.float64], _rate: float, _temperature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the drive: the cards are measured here, not a plate."""
    return drive[None]


def new_server() -> SimulatedDaq:
    """Return a server whose output stands for the whole rig."""
    return SimulatedDaq(Surroundings(wire, {"cDAQ1Mod1/ai1": 0}), seed=1)


def stream(channel: Any) -> tuple[float, NDArray[np.float64]]:
    """Read continuously; return the seconds it took and all samples (4, M)."""
    with nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(channel, "")) as task:
        task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0:3")
        task.timing.cfg_samp_clk_timing(RATE, sample_mode=AcquisitionType.CONTINUOUS)
        reader = AnalogMultiChannelReader(task.in_stream)
        read = np.empty((4, RATE * SECONDS))
        block = np.empty((4, BLOCK))
        task.start()
        started = time.perf_counter()
        for first in range(0, RATE * SECONDS, BLOCK):
            if reader.read_many_sample(block, BLOCK) != BLOCK:
                raise RuntimeError("samples were lost")
            read[:, first : first + BLOCK] = block
        return time.perf_counter() - started, read


def microseconds_a_call(channel: Any, calls: int = 2000) -> float:
    """Return what one small call costs."""
    with nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(channel, "")) as task:
        started = time.perf_counter()
        for _ in range(calls):
            _ = task.name
        return (time.perf_counter() - started) / calls * 1e6


def peak_after(sweeps: int) -> float:
    """Return the process' peak memory after so many sweeps of 10 s at 8.5 kS/s, MB."""
    wiring = Wiring(
        output="cDAQ1Mod2/ao0", drive_input="cDAQ1Mod1/ai0", responses=("cDAQ1Mod1/ai1",), sample_rate=8500.0
    )
    drive = np.sin(np.arange(85_333) / 10.0)
    with DaqmxCards(wiring, InProcessChannel(new_server())) as cards:
        for _ in range(sweeps):
            cards.sweep(drive)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main() -> None:
    """Measure, print, write JSON."""
    short, long = peak_after(31), peak_after(310)
    # The best of three: other programs on the computer only ever add to it.
    inside, read_inside = min((stream(InProcessChannel(new_server())) for _ in range(3)), key=itemgetter(0))
    call_inside = microseconds_a_call(InProcessChannel(new_server()))
    with serving(new_server()) as address, grpc.insecure_channel(address, options=MESSAGE_LIMITS) as channel:
        outside, read_outside = stream(channel)
        for _ in range(2):
            with serving(new_server()) as again, grpc.insecure_channel(again, options=MESSAGE_LIMITS) as other:
                outside = min(outside, stream(other)[0])
        call_outside = microseconds_a_call(channel)
    if not np.array_equal(read_inside, read_outside):
        raise RuntimeError("port and process give different samples")
    result = {
        "virtual_seconds": SECONDS,
        "in_process_seconds": inside,
        "loopback_seconds": outside,
        "ratio": SECONDS / outside,
        "in_process_call_us": call_inside,
        "loopback_call_us": call_outside,
        "peak_mb_31_sweeps": short,
        "peak_mb_310_sweeps": long,
    }
    print(f"{SECONDS} s of 4 x {RATE} S/s, no sample lost, the same both ways:")
    print(f"{outside:.2f} s over the port, {inside:.2f} s in the process; {result['ratio']:.0f}x real time")
    print(f"a small call: {call_outside:.0f} us over the port, {call_inside:.0f} us inside the process")
    print(f"peak memory: {short:.0f} MB after 31 sweeps, {long:.0f} MB after 310")
    results = ROOT / "benchmarks" / "results"
    results.mkdir(exist_ok=True)
    (results / "simulated_daq.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
