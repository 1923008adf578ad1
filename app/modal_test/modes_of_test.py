"""Modes and shapes of a test: computed, saved in a run folder (modes, FRFs, stabilization), loaded again.

Modes of a test as JSON for machines and as tables for people.
"""

import csv
import io
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from analysis.estimation.estimators import Segments
from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.judgement.confirmation import confirmed_by_hits
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.labelled import Labelled, LabelledArrays
from analysis.progress import Progress
from analysis.shapes.participation import ModeShapes, mac, mode_shapes, mpc, residue_deviation
from analysis.shapes.stabilization import StabilizationChart, stabilization_chart
from app.files.atomic import atomic_hdf5, write_text
from app.files.bad_file import ResultFileError
from app.files.hdf5_file import read_value, result_file, write_value
from app.files.parsed_text import parse_json
from app.files.provenance import provenance, stamp
from app.files.results.modes_file import load_modes, load_shapes, save_modes
from app.files.uff.frfs import write_frfs
from app.files.uff.geometry import write_modes
from app.modal_test.edit_journal import forget_edits
from app.modal_test.frf_set import FrfSet
from app.modal_test.without_windows import rebuilt, without_windows
from app.summaries.modes import mode_table, modes_record, reading_cells
from app.summaries.table import Table, as_html, as_text

if TYPE_CHECKING:
    from app.stages.identify_options import Wanted


@dataclass(frozen=True)
class TestModes(Labelled):
    """What was found in a test.

    Attributes
    ----------
    frfs : FrfSet
        As measured, inside the band.
    modes : Modes
        Damping by windows taken out.
    shapes : ModeShapes
        Of those poles that are modes of the structure.
    chart : StabilizationChart
    """

    __test__ = False  # no class of tests, whatever its name

    frfs: FrfSet
    modes: Modes
    shapes: ModeShapes
    chart: StabilizationChart

    def __repr__(self) -> str:
        """FRFs, modes and misfit in one line, and the notes."""
        return as_text(f"TestModes: {self._headline}", self.frfs.notes)

    def _repr_html_(self) -> str:
        return as_html(
            self._headline, [mode_table(self.frfs.title, modes_record(self.modes)["modes"])], self.frfs.notes
        )

    @property
    def _headline(self) -> str:
        sure = self.modes.confirmation.count("confirmed")
        return (
            f"{len(self.frfs.transfers)} FRFs, {int(self.modes.real.sum())} modes ({sure} confirmed) at "
            f"{len(self.shapes.places)} places, misfit {100 * self.modes.misfit:.2f} %"
        )

    def labelled(self) -> LabelledArrays:
        """Frequency, damping and status over mode, shapes over place and mode."""
        read, real = self.modes.reading(), self.shapes.pole
        fields = ("frequency_hz", "sigma_frequency_hz", "damping_ratio", "sigma_damping_ratio", "loss_factor")
        of_modes = {name.removesuffix("_hz"): (("mode",), getattr(read, name)[real]) for name in fields}
        status = np.array([self.modes.standing(j) for j in real.tolist()])
        return LabelledArrays(
            {**of_modes, "status": (("mode",), status), "shape": (("place", "mode"), self.shapes.shape.T)},
            {
                "mode": (("mode",), np.arange(1, len(real) + 1)),
                "place": (("place",), np.array(self.shapes.places)),
            },
            {"frequency": "Hz", "sigma_frequency": "Hz"},
            tuple(self.frfs.notes),
        )

    def rebuilt(self) -> NDArray[np.complex128]:
        """FRFs of the model as they were fitted, (L, F): with the window that was over the measured ones."""
        return rebuilt(self.modes, self.frfs.frequency, self.frfs)


UNEXPLAINED_MISFIT = 0.2
"""Misfit from which something other than noise is wrong."""

CLEAR, SMOOTHED = 0.2, 25
"""Share of noise below which FRFs stand out of it, and the lines over which both are averaged: single lines
scatter, and antiresonances are noise."""


def identify_test(frfs: FrfSet, wanted: "Wanted", report: Progress) -> TestModes:
    """Identify the FRFs of a structure with one set of poles.

    Parameters
    ----------
    report : callable
        Called with the stage's name and the share done.

    Raises
    ------
    ResultFileError
        Where nothing can be found.
    """
    report("identify", 0.0)
    try:
        modes = wanted.identify(frfs.transfers)
    except ValueError as error:
        raise ResultFileError(f"{frfs.title}: {error}") from error
    modes = confirmed_by_hits(Measured(frfs.frequency, frfs.h, frfs.variance), frfs.without_hits, modes)
    report("identify", 0.9)
    orders = np.unique(np.linspace(2, 2 * max(len(modes.poles), 3) + 2, 8).astype(int))
    chart = stabilization_chart(Measured(frfs.frequency, frfs.h), modes.terms, [int(n) for n in orders])
    report("identify", 1.0)
    frfs = replace(frfs, notes=(*frfs.notes, *_taken_for_hum(frfs, modes), *_unexplained(frfs, modes)))
    return shaped_test(*without_windows(frfs, modes), chart)


