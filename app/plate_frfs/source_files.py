"""FRFs of one file, of any format that is read, with the names that the file gives them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from analysis.arrays import Numbers, Real
from analysis.estimation.estimators import without_information
from analysis.estimation.quantities import frf_name
from analysis.estimation.transfer import MeasuredTransfer
from app.files.bad_file import ResultFileError, quoted
from app.files.declarations.modal_test import ModalTest, RecordOfTest, declares_test
from app.files.declarations.plate import FrfsOfPlate
from app.files.measurements.columns import Columns
from app.files.measurements.guarded import read_columns
from app.files.provenance import sha256
from app.files.uff.frfs import read_frfs
from app.modal_test.declared_test import declared_frfs
from app.modal_test.given_frfs import given_frfs
from app.modal_test.guessed_channels import NewTest, guessed_channels, guessed_frf_units

UNIVERSAL = (".uff", ".unv", ".uf", ".bunv")
REAL_AND_IMAGINARY = "FRF"
"""Name of the only FRF of a file with one real and one imaginary part."""


@dataclass(frozen=True)
class FrfsOfFile:
    """FRFs of one file.

    Attributes
    ----------
    file : str
        Its name, for messages.
    transfers : tuple of MeasuredTransfer
        With the names of the file; where `units` are empty, in SI units of quantities that are not known.
    arrays : mapping of str to (N,) ndarray
        Other numbers of the file, by name.
    temperature : float or None
        Degrees Celsius, where the file gives it.
    notes : tuple of str
    hashes : mapping of str to str
        SHA-256 of what it was read from, by name.
    estimated : bool
        Whether the FRFs and their variances were estimated here, from signals.
    """

    file: str
    transfers: tuple[MeasuredTransfer, ...]
    arrays: Mapping[str, Numbers] = field(default_factory=dict)
    temperature: float | None = None
    notes: tuple[str, ...] = ()
    hashes: Mapping[str, str] = field(default_factory=dict)
    estimated: bool = False

    @property
    def names(self) -> str:
        """Names of the FRFs, for messages."""
        found = list(dict.fromkeys(one.name for one in self.transfers))
        return ", ".join(found[:12]) + (", ..." if len(found) > 12 else "")


def frfs_of_file(path: Path, said: FrfsOfPlate) -> FrfsOfFile:
    """Read the FRFs of a file.

    Parameters
    ----------
    path : Path
        A universal file, a table of numbers of any format, or a modal test's ``test.toml``, whose FRFs are
        estimated from its signals.
    said : FrfsOfPlate

    Returns
    -------
    FrfsOfFile

    Raises
    ------
    ResultFileError
        For a file that cannot be read, or holds no FRF, with what to do.
    """
    if path.suffix.lower() == ".toml":
        return _of_test(path)
    if path.suffix.lower() in UNIVERSAL:
        return FrfsOfFile(path.name, tuple(read_frfs(path)), hashes={path.name: sha256(path)})
    columns = read_columns(path)
    try:
        return _of_columns(path, columns, said)
    except ResultFileError:
        raise
    except ValueError as error:
        raise ResultFileError(f"{path.parent}: {error}") from error


def _of_test(path: Path) -> FrfsOfFile:
    """FRFs estimated from the signals of a modal test, named by their channels."""
    if not declares_test(path):
        raise ResultFileError(f"{path}: no modal test (format flexura-test/1); name files of FRFs, or a test.toml")
    found = declared_frfs(path, lambda _stage, _share: None)
    if found.window_rate:
        raise ResultFileError(
            f"{path}: hammer.exponential adds {found.window_rate:.3g} 1/s of damping to every FRF, which the twin "
            "would take for the plate's own; set hammer.exponential = 1 and lengthen hammer.duration, or give the "
            "modes of flexura identify, from which it is taken out: flexura update MODES.csv --plate plate.toml"
        )
    notes = list(found.notes)
    if found.segments is not None:
        notes.append(
            f"{path.name}: windowed segments of {found.segments.seconds:g} s smear resonances; the loss factors "
            "found are too high by that, longer segments or a periodic drive lessen it"
        )
    return FrfsOfFile(
        path.name,
        tuple(replace(one, name=_channel_of(one)) for one in found.transfers),
        temperature=None if np.isnan(found.temperature) else found.temperature,
        notes=tuple(notes),
        hashes=found.hashes,
        estimated=True,
    )


def _channel_of(frf: MeasuredTransfer) -> str:
    """Name of the column, or of the response's channel, without what was put before it."""
    if frf.quantity == "unknown" or frf.reference_quantity == "unknown":
        return frf.name
    plain = frf.name.removeprefix(f"{frf_name(frf.quantity, frf.reference_quantity)} ")  # type: ignore[arg-type]
    return plain.partition(f" {frf.response} / ")[0]


