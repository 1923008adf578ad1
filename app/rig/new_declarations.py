"""Declarations to start from: an experiment with the instruments of this computer in it, a focusing panel."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.files.atomic import write_text
from app.files.bad_file import ResultFileError
from app.files.declarations.experiment import read_acquired_experiment
from app.files.declarations.hammer_experiment import read_hammer_experiment
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.settings_toml import read_table, toml_text
from app.files.shipped import shipped
from drivers.ni.cards import DaqError
from drivers.rig.survey import serial_ports

if TYPE_CHECKING:
    from drivers.ni.connection import Device

EXPERIMENT_HEAD = """An experiment, after paper-protocol.toml of the examples, whose comments say more.
Put your own plate, patches, terminals, oven and limits into it (guide, "Connecting real hardware"), then:
    flexura doctor FILE, flexura acquire FILE --rig simulated, flexura acquire FILE --test-shot"""
HAMMER_HEAD = """A hammer test, after hammer-rig.toml of the examples, whose comments say more.
Put your own plate, points, sensors and terminals into it (guide, "A hammer test of a plate"), then:
    flexura acquire FILE --rig simulated, flexura acquire FILE"""
PANEL_HEAD = """A focusing panel, after section2-panel.toml of the examples, whose comments say more.
Put your own patches and target into it (guide, "Designing and exporting filters"), then:
    flexura focus RUN --panel FILE"""
Plate = tuple[float, float, float, float]
"""Length along x and y, thickness, m, and mass, kg."""


@dataclass(frozen=True)
class NewExperiment:
    """What is known of an experiment.

    Attributes
    ----------
    plate : Plate or None
        None for that of the example.
    title : str
    oven : str or None
        Kind of its controller.
    port : str or None
        Where it is reached.
    """

    plate: Plate | None = None
    title: str = ""
    oven: str | None = None
    port: str | None = None


def new_experiment(
    target: Path, said: NewExperiment, devices: "Callable[[], Sequence[Device]] | None" = None
) -> list[str]:
    """Write an experiment's file; return what is still to be completed by hand.

    Parameters
    ----------
    devices : callable, optional
        Lists the devices of the NI driver; that of this computer unless given.

    Returns
    -------
    list of str
        A sentence each.

    Raises
    ------
    ResultFileError
        If the file is there already.
    CampaignFileError
        If what was said makes no experiment.
    """
    _require_free(target)
    table, missing = read_table(shipped("paper-protocol.toml")), []
    table["rig"] = "real"
    table["title"] = said.title or target.stem
    if said.plate is None:
        missing.append("[plate] is the example's: weigh and measure yours")
    else:
        _put_plate(table, said.plate)
    missing.append("[[patch]]: places and sizes are the example's, scaled to the plate")
    missing += _put_terminals(table["cards"], devices)
    missing += _put_oven(table["oven"], said)
    missing.append("[limits] and [amplifier]: what your patch, glue and amplifier are rated for")
    _write(target, toml_text(table, EXPERIMENT_HEAD), read_acquired_experiment)
    return missing


def new_hammer_experiment(
    target: Path, said: NewExperiment, devices: "Callable[[], Sequence[Device]] | None" = None
) -> list[str]:
    """Write the file of a hammer test; return what is still to be completed by hand, see `new_experiment`.

    Parameters
    ----------
    said : NewExperiment
        Without oven and port.
    devices : callable, optional
        Lists the devices of the NI driver; that of this computer unless given.
    """
    _require_free(target)
    table, missing = read_table(shipped("hammer-rig.toml")), []
    table["rig"] = "real"
    table["title"] = said.title or target.stem
    if said.plate is None:
        missing.append("[plate] is the example's: weigh and measure yours")
    else:
        before = table["plate"]["length_x"], table["plate"]["length_y"]
        table["plate"] |= dict(zip(("length_x", "length_y", "thickness", "mass"), said.plate, strict=True))
        table["drive"][0]["points"] = [_moved(one, before, said.plate) for one in table["drive"][0]["points"]]
        table["sensor"][0]["point"] = _moved(table["sensor"][0]["point"], before, said.plate)
    missing.append("[[drive]] points, [[sensor]] point: the example's, scaled to the plate; mark them on yours")
    missing.append("[[drive]], [[sensor]] sensitivity: those of their data sheets")
    missing += _put_inputs(table["cards"], devices)
    missing.append("temperature: of the plate, or a thermocouple on it: cards.thermocouples")
    missing.append("[hammer] duration: until the plate has come to rest; identify says if it is too short")
    _write(target, toml_text(table, HAMMER_HEAD), read_hammer_experiment)
    return missing


def new_panel(target: Path, plate: Plate | None, title: str) -> list[str]:
    """Write a panel's file, its patches and target where the example has them, in shares of the lengths.

    Parameters
    ----------
    plate : Plate or None
        None for that of the example.

    Returns
    -------
    list of str
        What is still to be completed by hand, a sentence each.

    Raises
    ------
    ResultFileError
        If the file is there already, or what was said makes no panel.
    """
    _require_free(target)
    table, missing = read_table(SECTION_2), []
    table["title"] = title or target.stem
    if plate is None:
        missing.append("[plate] is the example's: weigh and measure yours")
    else:
        _put_plate(table, plate)
    missing.append(
        "[[patch]], [target], [filters]: the example's; plate.boundary is " + table["plate"]["boundary"]
    )
    missing.append("[twin], [illustration]: a plastic's; for another material remove both, declare plate.material")
    _write(target, toml_text(table, PANEL_HEAD), read_panel)
    return missing


def _require_free(target: Path) -> None:
    if target.exists():
        raise ResultFileError(f"{target}: is there already; name another with --out, or remove it")


def _write(target: Path, text: str, read: Callable[[Path], object]) -> None:
    """Write a declaration that can be read; one that cannot is not left behind."""
    write_text(target, text)
    try:
        read(target)
    except BaseException:
        target.unlink(missing_ok=True)
        raise


def _put_plate(table: dict[str, Any], plate: Plate) -> None:
    """Put a plate in the place of the example's; patches stay at their shares of its lengths."""
    before = table["plate"]["length_x"], table["plate"]["length_y"]
    table["plate"] |= dict(zip(("length_x", "length_y", "thickness", "mass"), plate, strict=True))
    for patch in table["patch"]:
        patch["center"] = _moved(patch["center"], before, plate)


