"""``plate.toml`` and the files that it names, to a campaign of FRFs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.estimation.estimators import coherence_variance
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import LEAST_LINES, Experiment, OvenDeclaration, Protocol
from analysis.recordings.frf_campaign import FrfCampaign, FrfSweep, Noise
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError, Problem
from app.files.declarations.plate import (
    NAME,
    NOT_STATED,
    FrfsOfPlate,
    PlateMeasurement,
    plate_file,
    read_plate_measurement,
)
from app.files.provenance import sha256
from app.files.settings_toml import checked
from app.modal_test.frf_set import require_convention
from app.plate_frfs.channel_map import PointsByNode, output_of, points_by_node, scale_of, source_of
from app.plate_frfs.source_files import (
    FrfsOfFile,
    PlacedFrf,
    circumstances,
    frfs_of_file,
    is_own,
    own_frfs,
    stated_coherence,
)

ROOM_TEMPERATURE = 20.0
"""Of the oven's room where it is not declared, degrees Celsius: it matters only for effects of a gradient between
plate and room."""
PROVISIONAL_TEMPERATURE = 20.0
"""A temperature with which a declaration is checked before those of the files are known."""

Read = list[tuple[Path, FrfsOfPlate, FrfsOfFile | None]]
"""Files with what is declared of them and what they hold; None of an ``frf.h5``, read once the plate is known."""


LARGEST_UNEVENNESS = 1e-3
"""Part of the spacing by which a line may lie off an even grid: files keep six digits of a frequency."""


@dataclass(frozen=True)
class CommonLines:
    """Evenly spaced lines.

    Attributes
    ----------
    first : float
        Hz.
    spacing : float
        Hz.
    count : int
    """

    first: float
    spacing: float
    count: int

    @property
    def frequency(self) -> Real:
        """(F,) ndarray, Hz."""
        return np.asarray(self.first + self.spacing * np.arange(self.count))

    def inside(self, frequency: Real) -> slice:
        """Return where the lines are among those of an FRF that `common_lines` has seen."""
        start = int(np.argmin(np.abs(frequency - self.first)))
        return slice(start, start + self.count)


def common_lines(named: Sequence[tuple[str, Real]], band: tuple[float, float] | None) -> CommonLines:
    """Find the lines that all FRFs have, inside a band.

    Parameters
    ----------
    named : sequence of (str, (F,) ndarray)
        File and FRF for messages, and its lines, Hz; one at least.
    band : (float, float) or None
        Hz; None for all.

    Returns
    -------
    CommonLines

    Raises
    ------
    ValueError
        For lines that are not even, of different spacing, that lie between each other, or too few in common.
    """
    name, lines = named[0]
    spacing = float(lines[-1] - lines[0]) / (len(lines) - 1)
    low, high = (0.0, np.inf) if band is None else band
    for one, frequency in named:
        own = float(frequency[-1] - frequency[0]) / (len(frequency) - 1)
        off = np.abs(frequency - frequency[0] - own * np.arange(len(frequency))).max()
        # frequencies written with few digits are off by rounding, which grows with the frequency
        if off > max(LARGEST_UNEVENNESS * own, 1e-5 * float(frequency[-1])):
            raise ValueError(f"{one}: its lines are not evenly spaced; export it with lines of one spacing")
        apart = (float(frequency[0]) - float(lines[0])) / spacing
        if abs(own / spacing - 1.0) * len(frequency) > 0.1 or abs(apart - round(apart)) > 0.1:
            raise ValueError(
                f"{one}: lines every {own:.6g} Hz from {frequency[0]:.6g} Hz, {name} every {spacing:.6g} Hz from "
                f"{lines[0]:.6g} Hz; all FRFs of a plate share their lines: export them alike, or make a "
                "plate.toml of each"
            )
        low, high = max(low, float(frequency[0])), min(high, float(frequency[-1]))
    tolerance = 0.01 * spacing  # a band of round numbers, and lines with the rounding of a file
    begin = int(np.ceil((low - float(lines[0]) - tolerance) / spacing))
    end = int(np.floor((high - float(lines[0]) + tolerance) / spacing))
    if end - begin + 1 < LEAST_LINES:
        within = "" if band is None else f" inside measurement.band {[*band]} Hz"
        raise ValueError(
            f"{max(end - begin + 1, 0)} lines that all FRFs have{within}; {LEAST_LINES} wanted: {name} from "
            f" {lines[0]:g} to {lines[-1]:g} Hz"
        )
    return CommonLines(float(lines[0]) + begin * spacing, spacing, end - begin + 1)


def read_plate(path: Path) -> FrfCampaign:
    """Read a declared plate and all its FRFs.

    Parameters
    ----------
    path : Path
        The declaration, or the folder in which it is ``plate.toml``.

    Returns
    -------
    FrfCampaign

    Raises
    ------
    CampaignFileError
        With all that is wrong with the declaration, and for FRFs that do not fit it.
    ResultFileError
        For files that cannot be read.
    """
    file = plate_file(path)
    said, rest = read_plate_measurement(file)
    if not said.frf:
        seen = (
            "has modes, no FRFs: flexura update takes it"
            if said.modes
            else 'names no FRFs; add [[frf]] file = "...", or for natural frequencies alone [[modes]]'
        )
        raise CampaignFileError(file.parent, [Problem(file.name, "frf", seen, "")])
    if said.modes:
        raise CampaignFileError(
            file.parent, [Problem(file.name, "frf, modes", "both are given; keep one of them", "")]
        )
    read = _read_files(file.parent, said)
    try:
        experiment = declared_experiment(file, said, rest, _band(said, rest, read))
        nodes = points_by_node(rest)[1]
        placed, notes = _placed(read, experiment, nodes)
        placed, copies = _without_copies(placed, [output.id for output in experiment.outputs])
        notes += copies
        band = experiment.protocol.band if "protocol" in rest else said.measurement.band
        lines = common_lines([(one.name, one.frequency) for one in placed], band)
        sweeps = _sweeps(placed, experiment, lines)
    except (CampaignFileError, ResultFileError):
        raise
    except ValueError as error:
        raise CampaignFileError(file.parent, [Problem(file.name, "", str(error), "")]) from error
    hashes = {file.name: sha256(file)}
    for source, _, found in read:
        hashes |= _hashes(file.parent, source, found)
    measured = tuple(dict.fromkeys(round(one.temperature, 2) for one in sweeps))
    notes += _without_noise(sweeps, experiment)
    if "oven" not in rest and len(measured) > 1:
        notes.append(f"oven.room_temperature is not declared: {ROOM_TEMPERATURE:g} °C is taken")
    return FrfCampaign(
        name=file.parent.resolve().name if file.name == NAME else file.stem,
        experiment=_with_measured(experiment, said, rest, sweeps, lines),
        frequency=lines.frequency,
        sweeps=tuple(sweeps),
        hashes=hashes,
        notes=tuple(dict.fromkeys(notes)),
        at_rest="protocol" in rest,
    )


def _read_files(folder: Path, said: PlateMeasurement) -> Read:
    read: Read = []
    for number, one in enumerate(said.frf):
        files = sorted(folder.glob(one.file)) if set(one.file) & set("*?[") else [folder / one.file]
        if not files:
            held = ", ".join(sorted(child.name for child in folder.iterdir())[:8])
            problem = Problem(
                NAME, f"frf[{number}].file", repr(one.file), "a pattern of files", f"there are {held}"
            )
            raise CampaignFileError(folder, [problem])
        for file in files:
            found = None if is_own(file) else frfs_of_file(file, one)
            read.append((file, one, found))
    return read


def _band(said: PlateMeasurement, rest: Mapping[str, Any], read: Read) -> tuple[float, float]:
    """Band with which a declaration is checked, Hz; ValueError where it is declared twice."""
    if "protocol" in rest:
        twice = [key for key in ("band", "ramp_rate") if key in said.measurement.model_fields_set]
        if twice:
            raise ValueError(f"measurement.{twice[0]} and [protocol] are given; keep the one in [protocol]")
    if said.measurement.band is not None:
        return said.measurement.band
    lines = [one.frequency for _, _, found in read if found is not None for one in found.transfers]
    if not lines:
        return 1.0, 1000.0  # of an frf.h5, whose own band takes its place
    return max(float(one[0]) for one in lines), min(float(one[-1]) for one in lines)


def declared_experiment(
    file: Path, said: PlateMeasurement, rest: Mapping[str, Any], band: tuple[float, float]
) -> Experiment:
    """Check what is declared of plate, drives and sensors, with what FRFs do not need filled in.

    Parameters
    ----------
    file : Path
    said : PlateMeasurement
    rest : mapping
        What the file declares besides.
    band : (float, float)
        Hz.

    Returns
    -------
    Experiment

    Raises
    ------
    CampaignFileError
        With every key that is wrong.
    """
    try:
        table = points_by_node(rest)[0]
    except ValueError as error:
        raise CampaignFileError(file.parent, [Problem(file.name, "", str(error), "")]) from error
    acquisition = dict(table.get("acquisition", {}))
    loads = any(
        patch.get("role") == "sensor" and patch.get("quantity", "voltage") == "voltage"
        for patch in table.get("patch", ())
        if isinstance(patch, Mapping)
    )
    if not loads:  # of no effect where no voltage of a patch is read
        acquisition = {"input_resistance": 1e6, "input_capacitance": 0.0} | acquisition
    table["acquisition"] = {"module": NOT_STATED, "sample_rate": max(2.56 * band[1], 100.0)} | acquisition
    table.setdefault("oven", {"room_temperature": ROOM_TEMPERATURE})
    if "protocol" not in table:
        table["acquisition"]["module"] = NOT_STATED  # whatever is written there, it recorded no sweeps
        low, high = band
        table["protocol"] = {
            "sweep": "logarithmic",
            "band": [low, high],
            "sweep_duration": min(max(100.0 / max(high - low, 1e-9), 1.0), 3600.0),
            "tail": 0.0,
            "repeats": 1,
            "ramp_rate": said.measurement.ramp_rate,
            "temperatures": [PROVISIONAL_TEMPERATURE],
            "directions": ["up"],
            "levels": [1.0],
        }
    return checked(file, table, Experiment)


def _placed(read: Read, experiment: Experiment, nodes: PointsByNode) -> tuple[list[PlacedFrf], list[str]]:
    """All FRFs with their ends and circumstances, and notes."""
    placed: list[PlacedFrf] = []
    notes: list[str] = []
    if nodes.roving:
        notes.append(
            f"the hammer moved: {len(nodes.names)} points with one gain; by reciprocity {', '.join(nodes.fixed)} "
            f"drives and the hammer's points answer"
        )
    for path, said, found in read:
        if found is None:
            placed += own_frfs(path, experiment)
            continue
        notes += found.notes
        require_convention(found.transfers)
        said = nodes.said_of(said, found)
        unused: list[str] = []
        for frf in found.transfers:
            one = _one(path, found, frf, said, experiment, notes, roving=nodes.roving)
            if one is None:
                unused.append(frf.name)
            else:
                placed.append(one)
        if len(unused) == len(found.transfers):
            keys = ", ".join(said.sensors)
            raise ValueError(f"{found.file}: none of frf.sensors ({keys}) is in it; it holds: {found.names}")
        if unused:
            more = f" and {len(unused) - 3} more" if len(unused) > 3 else ""
            notes.append(f"{found.file}: {', '.join(unused[:3])}{more} not declared, left out")
    return placed, notes


def _without_copies(placed: Sequence[PlacedFrf], outputs: Sequence[str]) -> tuple[list[PlacedFrf], list[str]]:
    """Leave out FRFs that are there twice, which would count as repeats; say where else the same numbers are."""
    kept: list[PlacedFrf] = []
    notes: list[str] = []
    known: dict[bytes, PlacedFrf] = {}
    for one in placed:
        before = known.setdefault(one.h.tobytes() + one.frequency.tobytes(), one)
        if before is one or one.source != before.source:  # by reciprocity they may be those of exchanged ends
            kept.append(one)
            continue
        file, other = (which.name.partition(": ")[0] for which in (one, before))
        if (one.output, one.at, one.sweep) == (before.output, before.at, before.sweep):
            notes.append(f"{file} is left out: a copy of {other}, number for number, makes the noise look smaller")
            continue
        kept.append(one)
        notes.append(
            f"{file} holds the same numbers for {outputs[one.output]} at {one.at.temperature:g} °C as {other} for "
            f"{outputs[before.output]} at {before.at.temperature:g} °C: a copy under another name?"
        )
    return kept, notes


def _one(
    path: Path,
    found: FrfsOfFile,
    frf: MeasuredTransfer,
    said: FrfsOfPlate,
    experiment: Experiment,
    notes: list[str],
    *,
    roving: bool,
) -> PlacedFrf | None:
    ends = replace(frf, response=frf.reference, reference=frf.response) if roving else frf
    belongs = output_of(found, ends, said, experiment)
    if belongs is None:
        return None
    output, star = belongs
    at = circumstances(found, path, frf.name, star, said)
    source = source_of(found, ends, said, experiment, "" if roving else at.drive)
    if not np.abs(frf.h).any():
        raise ValueError(f"{found.file}: FRF {frf.name!r} is zero on every line, a dead channel; leave it out")
    scale, assumed = scale_of(found.file, frf, experiment.outputs[output], experiment.inputs[source])
    if assumed:
        notes.append(f"{found.file}: no units in it; {assumed} are taken, units in [[frf]] says others")
    h = np.asarray(frf.h * scale, dtype=complex)
    coherence, variance = stated_coherence(frf), None
    if found.estimated:
        variance = frf.variance
    elif coherence is not None:
        # of n averages the coherence has n - 1 degrees of freedom beside the FRF itself
        freedom = None if said.averages is None or said.averages <= 1.0 else said.averages - 1.0
        variance = coherence_variance(h, coherence, freedom)
    noise: Noise = "neighbouring lines" if variance is None else "coherence"
    return PlacedFrf(
        name=f"{found.file}: {frf.name}",
        output=output,
        source=source,
        at=at,
        frequency=frf.frequency,
        h=h,
        noise=noise,
        variance=np.zeros(h.shape) if variance is None else variance,
        coherence=np.ones(h.shape) if coherence is None else np.clip(coherence, 0.0, 1.0),
        repeats_dof=0 if variance is None or said.averages is None else round(2.0 * (said.averages - 1.0)),
        sweep=star,
    )


def _sweeps(placed: Sequence[PlacedFrf], experiment: Experiment, lines: CommonLines) -> list[FrfSweep]:
    """Sweeps in the order of their temperatures, upwards and then downwards, of one input after the other.

    FRFs of one sensor in equal circumstances are repeats, each a sweep of its own.
    """
    groups: dict[tuple[Any, ...], list[dict[int, PlacedFrf]]] = {}
    for one in placed:
        key = (one.source, one.at.direction, one.at.temperature, one.at.level, one.sweep)
        alike = groups.setdefault(key, [])
        lacking = next((sweep for sweep in alike if one.output not in sweep), None)
        if lacking is None:
            alike.append({one.output: one})
        else:
            lacking[one.output] = one
    names = [output.id for output in experiment.outputs]

    def order(key: tuple[Any, ...]) -> tuple[Any, ...]:
        source, direction, temperature, *rest = key
        return source, direction == "down", temperature if direction == "up" else -temperature, *rest

    made = []
    for key in sorted(groups, key=order):
        for sweep in groups[key]:
            missing = [name for number, name in enumerate(names) if number not in sweep]
            if missing:
                some = next(iter(sweep.values()))
                raise ValueError(
                    f"{some.name} at {some.at.temperature:g} °C ({some.at.direction}): no FRF of {missing[0]!r} "
                    f"at this temperature, direction and level; every sweep needs all of {_listed(names)}"
                )
            made.append(_sweep([sweep[number] for number in range(len(names))], lines))
    return made


def _sweep(rows: Sequence[PlacedFrf], lines: CommonLines) -> FrfSweep:
    at = rows[0].at
    cuts = [lines.inside(row.frequency) for row in rows]
    return FrfSweep(
        temperature=at.temperature,
        h=np.array([row.h[cut] for row, cut in zip(rows, cuts, strict=True)]),
        noise=tuple(row.noise for row in rows),
        variance=np.array([row.variance[cut] for row, cut in zip(rows, cuts, strict=True)]),
        coherence=np.array([row.coherence[cut] for row, cut in zip(rows, cuts, strict=True)]),
        direction=at.direction,
        level=at.level,
        source=rows[0].source,
        repeats_dof=min(row.repeats_dof for row in rows),
    )


def _with_measured(
    experiment: Experiment,
    said: PlateMeasurement,
    rest: Mapping[str, Any],
    sweeps: Sequence[FrfSweep],
    lines: CommonLines,
) -> Experiment:
    """Complete the protocol by what the files say."""
    temperatures = tuple(sorted({round(one.temperature, 2) for one in sweeps}))
    changed: dict[str, Any] = {}
    if "oven" not in rest and len(temperatures) == 1:
        changed["oven"] = OvenDeclaration(room_temperature=temperatures[0])
    if "protocol" not in rest:
        frequency = lines.frequency
        changed["protocol"] = Protocol(
            sweep="logarithmic",
            band=(float(frequency[0]), float(frequency[-1])),
            sweep_duration=1.0 / lines.spacing,
            tail=0.0,
            repeats=1,
            ramp_rate=said.measurement.ramp_rate,
            temperatures=temperatures,
            directions=tuple(way for way in ("up", "down") if any(one.direction == way for one in sweeps)),
            levels=tuple(sorted({one.level for one in sweeps})),
        )
        changed["acquisition"] = experiment.acquisition.model_copy(
            update={"sample_rate": max(experiment.acquisition.sample_rate, 2.56 * float(frequency[-1]))}
        )
    return experiment.model_copy(update=changed)


def _without_noise(sweeps: Sequence[FrfSweep], experiment: Experiment) -> list[str]:
    names = [output.id for output in experiment.outputs]
    silent = {name for one in sweeps for name, noise in zip(names, one.noise, strict=True) if noise not in KNOWN}
    if not silent:
        return []
    return [
        f"{_listed([name for name in names if name in silent])}: the files give no noise (no coherence, or that "
        "of one average); it is estimated from the scatter of neighbouring lines"
    ]


def _listed(names: Sequence[str]) -> str:
    """Names for a message; of a scan's hundreds the first and the last."""
    return ", ".join(names) if len(names) <= 12 else f"{', '.join(names[:3])} to {names[-1]} ({len(names)})"


KNOWN = ("variance", "coherence")
"""Noise that the files give."""


def _hashes(folder: Path, source: Path, found: FrfsOfFile | None) -> dict[str, str]:
    """SHA-256 of a file, and of those that it names, by their places relative to the declaration."""
    beside = source.parent.relative_to(folder) if source.is_relative_to(folder) else source.parent
    listed = {source.name: sha256(source)} if found is None else dict(found.hashes)
    return {(beside / name).as_posix(): digest for name, digest in listed.items()}