def _taken_for_hum(frfs: FrfSet, modes: Modes) -> list[str]:
    """Name peaks that are no modes because they are as narrow as a line, where mains hum is."""
    step = float(np.median(np.diff(frfs.frequency)))
    return [
        f"{abs(pole) / (2.0 * np.pi):.2f} Hz is left out, {why}: its peak is no wider than the {step:.3g} Hz "
        "between lines. If it is a mode, longer blocks or segments show its width; flexura view adds it by hand"
        for pole, status, why in zip(modes.poles, modes.status, modes.reason, strict=True)
        if status == "harmonic"
    ]


def _unexplained(frfs: FrfSet, modes: Modes) -> list[str]:
    """Say where modes describe FRFs badly, or where these are noise for a large part."""
    power, variance = (np.abs(frfs.h) ** 2).sum(axis=0), frfs.variance
    noise = 0.0 if variance is None else float(np.sqrt(variance.sum() / power.sum()))
    if modes.misfit >= max(UNEXPLAINED_MISFIT, 2.0 * noise):
        step = float(np.median(np.diff(frfs.frequency)))
        return [
            f"the modes leave {100 * modes.misfit:.0f} % of the FRFs unexplained: do not trust them before the "
            f"cause is found. Are peaks narrower than the {step:.3g} Hz between lines (take longer blocks or "
            "segments), are channels exchanged, or does --band cut through a peak?"
        ]
    if variance is None or noise < UNEXPLAINED_MISFIT:
        return []
    clear = uniform_filter1d(variance.sum(axis=0), SMOOTHED) < CLEAR**2 * uniform_filter1d(power, SMOOTHED)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], clear.astype(int), [0]]))).reshape(-1, 2)
    first, end = max(edges.tolist(), key=lambda one: one[1] - one[0], default=(0, 0))
    share = f"noise is {100 * noise:.0f} % of the FRFs, and most of the misfit"
    if end - first < SMOOTHED:
        return [f"{share}: drive harder, or average more"]
    low, high = np.ceil(frfs.frequency[first]), np.floor(frfs.frequency[end - 1])
    return [
        f"{share}; they stand out of it from {low:g} to {high:g} Hz, as far as the drive reaches: "
        f"--band {low:g} {high:g}"
    ]


def shaped_test(frfs: FrfSet, modes: Modes, chart: StabilizationChart) -> TestModes:
    """Take shapes out of the residues of modes.

    Parameters
    ----------
    modes : Modes
        Damping by windows taken out.
    """
    left = frfs.h - rebuilt(modes, frfs.frequency, frfs)
    noise = residue_deviation(frfs.frequency, left, modes.poles - frfs.window_rate)
    shapes = mode_shapes(frfs.transfers, modes.poles, modes.residues, modes.real, noise)
    return TestModes(frfs, modes, shapes, chart)


def save_test(run: Path, found: TestModes, wanted: "Wanted") -> None:
    """Write everything a run folder of a test holds; each file whole or not at all.

    Parameters
    ----------
    run : Path
        The folder.
    wanted : Wanted
        With which they were found.
    """
    forget_edits(run)
    write_run(run, found, {"test": found.frfs.title} | wanted.record())


def write_run(run: Path, found: TestModes, settings: Mapping[str, Any]) -> None:
    """Write everything that a run folder of a test holds.

    Parameters
    ----------
    run : Path
        The folder.
    settings : mapping
        For the provenance.
    """
    frfs, made_from = found.frfs, provenance(found.frfs.hashes, settings)
    save_frfs(run / "transfers.h5", frfs, made_from)
    save_modes(run / "modes.h5", _tracked(found), made_from, found.shapes)
    save_stabilization(run / "stabilization.h5", found.chart, made_from)
    write_modes_table(run / "modes.csv", found.modes, found.shapes, frfs.temperature)
    write_modes(run / "modes.uff", found.modes, found.shapes, frfs.points)
    write_frfs(run / "frfs.uff", frfs.transfers, frfs.points)
    write_frfs(run / "rebuilt.uff", _with_values(frfs.transfers, found.rebuilt()), frfs.points)


