"""Which declared drive and sensor an FRF belongs to, and its scale to their SI units."""

from dataclasses import dataclass

from analysis.channel import UNITS, Channel
from analysis.estimation.quantities import unit
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from app.files.plate_toml import FrfsOfPlate
from app.plate_frfs.source_files import FrfsOfFile, captured


@dataclass(frozen=True)
class ChannelsOfFrf:
    """Of one FRF.

    Attributes
    ----------
    output, source : int
        Which of `Experiment.outputs` and `Experiment.inputs`.
    scale : float
        SI value of one of its numbers.
    star : str
        What the ``*`` of its key in ``sensors`` stands for; empty without one.
    assumed : str
        Units that were assumed where the file gives none; empty where it does.
    """

    output: int
    source: int
    scale: float
    star: str = ""
    assumed: str = ""


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
