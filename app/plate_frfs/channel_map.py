"""Which declared drive and sensor an FRF belongs to, and its scale to their SI units.

A hammer may move while accelerometers stay where they are; the ends of FRFs are then exchanged. A force at Q
accelerates P as the same force at P accelerates Q (Rayleigh 1873). So the FRFs of all hits that one accelerometer
heard are read as one sweep: a force at the accelerometer, answered at every point of the hammer. All hits then
share one gain, that of hammer and accelerometer, and amplitudes tell shapes; with a drive for every point each hit
would have a gain of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.channel import UNITS, Channel
from analysis.declaration.transducers import BASE_RADIUS
from analysis.estimation.quantities import unit
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from app.files.declarations.plate import FrfsOfPlate
from app.plate_frfs.source_files import FrfsOfFile, captured


def output_of(
    found: FrfsOfFile, frf: MeasuredTransfer, said: FrfsOfPlate, experiment: Experiment
) -> tuple[int, str] | None:
    """Return the sensor of an FRF.

    Parameters
    ----------
    found : FrfsOfFile
        Of its file.
    frf : MeasuredTransfer
    said : FrfsOfPlate
    experiment : Experiment

    Returns
    -------
    (int, str) or None
        Which of the outputs, and what the ``*`` of its key stands for; None for an FRF that is not wanted.

    Raises
    ------
    ValueError
        For a sensor that is not declared, and where no key says which sensor it is.
    """
    ids = [output.id for output in experiment.outputs]
    strangers = [one for one in said.sensors.values() if one not in ids]
    if strangers:
        raise ValueError(f"frf.sensors names {strangers[0]!r}; declared are: {', '.join(ids)}")
    for key, sensor in said.sensors.items():
        for name in (frf.name, frf.response, _plain(frf.response), frf.response.partition(":")[0]):
            star = captured(key, name)
            if star is not None:
                return ids.index(sensor), star
    if said.sensors:
        return None
    for number, name in enumerate(ids):
        if frf.name == name or frf.name.startswith((f"{name}/", f"{name} ")):
            return number, ""
    references = {one.reference for one in found.transfers}
    if len(ids) == 1 and len({one.response for one in found.transfers}) == 1 and len(references) == 1:
        return 0, ""
    raise ValueError(
        f"{found.file}: which sensor is FRF {frf.name!r} (response {frf.response})? Declared: {', '.join(ids)}; "
        f'say it in [[frf]]: sensors = {{ "{frf.name}" = "{ids[0]}" }}. The file holds: {found.names}'
    )


def source_of(
    found: FrfsOfFile, frf: MeasuredTransfer, said: FrfsOfPlate, experiment: Experiment, named: str
) -> int:
    """Return which of the inputs drove.

    Parameters
    ----------
    found : FrfsOfFile
        Of its file.
    frf : MeasuredTransfer
    said : FrfsOfPlate
    experiment : Experiment
    named : str
        Id in the declaration or in a name; empty where none says it.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        For a drive that is not declared, and where several are and nothing says which.
    """
    ids = [one.id for one in experiment.inputs]
    for key, drive in said.drives.items():
        if key in (frf.reference, _plain(frf.reference), frf.reference.partition(":")[0], frf.name):
            named = drive
    if named:
        if named not in ids:
            raise ValueError(f"{found.file}: driven by {named!r}; declared are: {', '.join(ids)}")
        return ids.index(named)
    by_name = [number for number, one in enumerate(ids) if f"/{one} [" in frf.name or frf.name.endswith(f"/{one}")]
    if len(ids) == 1 or len(by_name) == 1:
        return by_name[0] if by_name else 0
    raise ValueError(
        f"{found.file}: which drive does FRF {frf.name!r} (reference {frf.reference}) belong to? Declared: "
        f'{", ".join(ids)}; say in [[frf]] drive = "{ids[0]}", or drives = {{ "{frf.reference}" = "{ids[0]}" }}'
    )


def scale_of(file: str, frf: MeasuredTransfer, output: Channel, source: Channel) -> tuple[float, str]:
    """Return an FRF's scale to SI, and the units that were assumed.

    Parameters
    ----------
    file : str
        For messages.
    frf : MeasuredTransfer
    output, source : Channel
        Its ends, as declared.

    Returns
    -------
    scale : float
    assumed : str
        Empty where the file gives the units.

    Raises
    ------
    ValueError
        Where the FRF is of other quantities than are declared, or in units that are not known.
    """
    scale, assumed = 1.0, False
    ends = (
        ("sensor", output, frf.quantity, frf.units[0]),
        ("drive", source, frf.reference_quantity, frf.units[1]),
    )
    for end, channel, quantity, written in ends:
        seen, factor = quantity, 1.0
        if written:
            try:
                known = unit(written)
            except ValueError as error:
                raise ValueError(f"{file}: FRF {frf.name!r}: {error}; give units in [[frf]]") from error
            seen, factor = known.quantity, known.scale
        if seen not in ("unknown", channel.quantity):
            remedy = f'kind = "{seen}" in its [[sensor]]' if end == "sensor" else "another drive"
            raise ValueError(
                f"{file}: FRF {frf.name!r} is of {seen} at the {end} {channel.id!r}, which is declared with "
                f"{channel.quantity}; declare {remedy}, or correct units in [[frf]]"
            )
        assumed = assumed or not (written or seen != "unknown")
        scale = scale * factor if end == "sensor" else scale / factor
    return scale, f"{UNITS[output.quantity]} and {UNITS[source.quantity]}" if assumed else ""


def _plain(end: str) -> str:
    """Return a place as declarations have it: ``5:+3`` is ``5:+z``."""
    node, _, direction = end.partition(":")
    return f"{node}:{direction[:1]}{' xyz'[int(direction[1:] or 0) % 4]}".strip() if direction else node


TIP = 0.002
"""Radius of a hammer's tip unless declared, m."""


