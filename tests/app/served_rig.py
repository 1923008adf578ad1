"""A whole simulated rig in a process of its own, in real time: cards on a gRPC port, the oven on a TCP port.

    python -m tests.app.served_rig

The first line it prints is JSON with both addresses; for every line it reads it prints its true state.
"""

import json
import sys
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt

from drivers.clock import SystemClock
from drivers.ni.modules import NI_9234
from drivers.ni.output_modules import NI_9260
from drivers.ni.simulated.loopback import serving
from drivers.ni.simulated.servicer import SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.thermocouple_modules import NI_9211
from drivers.ovens.settings import oven_settings
from drivers.ovens.simulated.regulated_oven import RegulatedOven, Regulator
from drivers.ovens.simulated.served import TcpPort
from tests.drivers.watchdog.served_oven import LIGHT, SETTINGS, Asked


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


def main() -> None:
    clock = SystemClock()
    body = RegulatedOven(clock, np.random.default_rng(1), LIGHT, Regulator(period=0.05))
    surroundings = Surroundings(
        plate=plate,
        sensors={"cDAQ1Mod1/ai1": 0},
        drive_inputs=frozenset({"cDAQ1Mod1/ai0"}),
        output="cDAQ1Mod2/ao0",
        plate_temperature=PlateNow(body),
        modules={1: NI_9234, 2: NI_9260, 3: NI_9211},
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
