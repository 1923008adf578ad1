"""A campaign's process for the tests of the watchdog: opens a session, ramps the oven, and does what it is told.

    python -m tests.drivers.watchdog.campaign ADDRESS FOLDER DEED

Prints the number of the watchdog's process when the oven ramps, and how the rig was left at the end.
"""

import ctypes
import json
import signal
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from analysis.protocol.limits import Limits
from drivers.clock import SystemClock
from drivers.interruptions import ENDING
from drivers.ovens.settings import open_oven, oven_settings
from drivers.rig.end_requests import EndRequests
from drivers.rig.rig import Aftercare, Rig
from drivers.rig.session import Session
from drivers.watchdog.frames import WatchdogSettings
from drivers.watchdog.guard import RestRule
from drivers.watchdog.remote_oven import RemoteOven
from tests.drivers.watchdog.served_oven import LIGHT, SETTINGS

LIMITS = Limits(coldest=-10.0, hottest=75.0, lost_after=10.0)
RULE = RestRule(LIGHT.room, window=5.0, patience=20.0, away=3.0, near=3.0)


class NoCards:
    """Cards that do nothing."""

    sample_rate = 1000.0

    def temperatures(self):
        return np.zeros(0)

    def close(self) -> None:
        pass


def rig(address: str) -> Rig:
    table = {**SETTINGS, "port": address}
    clock = SystemClock()

    def opened():
        return open_oven(oven_settings(table), clock)

    def supervise(limits, asked, aftercare):
        log = None if aftercare.log is None else str(aftercare.log)
        settings = WatchdogSettings(oven=table, limits=limits, rest=RULE, log=log, linger=60.0)
        return RemoteOven(settings, opened, asked, aftercare.locks)

    return Rig(NoCards, opened, clock, lambda: datetime.now(UTC), rest_rule=RULE, supervise=supervise)


def do(deed: str, session: Session) -> None:
    """Do as a campaign does that goes well, or badly."""
    until = time.monotonic() + (3.0 if deed in ("end", "log") else 300.0)
    while time.monotonic() < until:
        session.oven.temperature()
        session.sleep_until(session.now + 0.2)
        if deed.startswith("hang"):  # a call that holds the interpreter's lock, as HDF5's do
            ctypes.PyDLL(None).sleep(int(deed.removeprefix("hang")))
        elif deed == "file":  # a call that lets other threads run
            time.sleep(300.0)
        elif deed == "crash":
            ctypes.string_at(0)
        elif deed == "memory":
            import resource

            resource.setrlimit(resource.RLIMIT_AS, (2**28, 2**28))
            hoard = []
            while True:
                hoard.append(bytes(2**20))


def main() -> None:
    address, folder, deed = sys.argv[1:]
    for number in ENDING:  # shells start what runs in the background with some ignored
        signal.signal(number, signal.SIG_DFL)
    told: list[dict] = []

    def log(event: dict) -> None:
        told.append(event)
        if deed == "log":  # how the rig was left cannot be written: its disk hangs
            time.sleep(300.0)

    with EndRequests() as requests:
        session = Session(rig(address), LIMITS, log, requests.check)
        session.aftercare = Aftercare(log=Path(folder) / "watchdog.log")
        ended = "the end"
        try:
            with session:
                session.oven.ramp_to(60.0, 20.0)
                sys.stdout.write(f"{session.oven.process}\n")
                sys.stdout.flush()
                do(deed, session)
        except BaseException as error:  # noqa: BLE001 (whatever it is, the test wants to know it)
            ended = f"{type(error).__name__}: {error}"
    sys.stdout.write(json.dumps({"ended": ended, "unsafe": session.unsafe, "logged": len(told)}))


if __name__ == "__main__":
    main()
