"""A whole simulated rig in a process of its own, in real time: cards on a gRPC port, the oven on a TCP port.

    python -m tests.app.served_rig [hammer]

The first line it prints is JSON with both addresses; for every line it reads it prints its true state. With
``hammer`` the plate is hit every `PERIOD` s, whether somebody waits for it or not.
"""

import json
import sys
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt

from app.files.declarations.hammer_experiment import read_hammer_experiment
from drivers.clock import SystemClock
from drivers.hammer.simulated import LEAD_TIME, Strike, struck_surroundings
from drivers.ni.modules import NI_9211, NI_9234, NI_9260
from drivers.ni.simulated.servicer import SimulatedDaq, serving
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ovens.settings import oven_settings
from drivers.ovens.simulated.regulated_oven import RegulatedOven, Regulator
from tests.app.hammer_bench import EXAMPLE, one_mode
from tests.drivers.ovens.served import TcpPort
from tests.drivers.watchdog.served_oven import LIGHT, SETTINGS, Asked

PERIOD, PEAK, WIDTH, RING = 0.8, 20.0, 4e-4, 0.3
"""Of the hits: s from one to the next, N, half width at 1/e in s, and how long the plate is followed, s."""


def plate(drive, rate, temperature):
    """One resonance that softens."""
    centre = 300.0 * (1.0 - 0.01 * (float(np.mean(temperature)) - 20.0))
    band = butter(1, [0.95 * centre, 1.05 * centre], btype="bandpass", fs=rate, output="sos")
    return 0.5 * sosfilt(band, drive)[None]


@dataclass(frozen=True)
class PlateNow:
    """The plate's temperature; it follows the air within seconds."""

    body: RegulatedOven

    def __call__(self, moments):
        return np.full(np.shape(moments), self.body.plate)


@dataclass(frozen=True)
class SteadyHammer:
    """Hits the plate's only point again and again, at times that nobody has to be asked for."""

    force_volts: float
    response_volts: float
    version: int = 0

    def __call__(self, moments, sample_rate):
        force, answer = np.zeros(moments.size), np.zeros((1, moments.size))
        first, last = moments[0] - RING, moments[-1] + LEAD_TIME
        for number in range(int(np.ceil(first / PERIOD)), int(last / PERIOD) + 1):
            strike = Strike(number, 0, number * PERIOD, "good", ((0.0, PEAK),), WIDTH)
            begin = int(np.ceil((strike.time - LEAD_TIME - moments[0]) * sample_rate))
            grid = moments[0] + np.arange(begin, begin + round((LEAD_TIME + RING) * sample_rate)) / sample_rate
            pulse = strike.force(grid)
            heard = one_mode(self.response_volts)(0, pulse, sample_rate, 20.0)
            low, high = max(begin, 0), min(begin + pulse.size, moments.size)
            if low < high:
                force[low:high] += pulse[low - begin : high - begin]
                answer[:, low:high] += heard[:, low - begin : high - begin]
        return self.force_volts * force, answer


def main() -> None:
    clock = SystemClock()
    body = RegulatedOven(clock, np.random.default_rng(1), LIGHT, Regulator(period=0.05))
    modules = {1: NI_9234, 2: NI_9260, 3: NI_9211}
    if "hammer" in sys.argv:
        declared = read_hammer_experiment(EXAMPLE)
        hammer = SteadyHammer(declared.mallet.sensitivity, declared.volts[1])
        surroundings = struck_surroundings(declared.cards, hammer, modules, PlateNow(body))
    else:
        surroundings = Surroundings(
            plate=plate,
            sensors={"cDAQ1Mod1/ai1": 0},
            drive_inputs=frozenset({"cDAQ1Mod1/ai0"}),
            output="cDAQ1Mod2/ao0",
            plate_temperature=PlateNow(body),
            modules=modules,
        )
    server = SimulatedDaq(surroundings, clock, 1)
    controller = Asked(oven_settings(SETTINGS).simulated(body, clock))
    with TcpPort(controller) as oven, serving(server) as cards:
        sys.stdout.write(json.dumps({"oven": oven.address, "cards": cards}) + "\n")
        sys.stdout.flush()
        for line in sys.stdin:
            if line.strip() == "reset":
                controller.longest = 0.0
            state = {"regulating": body.regulating, "air": body.air, "volts": server.output_voltage()}
            state["longest"] = controller.silence()
            sys.stdout.write(json.dumps(state) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
