"""Files and channels of a test's declaration, or of a universal file, to FRFs of one structure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np

from analysis.channel import UNITS
from analysis.estimation.agreement import LEAST_AGREEMENT, agreement, of_hits, of_records
from analysis.estimation.estimators import Estimator, FrfEstimate, Segments, estimate
from analysis.estimation.impacts import Blows, find_blows
from analysis.estimation.quantities import frf_name
from analysis.estimation.ringing import Ringing, ringing
from analysis.estimation.spectra import Spectra, leaks, of_blocks, pooled, welch
from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.judgement.confirmation import FEWEST_HITS, WithoutHit
from analysis.plate_temperature.label_check import said_of_doubts
from analysis.progress import Progress
from app.files.acquisition.hammer_folder import hit_doubts, said_of_missing_hits
from app.files.bad_file import ResultFileError
from app.files.declarations.modal_test import NAME, ModalTest, RecordOfTest, declares_test, dof, read_modal_test
from app.files.measurements.columns import Columns
from app.files.measurements.guarded import read_each
from app.files.provenance import sha256
from app.files.uff.frfs import read_frfs
from app.files.uff.geometry import read_nodes
from app.modal_test.frf_set import (
    FrfSet,
    Position,
    require_convention,
    require_one_of_each,
    said_of_coherence,
    said_of_reference,
    with_said_of_ends,
)
from app.modal_test.signals import SignalsOfFile, given_frfs, signals

Runs = dict[tuple[tuple[str, str], ...], list[tuple[str, SignalsOfFile]]]
"""Names and signals of the files, by the places of their channels."""
PLACES = "say where each was measured, by `at` of its channels or of its record (flexura new test: --roving)"
"""What to do with several FRFs between the same ends."""


def declared_frfs(path: Path, report: Progress) -> FrfSet:
    """Read a test and estimate its FRFs.

    Parameters
    ----------
    path : Path
        Declaration, or the folder in which it is ``test.toml``.
    report : callable
        Called with the stage's name and the share done.

    Returns
    -------
    FrfSet
        In SI units.

    Raises
    ------
    CampaignFileError
        For what is wrong with the declaration.
    ResultFileError
        For what is wrong with its files, or with what they hold.
    """
    file = path / NAME if path.is_dir() else path
    test = read_modal_test(file)
    hashes = {file.name: sha256(file)}
    hits = [record.file for record in test.record]
    notes = said_of_missing_hits(file.parent, hits) + said_of_doubts(hit_doubts(file.parent, hits), "hits")
    transfers, runs = _read_files(file.parent, test, hashes, notes, report)
    rates, cut = {0.0}, False
    singles: list[list[Spectra]] = []
    ring: list[_CutOff] = []
    test = _with_one_block([run for files in runs.values() for run in files], test, file.parent)
    for places, files in runs.items():
        try:
            found, rate, said, leaking, cut_off = _estimated(files, test)
        except ValueError as error:
            raise ResultFileError(f"{file.parent / files[0][0]}: {error}") from error
        if test.kind == "hammer":
            singles.append(_single_hits(files, test))
        rates, cut = {rate}, cut or leaking
        notes += said
        ring += cut_off
        transfers += _transfers(found, files[0][1], dict(places))
    notes += _said_of_ringing(ring)
    report("read", 1.0)
    points: dict[int, Position] = {int(node): place for node, place in test.points.items()}
    try:
        require_one_of_each(transfers, PLACES)
        if test.kind == "frf":
            require_convention(transfers)
        frfs = FrfSet(
            title=test.title or file.parent.resolve().name,
            transfers=tuple(transfers),
            points=points,
            window_rate=rates.pop(),
            segments=_segments(test) if cut else None,
            temperature=float("nan") if test.temperature is None else test.temperature,
            mains=test.mains,
            notes=(
                *notes,
                *said_of_reference(transfers),
                *(said_of_coherence(transfers) if test.kind == "frf" else ()),
            ),
            hashes=hashes,
            operator=test.operator,
            date="" if test.date is None else test.date.isoformat(),
            without_hits=_without_hits(singles, test.estimator),
        )
        return with_said_of_ends(frfs)
    except ValueError as error:
        raise ResultFileError(f"{file}: {error}") from error


def _segments(test: ModalTest) -> Segments:
    return Segments(test.segments.seconds, test.segments.window, test.estimator)


def _read_files(
    folder: Path, test: ModalTest, hashes: dict[str, str], notes: list[str], report: Progress
) -> tuple[list[MeasuredTransfer], Runs]:
    """Read all files of a test: FRFs that they hold, or their signals; add their SHA-256 and notes on them."""
    transfers: list[MeasuredTransfer] = []
    runs: Runs = {}
    whole: dict[str, Columns] = {}
    names = [file for file, _ in groupby(record.file for record in test.record)]
    each = read_each([folder / name for name in names])
    for done, record in enumerate(test.record):
        report("read", done / len(test.record))
        if record.file not in whole:
            whole = {record.file: next(each)}  # of one file at a time; its groups follow each other
            hashes[record.file] = sha256(folder / record.file)
            notes += whole[record.file].notes
        told = _of_copy(record, test, hashes)
        if told is not None:
            notes.append(told[0])
            if told[1]:
                continue
        try:
            columns = whole[record.file].of_group(record.group) if record.group else whole[record.file]
            if test.kind == "frf":
                transfers += given_frfs(record, columns, test)
            else:
                held = signals(record.name, columns, test)
                runs.setdefault(tuple(sorted(_places(record, test).items())), []).append((record.name, held))
        except ValueError as error:
            raise ResultFileError(f"{folder}: {error}") from error
    return transfers, runs


def _of_copy(record: RecordOfTest, test: ModalTest, hashes: Mapping[str, str]) -> tuple[str, bool] | None:
    """Say of which file before it a file is a copy, and whether it is at the same places."""
    alike = [file for file, sha in hashes.items() if sha == hashes[record.file] and file != record.file]
    if not alike:
        return None
    own = _places(record, test)
    before = [other for other in test.record if other.file in alike and other.group == record.group]
    if any(_places(other, test) == own for other in before):
        return (
            f"{record.name} is left out: a copy of {alike[0]}, byte for byte, makes the noise look smaller",
            True,
        )
    return (
        f"{record.name} is a copy of {alike[0]}, byte for byte, and stands for other points: of which points are "
        "they? Remove the [[record]] of one, or measure it again",
        False,
    )


def _with_one_block(runs: list[tuple[str, SignalsOfFile]], test: ModalTest, folder: Path) -> ModalTest:
    """Give a hammer test without a duration the longest block that all its files have room for."""
    if test.kind != "hammer" or test.hammer.duration is not None:
        return test
    seconds = []
    for name, held in runs:
        try:
            blows = find_blows(held.recording, test.hammer.test())
        except ValueError as error:
            raise ResultFileError(f"{folder / name}: {error}") from error
        seconds.append(blows.samples / held.recording.rate)
    hammer = test.hammer.model_copy(update={"duration": min(seconds)})
    return test.model_copy(update={"hammer": hammer})


def _places(record: RecordOfTest, test: ModalTest) -> dict[str, str]:
    """Places of all channels in one file: as moved for it, as declared, or numbered in the order declared."""
    measured = [name for name, channel in test.channels.items() if channel.role in ("drive", "response", "frf")]
    return {
        name: dof(record.at.get(name) or test.channels[name].at or str(number))
        for number, name in enumerate(measured, start=1)
    }


@dataclass(frozen=True)
class _CutOff:
    """A response that is cut off while it rings, `tail` seconds after the blow; the worst of those at a place."""

    files: str
    channel: str
    found: Ringing
    tail: float


def _estimated(
    files: list[tuple[str, SignalsOfFile]], test: ModalTest
) -> tuple[FrfEstimate, float, list[str], bool, list[_CutOff]]:
    """Estimate the FRFs of runs with all channels at the same places.

    Also the window's rate, notes, whether segments leak, and what is cut off while it rings.
    """
    notes = [note for _, held in files for note in held.notes]
    every: list[Blows] = []
    rate, leaking = 0.0, False
    if test.kind == "continuous":
        settings = test.segments.seconds, test.segments.window, test.segments.overlap
        parts = [welch(held.recording, *settings) for _, held in files]
        leaking = any(leaks(held.recording, *settings) for _, held in files)
    else:
        files, every, said = _counted(files, test)
        parts, rate = [blows.spectra() for blows in every], every[0].window.rate
        notes += said
    ring = _ringing([name for name, _ in files], files[0][1], every) if every and not rate else []
    if len({len(part.frequency) for part in parts}) > 1:
        raise ValueError("its sample rate is not that of the other files; resample them to one")
    found = estimate(pooled(parts), test.estimator)
    notes += _require_one_frf(files, parts)
    notes += _level_notes(files, parts, every)
    if leaking and found.averages < 10:
        notes.append(
            f"{files[0][0]}: {found.averages:.0f} independent averages only; record longer, or lessen "
            "segments.seconds"
        )
    return found, rate, notes, leaking, ring


def _counted(
    files: list[tuple[str, SignalsOfFile]], test: ModalTest
) -> tuple[list[tuple[str, SignalsOfFile]], list[Blows], list[str]]:
    """Files with a blow that counts, of those at one place, their blows, and a note on each blow left out.

    Where no file has one, the first stays, whose spectra say why.
    """
    each = [
        find_blows(held.recording, test.hammer.test(), held.full_scales, [*held.drives, *held.responses])
        for _, held in files
    ]
    notes = [
        f"{name}: blow {number} of {len(blows.hits)} left out, {hit.rejected}"
        for (name, _), blows in zip(files, each, strict=True)
        for number, hit in enumerate(blows.hits, start=1)
        if hit.rejected
    ]
    used = [number for number, blows in enumerate(each) if blows.kept] or [0]
    return [files[number] for number in used], [each[number] for number in used], notes


def _single_hits(files: list[tuple[str, SignalsOfFile]], test: ModalTest) -> list[Spectra]:
    """Spectra of every blow that counts, in the order of the files."""
    found = []
    for _, held in files:
        blows = find_blows(held.recording, test.hammer.test(), held.full_scales, [*held.drives, *held.responses])
        for drive, answer in zip(*blows.blocks(), strict=True):
            found.append(of_blocks(drive[None], answer[None], held.recording.rate))
    return found


def _without_hits(singles: list[list[Spectra]], estimator: Estimator) -> tuple[WithoutHit, ...]:
    """FRFs of all places without the first, the second, ... hit at each; none where they are too few at one."""
    count = min((len(hits) for hits in singles), default=0)
    if count < FEWEST_HITS:
        return ()
    found = []
    for left_out in range(count):
        rows, left, whole = [], 0.0, 0.0
        for hits in singles:
            kept = [one for number, one in enumerate(hits) if number != left_out]
            h = estimate(pooled(kept), estimator).h
            rows.append(h.reshape(-1, h.shape[-1]))
            power = [float(np.trace(one.g_uu, axis1=1, axis2=2).real.sum()) for one in hits]
            left, whole = left + sum(power) - power[left_out], whole + sum(power)
        found.append(WithoutHit(f"hit {left_out + 1}", np.concatenate(rows), left / whole))
    return tuple(found)


def _require_one_frf(files: list[tuple[str, SignalsOfFile]], parts: list[Spectra]) -> list[str]:
    """Refuse to average files that measured different FRFs; say where they agree badly."""
    found = agreement(parts)
    if found is None:
        return []
    first, names = files[0][1], [name for name, _ in files]
    shown = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
    if found.different.size:
        worst = found.different[np.argmin(found.between[found.different])]
        raise ValueError(
            f"{shown} are declared at the same places, but do not agree: {first.responses[worst]} by "
            f"{max(found.between[worst], 0.0):.2f} (1: the same FRF, 0: unrelated; allowed: {LEAST_AGREEMENT:g} "
            f"or more). Are they of several points? Then {PLACES}. Or did the structure change between them? Then "
            "make a test of each"
        )
    return [
        f"{shown}: {first.responses[worst]} agrees between files by {found.between[worst]:.2f} only (1: the same "
        "FRF); look for a point that was missed, a sensor that came loose, a structure that changed, or noise"
        for worst in found.doubtful
    ]


def _level_notes(files: list[tuple[str, SignalsOfFile]], parts: list[Spectra], every: list[Blows]) -> list[str]:
    """Say where weak and strong drives of one average give different FRFs."""
    first = files[0][1]
    if every:
        blocks = [blows.blocks() for blows in every]
        peaks = np.array([hit.peak for blows in every for hit in blows.kept])
        drives, responses = (np.concatenate([block[end] for block in blocks]) for end in (0, 1))
        differs = of_hits(drives, responses, peaks)
    else:
        rms = np.array([held.recording.drives.std() for _, held in files])
        differs = of_records(parts, rms)
    if differs is None:
        return []
    return [f"{files[0][0]}: {differs.message(UNITS[first.quantities[first.drives[0]]])}"]


def _ringing(names: list[str], held: SignalsOfFile, every: list[Blows]) -> list[_CutOff]:
    """Find the response that is cut off most while it rings, of the files at one place.

    Of all blows together: what they have in common rings, and what they have not is noise, of which a file with a
    single blow tells nothing.
    """
    shortest = min(blows.samples for blows in every)
    each = [blows.blocks(windowed=False)[1][:, :, :shortest] for blows in every]
    answers = np.concatenate(each) / np.array([hit.peak for blows in every for hit in blows.kept])[:, None, None]
    tail = (shortest - max(blows.before for blows in every)) / held.recording.rate
    name = names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
    seen = [
        _CutOff(name, channel, found, tail)
        for number, channel in enumerate(held.responses)
        if (found := ringing(answers[:, number], held.recording.rate, 0.9 * tail)) is not None
    ]
    return [max(seen, key=lambda one: one.found.share)] if seen else []


def _said_of_ringing(places: list[_CutOff]) -> list[str]:
    """Say where most is cut off, and at how many places."""
    if not places:
        return []
    worst = max(places, key=lambda one: one.found.share)
    remedy = "lengthen hammer.duration and the time between blows, or set hammer.exponential = 0.01"
    also = f" (the most; {len(places)} places do)" if len(places) > 1 else ""
    return [f"{worst.files}{also}: {worst.channel} {worst.found.message(worst.tail, remedy)}"]


def _transfers(found: FrfEstimate, held: SignalsOfFile, places: Mapping[str, str]) -> list[MeasuredTransfer]:
    made = []
    for k, response in enumerate(held.responses):
        for m, drive in enumerate(held.drives):
            quantities = held.quantities[response], held.quantities[drive]
            made.append(
                MeasuredTransfer(
                    name=f"{frf_name(*quantities)} {response} {places[response]} / {drive} {places[drive]}",
                    response=places[response],
                    reference=places[drive],
                    quantity=quantities[0],
                    frequency=found.frequency,
                    h=found.h[k, m],
                    reference_quantity=quantities[1],
                    units=(UNITS[quantities[0]], UNITS[quantities[1]]),
                    variance=None if found.variance is None else found.variance[k, m],
                    coherence=None if found.averages <= len(held.drives) else found.coherence[k],
                )
            )
    return made


SHARED = (
    "are these several temperatures, levels or repeats? Poles are shared by one FRF of each pair: export one "
    "sweep (flexura identify CAMPAIGN --export FRFS.uff --temperature 20), or leave out --shared-poles, and each "
    "FRF is identified by itself"
)
"""What to do with several FRFs between the same ends."""
LARGEST_STRUCTURE = 30.0
"""m. Programs that write mm without their unit make 240 m of a plate."""


def frfs_of_file(path: Path, report: Progress) -> FrfSet:
    """Return the FRFs of a test as declared, or of a universal file as one structure.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError, CampaignFileError
        For files that cannot be used.
    """
    return declared_frfs(path, report) if declares_test(path) else of_universal(path, read_frfs(path))


def of_universal(path: Path, transfers: list[MeasuredTransfer]) -> FrfSet:
    """Return the FRFs of a universal file as those of one structure, with the nodes that the file holds.

    Parameters
    ----------
    transfers : list of MeasuredTransfer
        Read from it; those that are zero throughout are left out, with a note.

    Raises
    ------
    ResultFileError
        Where there are none, their lines differ, or two have the same ends, as those of two temperatures.
    """
    try:
        alive, dead = _alive(transfers)
        nodes, hashes = read_nodes(path), {path.name: sha256(path)}
        notes = (*dead, *said_of_reference(alive), *said_of_coherence(alive), *_said_of_extent(nodes))
        frfs = FrfSet(path.stem, tuple(alive), nodes, notes=notes, hashes=hashes)
        require_one_of_each(frfs.transfers, SHARED)
        require_convention(frfs.transfers)
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error
    return with_said_of_ends(frfs)


def _said_of_extent(nodes: Mapping[int, Position]) -> list[str]:
    """Say so where nodes are so far apart that their unit is probably another than was read."""
    if not nodes:
        return []
    extent = float(np.ptp(np.array(list(nodes.values())), axis=0).max())
    if extent <= LARGEST_STRUCTURE:
        return []
    return [
        f"its nodes are up to {extent:.4g} m apart; if they are in mm, export the file with data set 164, which "
        "names the unit: without one, coordinates are in m"
    ]


def _alive(transfers: Sequence[MeasuredTransfer]) -> tuple[list[MeasuredTransfer], list[str]]:
    """FRFs that are not zero throughout, and a note for each other one; all of them where none is left."""
    alive = [one for one in transfers if np.abs(one.h).any()]
    if not alive:
        return list(transfers), []
    return alive, [
        f"{one.name} ({one.response} / {one.reference}): zero on every line, a dead channel; left out"
        for one in transfers
        if not np.abs(one.h).any()
    ]