@dataclass(frozen=True)
class PointsByNode:
    """Which channel of a drive or sensor with many points each node of the files is.

    Attributes
    ----------
    roving : bool
        Whether the hammer moved, so that the ends of FRFs are exchanged.
    names : mapping of str to str
        Channel by node, of the hammer, or of sensors that have many points.
    fixed : tuple of str
        Ids of the accelerometers of a roving hammer.
    """

    roving: bool
    names: Mapping[str, str]
    fixed: tuple[str, ...] = ()

    def said_of(self, said: FrfsOfPlate, found: FrfsOfFile) -> FrfsOfPlate:
        """Return what is declared of a file, completed by the nodes, and exchanged where the hammer moved.

        Raises ValueError where several accelerometers are declared and nothing says which FRF is whose.
        """
        if not self.roving:
            named = {**self.names, **said.sensors} if self.names and not said.sensors else said.sensors
            return said.model_copy(update={"sensors": dict(named)})
        if len(self.fixed) > 1 and not said.sensors:
            raise ValueError(
                f"{found.file}: which accelerometer is which FRF? Say it in [[frf]]: sensors = "
                f'{{ "{found.transfers[0].response}" = "{self.fixed[0]}", ... }}'
            )
        moved = {**self.names, **said.drives}
        return said.model_copy(update={"sensors": moved, "drives": dict(said.sensors), "drive": None})


def points_by_node(table: Mapping[str, Any]) -> tuple[dict[str, Any], PointsByNode]:
    """Take the numbers of nodes out of a declaration, and exchange the ends where a drive has many points.

    Parameters
    ----------
    table : mapping
        A plate's declaration, unchecked.

    Returns
    -------
    table : dict
        As experiments have it.
    nodes : PointsByNode

    Raises
    ------
    ValueError
        For a roving hammer beside another drive or beside patches that are read, accelerometers of several kinds,
        and nodes that do not fit the points.
    """
    drives, sensors = (_tables(table, key) for key in ("drive", "sensor"))
    roving = [one for one in drives if "points" in one]
    names: dict[str, str] = {}
    for one in (*roving, *sensors):
        names |= _numbered(one)
    plain = {**table}
    if sensors:
        plain["sensor"] = [{key: value for key, value in one.items() if key != "nodes"} for one in sensors]
    if not roving:
        return plain, PointsByNode(roving=False, names=names)
    _require_fixed(drives, sensors, _tables(table, "patch"))
    hammer = roving[0]
    plain["drive"] = [_as_drive(one) for one in sensors]
    plain["sensor"] = [
        {
            "id": hammer.get("id", "hammer"),
            "kind": sensors[0].get("kind"),
            "points": hammer["points"],
            "radius": hammer.get("radius", TIP),
            "side": hammer.get("side", "top"),
        }
    ]
    kinds = table.get("tolerances", {})
    if isinstance(kinds, Mapping):
        plain["tolerances"] = {"sensitivity": 0.0, **kinds}  # one hammer: its points have no gains of their own
    return plain, PointsByNode(roving=True, names=names, fixed=tuple(str(one.get("id")) for one in sensors))


def _tables(table: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    listed = table.get(key, ())
    return [one for one in listed if isinstance(one, Mapping)] if isinstance(listed, Sequence) else []


def _numbered(one: Mapping[str, Any]) -> dict[str, str]:
    """Return the channels of a drive or sensor with many points by their nodes."""
    points, nodes = one.get("points"), one.get("nodes")
    if not isinstance(points, Sequence):
        if nodes is not None:
            raise ValueError(f"{one.get('id')!r}: nodes without points; give as many points")
        return {}
    if nodes is None:
        nodes = list(range(1, len(points) + 1)) if "kind" not in one else []
    elif not isinstance(nodes, Sequence) or len(nodes) != len(points) or len(set(map(str, nodes))) != len(nodes):
        raise ValueError(f"{one.get('id')!r}: nodes must be {len(points)} different numbers, one for each point")
    return {str(node): f"{one.get('id')}{number}" for number, node in enumerate(nodes, start=1)}


def _require_fixed(
    drives: Sequence[Mapping[str, Any]], sensors: Sequence[Mapping[str, Any]], patches: Sequence[Mapping[str, Any]]
) -> None:
    """Raise ValueError for what does not go with a roving hammer."""
    if len(drives) > 1:
        raise ValueError(
            f"drive: {drives[0].get('id')!r} and {drives[1].get('id')!r}; a hammer with points is the only drive: "
            "declare FRFs of another drive in a plate.toml of its own"
        )
    if any(one.get("role") in ("sensor", "actuator") for one in patches):
        raise ValueError("patch: with a roving hammer, only motions are read; leave patches that are read out")
    kinds = {str(one.get("kind")) for one in sensors}
    if len(kinds) != 1:
        raise ValueError(
            f"sensor: {', '.join(sorted(kinds)) or 'none'} beside a roving hammer; sensors of one kind are wanted"
        )
    many = [str(one.get("id")) for one in sensors if "point" not in one]
    if many:
        raise ValueError(
            f"sensor {many[0]!r} has several points and the hammer, too; give one of them a single point each"
        )


def _as_drive(sensor: Mapping[str, Any]) -> dict[str, Any]:
    """Return the force at an accelerometer, with the accelerometer's mass."""
    base = BASE_RADIUS if sensor.get("kind") == "acceleration" else 0.0
    kept = {key: sensor[key] for key in ("id", "point", "side", "mass") if key in sensor}
    return {**kept, "radius": sensor.get("radius", base), "accelerometer": sensor.get("kind") == "acceleration"}
