"""A plain nidaqmx script, as one is written for a bench: play a tone, record it, measure it.

Nothing in it knows Flexura. It talks to whatever answers at the address given: an NI gRPC Device
Server on the laboratory's computer, or the simulated one. Without an address it uses the driver
on this computer.

    python nidaqmx_script.py 127.0.0.1:31763
"""

import argparse

import grpc
import nidaqmx
import numpy as np
from nidaqmx.constants import AcquisitionType, Coupling, TaskMode
from nidaqmx.system import System


def play_and_record(options: nidaqmx.GrpcSessionOptions | None, frequency: float, amplitude: float) -> None:
    """Play two seconds of a tone on ao0, record ai0 and ai1 meanwhile, print what they show."""
    with nidaqmx.Task(grpc_options=options) as inputs, nidaqmx.Task(grpc_options=options) as output:
        inputs.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0:1").ai_coupling = Coupling.DC
        inputs.timing.cfg_samp_clk_timing(8500, sample_mode=AcquisitionType.FINITE, samps_per_chan=17_000)
        rate = inputs.timing.samp_clk_rate
        count = inputs.timing.samp_quant_samp_per_chan

        output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.24, max_val=4.24)
        output.timing.cfg_samp_clk_timing(rate, sample_mode=AcquisitionType.FINITE, samps_per_chan=count)
        inputs.control(TaskMode.TASK_RESERVE)
        output.triggers.start_trigger.cfg_dig_edge_start_trig(inputs.triggers.start_trigger.term)
        tone = amplitude * np.sin(2 * np.pi * frequency * np.arange(count) / rate)
        output.write(tone, auto_start=False)

        output.start()
        inputs.start()
        recorded = np.array(inputs.read(number_of_samples_per_channel=count, timeout=count / rate + 5))
        output.wait_until_done()

    print(f"rate {rate:.4f} Hz")
    settled = recorded[:, count // 2 :]
    window = np.hanning(settled.shape[1])
    time = np.arange(settled.shape[1]) / rate
    for name, signal in zip(("ai0", "ai1"), settled, strict=True):
        spectrum = np.abs(np.fft.rfft(window * signal))
        peak = np.argmax(spectrum) * rate / signal.size
        level = 2 * np.abs(np.sum(window * signal * np.exp(-2j * np.pi * frequency * time))) / window.sum()
        print(f"{name} peak {peak:.2f} Hz amplitude {level:.6f} V")

    with nidaqmx.Task(grpc_options=options) as rest:
        rest.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.24, max_val=4.24)
        rest.write(0.0, auto_start=True)


def main() -> None:
    """Read the command line, list the devices, play and record."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("address", nargs="?", help="host:port of an NI gRPC Device Server")
    parser.add_argument("--frequency", type=float, default=440.0, help="Hz")
    parser.add_argument("--amplitude", type=float, default=1.5, help="V")
    given = parser.parse_args()
    options = None
    if given.address:
        options = nidaqmx.GrpcSessionOptions(grpc.insecure_channel(given.address), "")
    for device in System(options).devices:
        print(f"{device.name}: {device.product_type}")
    play_and_record(options, given.frequency, given.amplitude)


if __name__ == "__main__":
    main()
