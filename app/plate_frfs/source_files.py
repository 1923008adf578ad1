"""FRFs of one file, of any format that is read, with the names that the file gives them.

At which temperature, in which direction and at which level an FRF was measured: declared, or in a name.

FRFs of ``frf.h5``, which Flexura wrote itself, with their noise.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from analysis.arrays import Complex, Numbers, Real
from analysis.declaration.strict import TEMPERATURES
from analysis.estimation.estimators import without_information
from analysis.estimation.quantities import frf_name
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from analysis.recordings.frf import Frf
from analysis.recordings.frf_campaign import Noise
from app.files.bad_file import ResultFileError, quoted
from app.files.declarations.modal_test import ModalTest, RecordOfTest, declares_test
from app.files.declarations.plate import FrfsOfPlate
from app.files.hdf5_file import HDF5
from app.files.measurements.columns import Columns
from app.files.measurements.guarded import read_columns
from app.files.provenance import sha256
from app.files.results.modes_file import load_frf
from app.files.uff.frfs import read_frfs
from app.modal_test.declared_test import declared_frfs
from app.modal_test.guessed_channels import NewTest, guessed_channels, guessed_frf_units
from app.modal_test.new_declaration import guessed_places
from app.modal_test.signals import given_frfs

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
    ends = _ends_of_file(channels, columns, said)
    for name, one in channels.items():
        at = ends.get(name, {}).get("at", "")
        one["role"] = _role((name, at, at.partition(":")[0]), one["role"], said)
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
            "channels": {name: {"role": one["role"], **ends.get(name, {})} for name, one in channels.items()},
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


def _ends_of_file(
    channels: Mapping[str, Mapping[str, str]], columns: Columns, said: FrfsOfPlate
) -> dict[str, dict[str, str]]:
    """Return ``at`` and ``reference`` of the FRFs of which the file gives both.

    Of none where the first axis of arrays counts sweeps, at temperatures that the file lists, and not responses.
    """
    if any("*" in key for key in said.sensors) or any(is_temperatures(*one) for one in columns.values.items()):
        return {}
    placed = guessed_places(channels, columns)
    return {n: {end: one[end] for end in ("at", "reference")} for n, one in placed.items() if "reference" in one}


TEMPERATURE_NAMES = r"^(T|temp.*|theta)$"
"""What arrays of temperatures are called."""


def is_temperatures(name: str, values: Numbers) -> bool:
    """Whether an array holds the temperatures of several sweeps."""
    return re.match(TEMPERATURE_NAMES, name, re.IGNORECASE) is not None and len(values) > 1


def _role(names: Sequence[str], guessed: str, said: FrfsOfPlate) -> str:
    """Return the role of a column: as guessed, unless the declaration says or leaves out something else.

    Behind its name in `names` are its node with direction and without, where the file gives them.
    """
    if names[0] == said.frequency:
        return "frequency"
    if guessed == "frf" and said.sensors:
        return guessed if any(matches(key, name) for key in said.sensors for name in names) else "unused"
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


Direction = Literal["up", "down"]

NUMBER = r"(?:(?<![A-Za-z0-9.])[-+])?(?<![0-9.])\d+(?:[.,]\d+)?"
"""A number in a name. A sign counts behind a space, an underscore, a bracket or nothing: in ``frf-20C`` the stroke
joins two words."""
PARTS = {"temperature": NUMBER, "level": NUMBER, "direction": "up|down", "drive": r"[^\s_/]+?"}
USUAL = (
    rf"(?P<temperature>{NUMBER})\s*(?:°|deg)?\s*C(?![A-Za-z])"
    rf"(?:[\s_]+(?P<direction>up|down)(?![A-Za-z]))?(?:[\s_]+(?P<level>{NUMBER})\s*[VN](?![A-Za-z]))?"
)
"""Temperature as most name it, and what Flexura's exports have behind it: ``scan_21.5C``, ``20.01 C up 0.3 V``."""


@dataclass(frozen=True)
class MeasuredAt:
    """Of one FRF.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    direction : str
        ``up`` or ``down``.
    level : float
        V or N; 1 where it is not known.
    drive : str
        Id of what drove; empty where neither the declaration nor a name says so.
    """

    temperature: float
    direction: Direction = "up"
    level: float = 1.0
    drive: str = ""


