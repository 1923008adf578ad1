"""A hammer test on simulated cards, with a plate that costs nothing: one mode, in closed form."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from analysis.arrays import Real
from app.files.acquisition.hammer_folder import hammer_log
from app.files.campaigns.folder import Source
from app.files.declarations.hammer_experiment import HammerExperiment, read_hammer_experiment
from app.rig.assembly import SimulatedHammerRig, simulated_hammer_rig
from app.stages.acquire_hammer import HammerOutcome, acquire_hammer, interrupted_at
from drivers.hammer.campaign import AskedHit, Key, ToldHit, no_key
from drivers.rig.session import Session

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "hammer-rig.toml"
FREQUENCY, DECAY, MASS = 150.0, 40.0, 0.1
"""Hz, 1/s and kg of the only mode of the plate; point p moves with shape 1 + 0.1 p."""


def one_mode(volts: float) -> Callable[[int, Real, float, float], Real]:
    """Acceleration of one mode: impulse response of the velocity sampled, differences of it filtered."""

    def answer(point: int, force: Real, sample_rate: float, temperature: float) -> Real:
        pole = np.exp((-DECAY + 2j * np.pi * FREQUENCY) / sample_rate)
        shape = (1.0 + 0.1 * point) / MASS
        kept = lfilter([1.0], [1.0, -pole], force.astype(complex)).real
        return np.asarray(volts * shape * kept)[None]

    return answer


class Listener:
    """Keeps what is shown."""

    def __init__(self) -> None:
        self.hits: list[ToldHit] = []
        self.places: list[AskedHit] = []
        self.lines: list[str] = []

    def asked(self, hit: AskedHit) -> None:
        self.places.append(hit)

    def told(self, hit: ToldHit) -> None:
        self.hits.append(hit)

    def said(self, line: str) -> None:
        self.lines.append(line)


def experiment(**hand: float) -> HammerExperiment:
    """Return the example, its simulated hammer held otherwise."""
    read = read_hammer_experiment(EXAMPLE)
    assert read.simulation is not None
    held = read.simulation.hammer.model_copy(update=hand)
    return read.model_copy(update={"simulation": read.simulation.model_copy(update={"hammer": held})})


OVEN = """
[oven]
kind = "watlow-f4t"
port = "simulated"
minimum = -5.0
maximum = 65.0
max_rate = 3.0
room_temperature = 22.0

[set_points]
temperatures = [25.0, 35.0, 30.0]
ramp_rate = 3.0
soak = 300.0

[limits]
coldest = -10.0
hottest = 70.0

[hammer]
"""
"""Three set-points, the second above the third: the oven cools, too."""


def text_with_oven() -> str:
    """Return the example's text with an oven, a thermocouple on the plate and two hits at a point."""
    text = EXAMPLE.read_text(encoding="utf-8")
    changes = {
        r"^temperature = 21.0 .*of the plate.*\n": "",
        r'^coupling = "AC"\n': 'coupling = "AC"\nthermocouples = ["cDAQ1Mod3/ai0"]\n',
        r"^hits = 5": "hits = 2",
        r"^\[hammer\]\n": OVEN.lstrip(),
    }
    for pattern, new in changes.items():
        text, count = re.subn(pattern, new, text, count=1, flags=re.MULTILINE)
        assert count == 1, pattern
    return text


def rig(declared: HammerExperiment, since: float = 0.0) -> SimulatedHammerRig:
    """Return simulated cards around the mode."""
    assert declared.simulation is not None
    return simulated_hammer_rig(declared, declared.simulation, one_mode(declared.volts[1]), EXAMPLE, since)


def acquire(
    declared: HammerExperiment,
    folder: Path,
    key: Callable[[], Key | None] = no_key,
    check: Callable[[], None] = lambda: None,
    *,
    again: bool = False,
    prepare: Callable[[SimulatedHammerRig], None] = lambda parts: None,
    unsafe: list[str] | None = None,
) -> tuple[HammerOutcome, Listener, SimulatedHammerRig]:
    """Do what `flexura acquire` does; what is not at rest is put into `unsafe`, without which all must be."""
    parts, heard = rig(declared, interrupted_at(folder)), Listener()
    prepare(parts)
    opened = parts.rig()
    session = None
    if opened.oven is not None and declared.limits is not None:
        session = Session(opened.oven, declared.limits, hammer_log(folder), check)
    acquired = declared.model_dump(mode="json") | {"rig": "simulated"}
    source = Source("mine.toml", "0" * 64)
    outcome = acquire_hammer(
        opened, session, declared, folder, source, acquired, heard, key=key, check=check, again=again
    )
    if unsafe is not None and session is not None:
        unsafe += session.unsafe or ()
    else:
        assert session is None or session.unsafe == ()
    return outcome, heard, parts
