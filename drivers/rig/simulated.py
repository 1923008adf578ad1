"""The rig with simulated cards and a simulated oven on a common virtual clock.

The real drivers talk to it: nidaqmx to the simulated device server, the oven's driver to its
simulated controller. Everything in it is a function of the seed, of virtual time and of the times and contents of
the oven's commands, so that a campaign that is killed and resumed gives the same result as an uninterrupted one.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drivers.clock import VirtualClock
from drivers.ni.cards import Cards
from drivers.ni.simulated.surroundings import DrivenPlate, Module, Surroundings
from drivers.ni.wiring import InputWiring, Wiring
from drivers.ovens.expiry import Expiring
from drivers.ovens.oven import Oven
from drivers.ovens.settings import OvenSettings, open_oven
from drivers.ovens.simulated.controller import Controller, MemoryTransport
from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven
from drivers.rig.rig import Rig
from drivers.soundcard.card import SoundCard, SoundCards
from drivers.soundcard.simulated import SimulatedSound, simulated_sound
from drivers.thermometers.thermometer import Thermometer, ThermometerSettings
from drivers.watchdog.guard import RestRule
from drivers.watchdog.supervision import PERIOD, QUIET

if TYPE_CHECKING:
    from drivers.ni.simulated.servicer import SimulatedDaq

EPOCH = datetime(2000, 1, 1, tzinfo=UTC)
"""Start of virtual time: a date that no real measurement has."""

KEPT = frozenset({"oven", "finished", "rejected", "missing", "hit", "hit rejected"})
"""Events at which a resumed campaign may continue."""


@dataclass(frozen=True)
class SimulatedParts:
    """Parts of a simulated rig, for tests that inspect it or cause faults.

    Attributes
    ----------
    clock : VirtualClock
    body : RegulatedOven
        Thermal model of air and plate.
    controller : Controller
        May be wrapped to simulate a disturbed line.
    server : SimulatedDaq or None
        The cards' device server; None for a rig with a sound card.
    wiring : InputWiring or SoundCard
        A `Wiring`, unless the plate is hit and nothing is played.
    oven : OvenSettings
    address : str or None
        ``host:port`` of the server; None to call it inside this process.
    lines : list of MemoryTransport
        Connections to the controller, one for each opening of the oven.
    thermometer : (ThermometerSettings, Controller) or None
        On the plate; None if there are only the cards' thermocouples.
    sound : SimulatedSound or None
        The sound card of a rig that has one.
    room : float
        Temperature around the oven, degrees Celsius.
    """

    clock: VirtualClock
    body: RegulatedOven
    controller: Controller
    server: "SimulatedDaq | None"
    wiring: InputWiring | SoundCard
    oven: OvenSettings
    address: str | None = None
    lines: list[MemoryTransport] = field(default_factory=list)
    thermometer: tuple[ThermometerSettings, Controller] | None = None
    sound: SimulatedSound | None = None
    room: float = Chamber.room

    def rig(self) -> Rig:
        """Return the rig as a campaign uses it."""
        opens = None if self.thermometer is None else self._open_thermometer
        rule = RestRule(self.oven.rest_temperature(self.room))
        return Rig(self._open_cards, self._open_oven, self.clock, self._date, self._restore, opens, rule)

    def _open_cards(self) -> Cards:
        if isinstance(self.wiring, SoundCard):
            return SoundCards(self.wiring, self.sound, self.clock)
        from drivers.ni.daqmx import DaqmxCards, EndlessInputs, as_cards
        from drivers.ni.simulated.servicer import InProcessChannel

        if self.server is None:
            raise AssertionError("NI cards are simulated by a server")
        wiring, channel = self.wiring.model_copy(update={"grpc": self.address}), None
        if self.address is None:
            channel = InProcessChannel(self.server)
        if isinstance(wiring, Wiring):
            return DaqmxCards(wiring, channel)
        return as_cards(EndlessInputs(wiring, channel))

    def _open_oven(self) -> Oven:
        self.lines.append(MemoryTransport(self.controller, self.clock))
        return open_oven(self.oven, self.clock, self.lines[-1])

    def _open_thermometer(self) -> Thermometer:
        if self.thermometer is None:
            raise AssertionError("a rig without one does not ask for it")
        settings, instrument = self.thermometer
        return settings.open(self.clock, MemoryTransport(instrument, self.clock))

    def _date(self) -> datetime:
        return EPOCH + timedelta(seconds=round(self.clock.now(), 3))

    def _restore(self, oven: Oven, events: Sequence[Mapping[str, Any]]) -> None:
        """Repeat the oven's commands at their times, and advance the clock to the last event that counts."""
        for event in events:
            if event.get("event") != "oven":
                continue
            self._pass(oven, float(event["time"]))
            match event["command"]:
                case "ramp":
                    oven.ramp_to(float(event["target"]), float(event["rate"]))
                case "hold":
                    oven.hold()
                case "safe":
                    oven.safe()
        last = max((float(event["time"]) for event in events if event.get("event") in KEPT), default=0.0)
        self._pass(oven, last)

    def _pass(self, oven: Oven, until: float) -> None:
        """Advance the clock; an oven that has to be polled is polled at the times of the supervision."""
        if not isinstance(oven, Expiring) or not (self.oven.expires or oven.poll_within < math.inf):
            self.clock.sleep(until - self.clock.now())
            return
        while (left := until - self.clock.now()) > 0.0:
            whole = PERIOD * (math.floor(self.clock.now() / PERIOD + 1e-6) + 1.0)
            self.clock.sleep(min(left, whole - self.clock.now()))
            if oven.poll_within < math.inf and self.clock.now() % QUIET < PERIOD:
                oven.temperature()
            oven.renew()