def circumstances(found: FrfsOfFile, path: Path, name: str, star: str, said: FrfsOfPlate) -> MeasuredAt:
    """Return the circumstances of an FRF.

    Parameters
    ----------
    found : FrfsOfFile
        Of its file.
    path : Path
        The file.
    name : str
        Of the FRF.
    star : str
        What the ``*`` of its key in ``sensors`` stands for; empty without one.
    said : FrfsOfPlate

    Returns
    -------
    MeasuredAt

    Raises
    ------
    ValueError
        Where no temperature is found, or one that cannot be, with what to write.
    """
    in_name = _in_names(path, name, said.pattern)
    temperature = _number("temperature", said.temperature, found, star)
    if temperature is None:
        temperature = in_name.get("temperature", found.temperature)
    if temperature is None:
        raise ValueError(
            f"{found.file}: no temperature, neither in its name nor in that of FRF {name!r}; give temperature in "
            '[[frf]], in °C or the name of an array in the file, or pattern = "{temperature}C"'
        )
    low, high = TEMPERATURES
    if not low <= temperature <= high:
        raise ValueError(
            f"{found.file}: temperature = {temperature:g} °C of {name!r}; allowed: {low:g} to {high:g}"
        )
    level = _number("level", said.level, found, star)
    if level is None:
        level = in_name.get("level", 1.0)
    if not 0.0 < level <= 1000.0:
        raise ValueError(f"{found.file}: level = {level:g} of {name!r}; allowed: above 0 to 1000 (V or N)")
    words = _words_in_names(path, name, said.pattern)
    way = said.direction
    if way not in ("up", "down"):
        way = "down" if (_number("direction", way, found, star) or 0.0) > 0.5 else "up"
    direction: Direction = "down" if words.get("direction", way) == "down" else "up"
    return MeasuredAt(temperature, direction, level, said.drive or words.get("drive", ""))


def _number(key: str, given: float | str | None, found: FrfsOfFile, star: str) -> float | None:
    """Return a number as declared, or from the array of the file that the declaration names."""
    if given is None or isinstance(given, float | int):
        return None if given is None else float(given)
    if given not in found.arrays:
        # an array with several rows has become columns: T[1], T[2], ...
        several = f"{given}[{star}]" if star else ""
        if several not in found.arrays:
            held = ", ".join(list(found.arrays)[:12]) or "no other numbers"
            raise ValueError(f"{found.file}: {key} = {given!r}, but the file has no such array; it holds: {held}")
        return _mean(key, several, found.arrays[several], found.file)
    values = found.arrays[given]
    if not star or len(values) == 1:
        return _mean(key, given, values, found.file)
    number = re.match(r"\d+", star)
    place = int(number[0]) if number else 0
    if not 1 <= place <= len(values):
        raise ValueError(
            f"{found.file}: {key} = {given!r} has {len(values)} values, but the FRFs go on to number {star!r}; "
            "one for each sweep is wanted"
        )
    return float(values[place - 1].real)


def _mean(key: str, name: str, values: Numbers, file: str) -> float:
    """Return the mean of readings during one sweep; ValueError where they are those of several."""
    real = np.asarray(values.real, dtype=float)
    if not np.isfinite(real).all() or (key == "temperature" and np.ptp(real) > MOST_WITHIN):
        raise ValueError(
            f"{file}: {key} {name!r} goes from {np.min(real):g} to {np.max(real):g}; one value for each sweep is "
            'wanted: with a "*" in a name of sensors, sensors = { "H[*]" = "S1" }, it is taken sweep by sweep'
        )
    return float(real.mean())


MOST_WITHIN = 5.0
"""K between readings during one sweep; more are those of several."""


def _in_names(path: Path, name: str, pattern: str | None) -> dict[str, float]:
    words = _words_in_names(path, name, pattern)
    return {key: float(words[key].replace(",", ".")) for key in ("temperature", "level") if key in words}


def _words_in_names(path: Path, name: str, pattern: str | None) -> dict[str, str]:
    """Return what the pattern finds in the name of the FRF, else in that of the file."""
    compiled = re.compile(USUAL if pattern is None else as_regular(pattern))
    stem = path.name.removesuffix("".join(path.suffixes[-1:]))
    if path.suffix.lower() == ".gz":
        stem = stem.rpartition(".")[0] or stem
    for text in (name, stem, path.parent.name):
        found = compiled.search(text)
        if found:
            return {key: word for key, word in found.groupdict().items() if word}
    return {}