def _with_values(transfers: tuple[MeasuredTransfer, ...], h: NDArray[np.complex128]) -> list[MeasuredTransfer]:
    return [replace(one, h=row, variance=None, coherence=None) for one, row in zip(transfers, h, strict=True)]


def _tracked(found: TestModes) -> TrackedModes:
    """Return the modes as those of a campaign of one sweep."""
    return TrackedModes(
        temperature=np.array([found.frfs.temperature]),
        direction=("up",),
        level=np.array([0.0]),
        channels=tuple(one.name for one in found.frfs.transfers),
        modes=(found.modes,),
        track=np.flatnonzero(found.modes.real)[None].astype(np.int64),
        start=0,
        notes=found.frfs.notes,
    )


def load_test(run: Path) -> tuple[FrfSet, Modes, ModeShapes]:
    """Read back what `save_test` wrote.

    Parameters
    ----------
    run : Path
        The folder.

    Returns
    -------
    frfs : FrfSet
    modes : Modes
    shapes : ModeShapes

    Raises
    ------
    ResultFileError
        Where a file is missing or something else.
    """
    frfs = load_frfs(run / "transfers.h5")
    return frfs, load_modes(run / "modes.h5").modes[0], load_shapes(run / "modes.h5")


TEXTS = ("name", "response", "reference", "quantity", "reference_quantity")
COLUMNS = ("frequency_hz", "sigma_frequency_hz", "damping_ratio", "sigma_damping_ratio", "loss_factor")


def save_frfs(target: Path, frfs: FrfSet, made_from: Mapping[str, Any]) -> None:
    """Write a test's FRFs, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    record = {
        "title": frfs.title,
        "transfers": [{name: getattr(t, name) for name in TEXTS} | {"units": t.units} for t in frfs.transfers],
        "points": {str(node): place for node, place in frfs.points.items()},
        "mains": frfs.mains,
        "segments": None if frfs.segments is None else asdict(frfs.segments),
        "notes": frfs.notes,
        "hashes": dict(frfs.hashes),
        "operator": frfs.operator,
        "date": frfs.date,
    }
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        file.create_dataset("test", data=json.dumps(record))  # an attribute holds 64 KiB only
        file.attrs["window_rate"], file.attrs["temperature"] = frfs.window_rate, frfs.temperature
        file["frequency"], file["h"] = frfs.frequency, frfs.h
        for name in ("variance", "coherence"):
            values = [getattr(t, name) for t in frfs.transfers]
            if all(value is not None for value in values):
                file[name] = np.array(values)


def load_frfs(path: Path) -> FrfSet:
    """Read back what `save_frfs` wrote.

    Raises
    ------
    ResultFileError
        Where the file is missing or something else.
    """
    with result_file(path, "identify") as file:
        record = parse_json(file["test"].asstr()[()])
        frequency, h = file["frequency"][()], file["h"][()]
        known = {name: file[name][()] if name in file else [None] * len(h) for name in ("variance", "coherence")}
        transfers = tuple(
            MeasuredTransfer(
                **{name: str(one[name]) for name in TEXTS},
                units=(str(one["units"][0]), str(one["units"][1])),
                frequency=frequency,
                h=row,
                variance=variance,
                coherence=coherence,
            )
            for one, row, variance, coherence in zip(record["transfers"], h, *known.values(), strict=True)
        )
        return FrfSet(
            title=str(record["title"]),
            transfers=transfers,
            points={int(node): (float(x), float(y), float(z)) for node, (x, y, z) in record["points"].items()},
            window_rate=float(file.attrs["window_rate"]),
            temperature=float(file.attrs["temperature"]),
            mains=None if record["mains"] is None else float(record["mains"]),
            segments=None if record.get("segments") is None else Segments(**record["segments"]),
            notes=tuple(str(note) for note in record["notes"]),
            hashes={str(name): str(digest) for name, digest in record["hashes"].items()},
            operator=str(record.get("operator", "")),
            date=str(record.get("date", "")),
        )


def save_stabilization(target: Path, chart: StabilizationChart, made_from: Mapping[str, Any]) -> None:
    """Write a chart, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        write_value(file.create_group("stabilization"), chart)


def load_stabilization(path: Path) -> StabilizationChart:
    """Read back what `save_stabilization` wrote.

    Raises
    ------
    ResultFileError
        Where the file is missing or something else.
    """
    with result_file(path, "identify") as file:
        return read_value(file["stabilization"], StabilizationChart)