def _of_columns(path: Path, columns: Columns, said: FrfsOfPlate) -> FrfsOfFile:
    channels = guessed_channels(path, columns, NewTest("frf", {}, {}))
    for name, one in channels.items():
        one["role"] = _role(name, one["role"], said)
    roles = [one["role"] for one in channels.values()]
    notes: tuple[str, ...] = ()
    frfs, coherences = max(roles.count("frf"), 1), roles.count("coherence")
    if coherences not in (0, 1, frfs):
        channels = {n: {"role": "unused"} if one["role"] == "coherence" else one for n, one in channels.items()}
        notes = (
            f"{path.name}: {coherences} coherences of {frfs} FRFs are not used; coherence = {{ SENSOR = "
            '"NAME" } in [[frf]] says which belongs to which',
        )
    if not ("frf" in roles or {"real", "imaginary"} <= set(roles)):
        missing = [key for key in said.sensors if not any(matches(key, name) for name in columns.values)]
        held = ", ".join(list(columns.values)[:12])
        what = f"no FRF {missing[0]!r}" if missing else "no FRFs of complex values"
        raise ResultFileError(
            f"{path}: {what}; it holds: {held}. Export complex FRFs, or real and imaginary parts; of time signals "
            f"make FRFs first (flexura new test {quoted(path.name)}) and name the test.toml in [[frf]] file"
        )
    if "frequency" not in roles:
        raise ResultFileError(
            f"{path}: no channel of frequencies; it holds: {', '.join(list(columns.values)[:12])}. Name it with "
            "frequency in [[frf]]"
        )
    given = guessed_frf_units(columns, channels) if said.units is None else said.units
    test = ModalTest.model_validate(
        {
            "format": "flexura-test/1",
            "kind": "frf",
            "channels": {name: {"role": one["role"]} for name, one in channels.items()},
            "record": ({"file": path.name},),
            **({} if given is None else {"frf": {"response": given[0], "reference": given[1]}}),
        }
    )
    found = given_frfs(RecordOfTest(file=path.name, at={}), columns, test)
    named = [replace(one, name=_name(one, path)) for one in found]
    if given is None:
        named = [replace(one, quantity="unknown", reference_quantity="unknown", units=("", "")) for one in named]
    if said.coherence:
        named = [_with_named_coherence(path, one, columns, said) for one in named]
    used = {one.name for one in named}
    arrays: dict[str, Numbers] = {name: values for name, values in columns.values.items() if name not in used}
    arrays |= {name: np.array([number]) for name, number in columns.scalars.items()}
    return FrfsOfFile(path.name, tuple(named), arrays, notes=notes, hashes={path.name: sha256(path)})


def _role(name: str, guessed: str, said: FrfsOfPlate) -> str:
    """Return the role of a column: as guessed, unless the declaration says or leaves out something else."""
    if name == said.frequency:
        return "frequency"
    if guessed == "frf" and said.sensors:
        return guessed if any(matches(key, name) for key in said.sensors) else "unused"
    named_otherwise = {"frequency": said.frequency is not None, "coherence": bool(said.coherence)}
    unused = guessed in ("drive", "response", "time") or named_otherwise.get(guessed, False)
    return "unused" if unused else guessed


def _name(frf: MeasuredTransfer, path: Path) -> str:
    plain = frf.name.removeprefix(f"{frf_name(frf.quantity, frf.reference_quantity)} ")  # type: ignore[arg-type]
    return REAL_AND_IMAGINARY if plain == path.name else plain


def _with_named_coherence(
    path: Path, frf: MeasuredTransfer, columns: Columns, said: FrfsOfPlate
) -> MeasuredTransfer:
    """Give an FRF the coherence that the declaration names for its sensor."""
    for key, sensor in said.sensors.items():
        star = captured(key, frf.name)
        if star is None or sensor not in said.coherence:
            continue
        wanted = said.coherence[sensor].replace("*", star)
        if wanted not in columns.values:
            held = ", ".join(list(columns.values)[:12])
            raise ResultFileError(f"{path}: no coherence {wanted!r} of {sensor}; it holds: {held}")
        values = columns.values[wanted].real.astype(float)
        if len(values) < len(frf.h):
            raise ResultFileError(
                f"{path}: coherence {wanted!r} has {len(values)} values, {frf.name!r} {len(frf.h)}; export both "
                "alike"
            )
        return replace(frf, coherence=values[-len(frf.h) :])  # a line at 0 Hz is the only one left out
    return frf


def stated_coherence(frf: MeasuredTransfer) -> Real | None:
    """Coherence of an FRF, None where it says nothing of the noise."""
    return None if frf.coherence is None or without_information(frf.coherence) else frf.coherence


def matches(key: str, name: str) -> bool:
    """Whether a key of the declaration means a name of a file."""
    return captured(key, name) is not None


def captured(key: str, name: str) -> str | None:
    """Return what the ``*`` of a key stands for in a name, empty without one; None where they do not agree."""
    if "*" not in key:
        return "" if key == name else None
    found = re.fullmatch(re.escape(key).replace(r"\*", "(.+)", 1).replace(r"\*", ".+"), name)
    return found[1] if found else None