def simulated_parts(
    wiring: Wiring | SoundCard,
    oven: OvenSettings,
    plate: DrivenPlate,
    *,
    modules: Mapping[int, Module],
    seed: int,
    chamber: Chamber | None = None,
    drive_scale: float = 1.0,
    thermometer: ThermometerSettings | None = None,
    **chassis: Any,
) -> SimulatedParts:
    """Build a simulated rig around a plate.

    Parameters
    ----------
    wiring : Wiring or SoundCard
        As for the real cards; the plate's sensors are connected to `wiring.responses` in this order.
    oven : OvenSettings
        The kind decides which controller is simulated.
    modules : mapping of int to Module
        Slot -> module in it.
    seed : int
        Of the noise of sensors and cards.
    drive_scale : float
        Volts at the drive's input per volt of the output, see `Surroundings`.
    thermometer : ThermometerSettings, optional
        On the plate, besides the cards' thermocouples.
    **chassis
        Further arguments of `Surroundings`, such as clock errors.

    Raises
    ------
    ValueError
        If a terminal of the wiring is on no module, or the kind of oven or thermometer cannot be simulated.
    """
    chamber = chamber or Chamber()
    clock = VirtualClock()
    body = RegulatedOven(clock, np.random.default_rng(seed), chamber)
    forecast, server, sound = PlateForecast(clock, body, chamber), None, None
    if isinstance(wiring, SoundCard):
        sound = simulated_sound(wiring, plate, clock, temperature=forecast, seed=seed, drive_scale=drive_scale)
    else:
        from drivers.ni.simulated.servicer import SimulatedDaq

        surroundings = Surroundings(
            plate=plate,
            sensors={terminal: row for row, terminal in enumerate(wiring.responses)},
            drive_inputs=frozenset({wiring.drive_input}),
            drive_scale=drive_scale,
            output=wiring.output,
            plate_temperature=forecast,
            chassis=wiring.output.split("/")[0].partition("Mod")[0],
            modules=dict(modules),
            **chassis,
        )
        server = SimulatedDaq(surroundings, clock, seed)
    return parts_in_oven(clock, body, server, wiring, oven, thermometer, sound=sound, room=chamber.room)


def parts_in_oven(
    clock: VirtualClock,
    body: RegulatedOven,
    server: "SimulatedDaq | None",
    wiring: InputWiring | SoundCard,
    oven: OvenSettings,
    thermometer: ThermometerSettings | None,
    *,
    sound: SimulatedSound | None = None,
    room: float,
) -> SimulatedParts:
    """Simulate controller and thermometer of an oven, beside its cards.

    Raises
    ------
    ValueError
        If the kind of oven or thermometer cannot be simulated.
    """
    controller = oven.simulated(body, clock)
    if controller is None:
        raise ValueError(f"oven.kind {oven.kind!r} brings no simulated controller")
    parts = SimulatedParts(clock, body, controller, server, wiring, oven, sound=sound, room=room)
    if thermometer is None:
        return parts
    instrument = thermometer.simulated(body, clock)
    if instrument is None:
        raise ValueError(f"thermometer.kind {thermometer.kind!r} brings no simulated instrument")
    return replace(parts, thermometer=(thermometer, instrument))


@dataclass(frozen=True)
class PlateForecast:
    """The plate's temperature around the present time, extrapolated by its present rate of change.

    The error is the curvature over one record, which is small for a plate with a time constant of minutes.
    """

    clock: VirtualClock
    body: RegulatedOven
    chamber: Chamber

    def __call__(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the temperature at moments (M,), degrees Celsius."""
        plate = self.body.plate
        slope = (self.body.air - plate) * self.chamber.plate_conductance / self.chamber.plate_capacity
        return np.asarray(plate + slope * (np.asarray(moments) - self.clock.now()))