def write_modes_table(target: Path, modes: Modes, shapes: ModeShapes, temperature: float) -> None:
    """Write one row per mode as comma-separated text, its shape (real and imaginary part by place) after it.

    Parameters
    ----------
    shapes : ModeShapes
        Of these modes.
    temperature : float
        Degrees Celsius, the first column; none where it is NaN, not known.
    """
    reading, reasons = modes.reading(), modes.explanation()
    at = {} if np.isnan(temperature) else {"temperature_c": f"{temperature:.4f}"}
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    places = [f"{part} {place}" for place in shapes.places for part in ("re", "im")]
    rows.writerow([*at, "mode", *COLUMNS, "status", "confirmation", "reason", "mpc", "rank_one", *places])
    for number, (pole, shape, collinear, share) in enumerate(
        zip(shapes.pole, shapes.shape, mpc(shapes.shape), shapes.rank_one, strict=True), start=1
    ):
        values = [f"{float(getattr(reading, name)[pole]):.9g}" for name in COLUMNS]
        parts = [f"{part:.6g}" for component in shape for part in (component.real, component.imag)]
        judged = [modes.status[pole], modes.confirmed_word(pole), reasons[pole]]
        rows.writerow([*at.values(), number, *values, *judged, f"{collinear:.4f}", f"{share:.4f}", *parts])
    write_text(target, stream.getvalue())


MODE_HEADINGS = ("f [Hz]", "σ [Hz]", "ζ [%]", "σ [%]", "MPC", "status", "why")
AXIS = "mode: f [Hz]"
"""Label of an axis of `mode_names`."""


def mode_rows(modes: Modes, shapes: ModeShapes) -> list[tuple[str, ...]]:
    """Words under `MODE_HEADINGS` for every shape; no MPC where there is one place only, whose MPC is always 1."""
    reading, reasons, collinear = modes.reading(), modes.explanation(), mpc(shapes.shape)
    return [
        (
            *reading_cells(reading, j),
            f"{collinear[n]:.3f}" if len(shapes.places) > 1 else "–",
            modes.standing(j),
            reasons[j],
        )
        for n, j in enumerate(shapes.pole.tolist())
    ]


def mode_names(modes: Modes, shapes: ModeShapes) -> list[str]:
    """Return number and frequency of every shape, as at the axes of the AutoMAC: ``2: 262``."""
    return [f"{n}: {f:.0f}" for n, f in enumerate(modes.reading().frequency_hz[shapes.pole], start=1)]


def record_of(found: TestModes, seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints of a test that took so many seconds."""
    shapes = found.shapes
    frequency = found.modes.reading().frequency_hz
    collinear = mpc(shapes.shape)
    return {
        "title": found.frfs.title,
        "frfs": [
            {"name": t.name, "response": t.response, "reference": t.reference, "quantity": t.quantity}
            for t in found.frfs.transfers
        ],
        **modes_record(found.modes),
        "places": list(shapes.places),
        "references": list(shapes.references),
        "shapes": [
            {
                "frequency_hz": float(frequency[pole]),
                "shape": [None if np.isnan(c) else [float(c.real), float(c.imag)] for c in shape],
                "participation": [[float(c.real), float(c.imag)] for c in partner],
                "mpc": float(phase),
                "rank_one": float(share),
            }
            for pole, shape, partner, phase, share in zip(
                shapes.pole, shapes.shape, shapes.participation, collinear, shapes.rank_one, strict=True
            )
        ],
        "auto_mac": mac(shapes.shape, shapes.shape).tolist(),
        "notes": list(found.frfs.notes),
        "seconds": seconds,
    }


def shape_tables(found: TestModes) -> list[Table]:
    """Return a table of how the shapes are judged, where there is more than one place."""
    if len(found.shapes.places) < 2:
        return []
    alike = mac(found.shapes.shape, found.shapes.shape)
    np.fill_diagonal(alike, 0.0)
    frequency = found.modes.reading().frequency_hz[found.shapes.pole]
    collinear = mpc(found.shapes.shape)
    rows = []
    for n, f in enumerate(frequency):
        other = int(alike[n].argmax())
        near = f"{frequency[other]:.1f} Hz: {alike[n, other]:.2f}" if len(frequency) > 1 else ""
        rows.append((f"{f:.3f}", f"{collinear[n]:.3f}", f"{100 * found.shapes.rank_one[n]:.1f}", near))
    title = f"shapes at {len(found.shapes.places)} places"
    return [Table(title, ("f [Hz]", "MPC", "rank one [%]", "most alike: MAC"), tuple(rows))]