def as_regular(pattern: str) -> str:
    """Turn a pattern with words in braces and ``*`` into a regular expression.

    Raises ValueError for other words in braces, and one that stands twice.
    """
    made = re.escape(pattern).replace(r"\*", ".*")
    named = re.findall(r"\\\{(.*?)\\\}", made)
    for word in named:
        if word not in PARTS or named.count(word) > 1:
            raise ValueError(f"pattern = {pattern!r}: {{{word}}}; allowed, once each: {', '.join(PARTS)}")
        made = made.replace(rf"\{{{word}\}}", f"(?P<{word}>{PARTS[word]})")
    return made


ENDINGS, OWN_NAME = (".h5", ".hdf5"), "frf.h5"


def is_own(path: Path) -> bool:
    """Whether a file is to be read as one that Flexura wrote: by its seal, or by its name, where that is missing.

    An HDF5 file of anybody else begins with HDF5's own signature; so do results of versions that wrote no seal,
    which are refused with what to do.
    """
    if path.suffix.lower() not in ENDINGS or not path.is_file():
        return False
    with path.open("rb") as file:
        return path.name == OWN_NAME or file.read(len(HDF5)) != HDF5


@dataclass(frozen=True)
class PlacedFrf:
    """One FRF of a plate: its ends, its circumstances and its noise, in SI units.

    Attributes
    ----------
    name : str
        File and name, for messages.
    output, source : int
        Which of `Experiment.outputs` and `Experiment.inputs`.
    at : MeasuredAt
    frequency : (F,) ndarray, Hz
    h : (F,) complex ndarray
    noise : str
        As in `analysis.recordings.frf_campaign.FrfSweep`.
    variance, coherence : (F,) ndarray
    repeats_dof : int
    sweep : str
        What tells sweeps of equal circumstances apart; empty where nothing does.
    """

    name: str
    output: int
    source: int
    at: MeasuredAt
    frequency: Real
    h: Complex
    noise: Noise
    variance: Real
    coherence: Real
    repeats_dof: int = 0
    sweep: str = ""


def own_frfs(path: Path, experiment: Experiment) -> list[PlacedFrf]:
    """Read all FRFs of a run's ``frf.h5`` that a plate declares.

    Parameters
    ----------
    path : Path
    experiment : Experiment
        Of the plate; drives and sensors are found by their ids.

    Returns
    -------
    list of PlacedFrf

    Raises
    ------
    ResultFileError
        For a file that cannot be read.
    ValueError
        For a sensor or a drive that is not among those of the file.
    """
    declared, frf = load_frf(path)
    ids, drives = [one.id for one in experiment.outputs], [one.id for one in experiment.inputs]
    named = [one.id for one in declared.inputs]
    for kind, wanted, there in (("sensor", ids, frf.channels), ("drive", [*drives], named)):
        strangers = [one for one in wanted if one not in there]
        if strangers:
            raise ValueError(
                f"{path.name}: no {kind} {strangers[0]!r}; it holds: {', '.join(there)}. Declare those of them "
                "that are wanted, by their ids"
            )
    return [
        _placed(path, frf, sweep, frf.channels.index(sensor), ids.index(sensor), drives.index(driven))
        for sweep in range(len(frf.temperature))
        for driven in (named[frf.driven_by[sweep]],)
        if driven in drives
        for sensor in ids
    ]


def _placed(path: Path, frf: Frf, sweep: int, row: int, output: int, source: int) -> PlacedFrf:
    direction: Direction = "down" if frf.direction[sweep] == "down" else "up"
    return PlacedFrf(
        name=f"{path.name}: {frf.label(row, sweep)} of sweep {sweep}",
        output=output,
        source=source,
        at=MeasuredAt(float(frf.temperature[sweep]), direction, float(frf.level[sweep])),
        frequency=frf.frequency,
        h=frf.h[sweep, row],
        noise="variance",
        variance=frf.variance[sweep, row],
        coherence=np.asarray(frf.coherence[sweep, row]),
        repeats_dof=0 if frf.repeats_dof is None else int(frf.repeats_dof[sweep]),
        sweep=f"{path.name} {sweep}",
    )
