"""List of what is connected to this computer, and whether it responds; only reads, changes nothing."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.ni.cards import DaqError
from drivers.ni.wiring import InputWiring
from drivers.ovens.error import OvenError
from drivers.ovens.settings import OvenSettings, open_oven
from drivers.soundcard.card import NOT_STARTED, SoundCard, backend, channel_number

if TYPE_CHECKING:
    from serial.tools.list_ports_common import ListPortInfo

    from drivers.ni.connection import Device


class FindingState(StrEnum):
    """Severity of a finding."""

    GOOD = "good"
    NOTE = "note"
    """Does not affect what was requested."""
    BAD = "bad"


@dataclass(frozen=True)
class Finding:
    """Result of one check.

    Attributes
    ----------
    what : str
        What was checked.
    state : FindingState
    seen : str
        Details; may be empty if it is present.
    next_step : str
        What to do about it; empty if nothing.
    """

    what: str
    state: FindingState
    seen: str
    next_step: str = ""


def look_at_cards(wiring: InputWiring | None, *, needed: bool) -> Iterator[Finding]:
    """Yield the devices of the NI driver, local or on the server of `wiring`, and whether the wiring fits.

    Parameters
    ----------
    needed : bool
        Whether a missing part is bad or only a note.
    """
    from drivers.ni.connection import Connection

    lacking = FindingState.BAD if needed else FindingState.NOTE
    where = f"server {wiring.grpc}" if wiring is not None and wiring.grpc else "this computer"
    try:
        with Connection(wiring.grpc if wiring is not None else None) as connection:
            devices = connection.devices()
    except DaqError as error:
        yield Finding("NI driver", lacking, f"{where}: {error.said}", error.next_step)
        return
    yield Finding("NI driver", FindingState.GOOD, f"answers on {where}")
    if not devices:
        step = "connect the chassis, switch it on, and look for it in NI MAX or NI Hardware Configuration Utility"
        yield Finding("NI devices", lacking, "none", step)
    for device in devices:
        channels = f"{len(device.inputs)} inputs, {len(device.outputs)} outputs"
        simulated = ", simulated" if device.simulated else ""
        yield Finding(f"NI device {device.name}", FindingState.GOOD, f"{device.product}, {channels}{simulated}")
    if wiring is not None and devices:
        yield _terminals(wiring, devices, lacking)
    if wiring is not None and wiring.iepe:
        yield _supply(wiring, devices, lacking)


def _terminals(wiring: InputWiring, devices: "tuple[Device, ...]", lacking: FindingState) -> Finding:
    there = {channel for device in devices for channel in device.inputs + device.outputs}
    asked = wiring.terminals
    missing = [terminal for terminal in asked if terminal not in there]
    if not missing:
        return Finding("terminals of [cards]", FindingState.GOOD, f"all {len(asked)} exist")
    step = f"correct [cards]; what exists: {', '.join(sorted(there)) or 'no terminal at all'}"
    return Finding("terminals of [cards]", lacking, f"not there: {', '.join(missing)}", step)


def _supply(wiring: InputWiring, devices: "tuple[Device, ...]", lacking: FindingState) -> Finding:
    from drivers.ni.connection import require_iepe

    what, named = "IEPE supply of [cards]", ", ".join(wiring.iepe)
    try:
        require_iepe(wiring, devices)
    except DaqError as error:
        return Finding(what, lacking, error.said, error.next_step)
    return Finding(what, FindingState.GOOD, f"will be switched on at {named}")


def look_at_sound(settings: SoundCard, *, needed: bool, sound: Any = None) -> Finding:
    """Look for a sound card and count its channels. Nothing is played.

    Parameters
    ----------
    needed : bool
        Whether a missing part is bad or only a note.
    sound : object, optional
        Replaces the package ``sounddevice``, for tests.
    """
    lacking, what = FindingState.BAD if needed else FindingState.NOTE, f"sound card {settings.device}".rstrip()
    try:
        sound = sound if sound is not None else backend()
        found = [sound.query_devices(settings.device or None, kind) for kind in ("input", "output")]
    except DaqError as error:
        return Finding(what, lacking, error.said, error.next_step)
    except ValueError as error:  # no such device
        return Finding(what, lacking, str(error), "correct cards.device; python -m sounddevice lists all")
    except sound.PortAudioError as error:
        return Finding(what, lacking, f"PortAudio fails: {error}", NOT_STARTED)
    there = int(found[0]["max_input_channels"]), int(found[1]["max_output_channels"])
    wanted = max(map(channel_number, settings.inputs)), channel_number(settings.output)
    seen = f"{found[0]['name']}, {there[0]} inputs, {there[1]} outputs"
    if there[0] < wanted[0] or there[1] < wanted[1]:
        return Finding(what, lacking, seen, f"[cards] asks for in{wanted[0]} and out{wanted[1]}: correct it")
    return Finding(what, FindingState.GOOD, seen)


def serial_ports() -> "list[ListPortInfo]":
    """Return every serial port of this computer, by name."""
    from serial.tools import list_ports

    return sorted(list_ports.comports(), key=lambda port: str(port.device))


def look_at_ports() -> Iterator[Finding]:
    """Yield every serial port."""
    ports = serial_ports()
    if not ports:
        step = (
            "connect the oven's cable or its USB adapter, and install the adapter's driver, if an oven is needed"
        )
        yield Finding("serial ports", FindingState.NOTE, "none", step)
    for port in ports:
        usable = os.name == "nt" or os.access(port.device, os.R_OK | os.W_OK)
        step = "" if usable else "get the right to use it (on Linux: the group dialout), log out and in again"
        known = "" if port.description in (None, "n/a") else str(port.description)  # pyserial's text for "unknown"
        seen = known if usable else f"{known or 'there'}, but not for this user"
        yield Finding(f"serial port {port.device}", FindingState.GOOD if usable else FindingState.NOTE, seen, step)


def look_at_oven(settings: OvenSettings, *, needed: bool) -> Finding:
    """Read an oven's temperature, and change nothing."""
    lacking = FindingState.BAD if needed else FindingState.NOTE
    place = settings.place
    name = f"oven {settings.kind} at {place}" if place else f"oven {settings.kind}"
    if not needed and place and "://" not in place and not Path(place).exists():
        return Finding(
            name, FindingState.NOTE, "no such port", "nothing to do: this experiment's rig is simulated"
        )
    try:
        oven = open_oven(settings)
        try:
            temperature = oven.temperature()
        finally:
            oven.close()
    except OvenError as error:
        return Finding(name, lacking, error.what, error.advice)
    limits = settings.limits()
    if not limits.minimum - 20.0 <= temperature <= limits.maximum + 20.0:
        step = "check its sensor, and that the controller's unit is degrees Celsius (decimals, for a Eurotherm)"
        return Finding(name, lacking, f"answers {temperature:.1f} °C, far beyond its limits", step)
    return Finding(name, FindingState.GOOD, f"answers {temperature:.1f} °C")