def _moved(place: Sequence[float], before: tuple[float, float], plate: Plate) -> list[float]:
    """Return a place at its shares of other lengths."""
    return [round(along * now / was, 6) for along, now, was in zip(place, plate, before, strict=False)]


def _put_terminals(cards: dict[str, Any], devices: "Callable[[], Sequence[Device]] | None") -> list[str]:
    """Name terminals that exist, where a driver lists any: an output, two inputs of one module."""
    try:
        found = (devices or _devices)()
    except DaqError as error:
        return [f"[cards]: terminals are the example's; the NI driver says: {error.said}"]
    output = next((device for device in found if device.outputs), None)
    inputs = next((device for device in found if len(device.inputs) > 1), None)
    if output is None or inputs is None:
        return ["[cards]: terminals are the example's; no device with an output and two inputs is connected"]
    cards |= {"output": output.outputs[0], "drive_input": inputs.inputs[0], "responses": [inputs.inputs[1]]}
    return [f"[cards]: found {output.product} and {inputs.product}; check which terminal is wired to what"]


def _put_inputs(cards: dict[str, Any], devices: "Callable[[], Sequence[Device]] | None") -> list[str]:
    """Name two inputs of one module that exist, where a driver lists any."""
    try:
        found = (devices or _devices)()
    except DaqError as error:
        return [f"[cards]: terminals are the example's; the NI driver says: {error.said}"]
    inputs = next((device for device in found if len(device.inputs) > 1), None)
    if inputs is None:
        return ["[cards]: terminals are the example's; no device with two inputs is connected"]
    hammer, sensor = inputs.inputs[:2]
    cards |= {"drive_input": hammer, "responses": [sensor], "iepe": [hammer, sensor]}
    return [f"[cards]: found {inputs.product}; check which terminal is wired to what, and which sensors need IEPE"]


def _devices() -> "Sequence[Device]":
    from drivers.ni.connection import Connection

    with Connection() as connection:
        return connection.devices()


def _put_oven(oven: dict[str, Any], said: NewExperiment) -> list[str]:
    ports, missing = [str(port.device) for port in serial_ports()], []
    if said.oven is not None and said.oven != oven["kind"]:
        for key in ("address", "baud_rate", "decimals"):  # of the example's controller
            del oven[key]
        oven["kind"] = said.oven
    elif said.oven is None:
        missing.append(f"oven.kind is the example's, {oven['kind']}: flexura check-instrument --help names all")
    if said.port is not None:
        oven["port"] = said.port
    elif len(ports) == 1:
        oven["port"] = ports[0]
        missing.append(f"oven.port: {ports[0]}, the only one of this computer")
    else:
        missing.append(f"oven.port is the example's; this computer has: {', '.join(ports) or 'none'}")
    return [*missing, "oven.minimum, maximum, max_rate: what plate, glue and oven stand"]
