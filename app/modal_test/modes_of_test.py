"""Modes and shapes of a test: computed, saved in a run folder, loaded again."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.transfer import MeasuredTransfer
from analysis.estimation.windows import without_window
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.status import WEAK_DAMPING
from analysis.identification.tracked_modes import TrackedModes
from analysis.progress import Progress
from analysis.shapes.participation import ModeShapes, mode_shapes, residue_deviation
from analysis.shapes.stabilization import StabilizationChart, stabilization_chart
from app.files.bad_file import ResultFileError
from app.files.modes_file import load_modes, load_shapes, save_modes
from app.files.provenance import provenance
from app.files.uff58 import write_frfs
from app.files.uff_modes import write_modes
from app.modal_test.frf_set import FrfSet
from app.modal_test.saved import load_frfs, save_frfs, save_stabilization, write_modes_table

if TYPE_CHECKING:
    from app.stages.identify import Wanted

WIDE = 8.0
"""Half-power width of a mode in lines from which a Hann window leaves its damping within a few per cent."""

UNSURE = "without the window's its damping ratio is known to {:.0f} % only"
DROWNED = "the exponential window drowned its damping: record longer blocks with a weaker window"


@dataclass(frozen=True)
class TestModes:
    """What was found in a test.

    Attributes
    ----------
    frfs : FrfSet
        As measured, inside the band.
    modes : Modes
        An exponential window's damping taken out.
    shapes : ModeShapes
        Of those poles that are modes of the structure.
    chart : StabilizationChart
    """

    __test__ = False

    frfs: FrfSet
    modes: Modes
    shapes: ModeShapes
    chart: StabilizationChart

    def rebuilt(self) -> NDArray[np.complex128]:
        """FRFs of the model as they were fitted, (L, F): with the window that was over the measured ones."""
        return rebuilt(self.modes, self.frfs.frequency, self.frfs.window_rate)


def rebuilt(modes: Modes, frequency: NDArray[np.float64], window_rate: float) -> NDArray[np.complex128]:
    """FRFs that the modes make under an exponential window.

    Parameters
    ----------
    modes : Modes
        The window's damping taken out.
    frequency : (F,) ndarray
        Hz.
    window_rate : float
        1/s.

    Returns
    -------
    (L, F) complex ndarray
        In the units of the residues.
    """
    return replace(modes, poles=modes.poles - window_rate).synthesis(frequency)


def identify_test(frfs: FrfSet, wanted: "Wanted", report: Progress) -> TestModes:
    """Identify the FRFs of a structure with one set of poles.

    Parameters
    ----------
    frfs : FrfSet
    wanted : Wanted
    report : callable
        Called with the stage's name and the share done.

    Returns
    -------
    TestModes

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
    report("identify", 0.9)
    orders = np.unique(np.linspace(2, 2 * max(len(modes.poles), 3) + 2, 8).astype(int))
    chart = stabilization_chart(Measured(frfs.frequency, frfs.h), modes.terms, [int(n) for n in orders])
    report("identify", 1.0)
    widened = replace(frfs, notes=(*frfs.notes, *_widened(modes, frfs.segment)))
    return shaped_test(widened, freed(modes, frfs.window_rate), chart)


def shaped_test(frfs: FrfSet, modes: Modes, chart: StabilizationChart) -> TestModes:
    """Take shapes out of the residues of modes.

    Parameters
    ----------
    frfs : FrfSet
    modes : Modes
        An exponential window's damping taken out.
    chart : StabilizationChart

    Returns
    -------
    TestModes
    """
    left = frfs.h - rebuilt(modes, frfs.frequency, frfs.window_rate)
    noise = residue_deviation(frfs.frequency, left, modes.poles - frfs.window_rate)
    shapes = mode_shapes(frfs.transfers, modes.poles, modes.residues, modes.real, noise)
    return TestModes(frfs, modes, shapes, chart)


def _widened(modes: Modes, segment: float) -> list[str]:
    """Say which mode the segments' window widens most, and how long they would have to be."""
    width = -modes.poles.real / np.pi
    width = np.where(modes.real, width, np.inf)
    if not segment or not len(width) or width.min() * segment >= WIDE:
        return []
    narrow = int(np.argmin(width))
    f, eta = abs(modes.poles[narrow]) / (2.0 * np.pi), 2.0 * -modes.poles[narrow].real / abs(modes.poles[narrow])
    return [
        f"segments of {segment:g} s widen the mode at {f:.1f} Hz: a loss factor of {100 * eta:.2g} % there needs "
        f"{WIDE / width.min():.2g} s: lengthen segments.seconds, and the recording with it"
    ]


def freed(modes: Modes, rate: float) -> Modes:
    """Take an exponential window's damping out of the poles; those are called weak whose own is then not known."""
    if not rate:
        return modes
    poles, spread = without_window(modes.poles, modes.covariance, rate)
    drowned = modes.poles.real + rate > 1e-3 * modes.poles.real
    known = np.sqrt(spread[:, 1, 1])
    words = [
        DROWNED if d else UNSURE.format(100 * k) if k > WEAK_DAMPING else ""
        for d, k in zip(drowned, known, strict=True)
    ]
    return replace(
        modes,
        poles=poles,
        covariance=spread,
        status=tuple("weak" if w and s == "kept" else s for w, s in zip(words, modes.status, strict=True)),
        reason=tuple(f"{r}; {w}" if w else r for w, r in zip(words, modes.reason, strict=True)),
    )


def save_test(run: Path, found: TestModes, wanted: "Wanted") -> None:
    """Write everything a run folder of a test holds; each file whole or not at all.

    Parameters
    ----------
    run : Path
        The folder.
    found : TestModes
    wanted : Wanted
        With which they were found.
    """
    write_run(run, found, {"test": found.frfs.title} | wanted.record())


def write_run(run: Path, found: TestModes, settings: Mapping[str, Any]) -> None:
    """Write everything that a run folder of a test holds.

    Parameters
    ----------
    run : Path
        The folder.
    found : TestModes
    settings : mapping
        For the provenance; its ``damping`` says how poles are read in the table.
    """
    frfs, made_from = found.frfs, provenance(found.frfs.hashes, settings)
    save_frfs(run / "transfers.h5", frfs, made_from)
    save_modes(run / "modes.h5", _tracked(found), made_from, found.shapes)
    save_stabilization(run / "stabilization.h5", found.chart, made_from)
    write_modes_table(run / "modes.csv", found.modes, found.shapes, settings["damping"])
    write_modes(run / "modes.uff", found.modes, found.shapes, frfs.points)
    write_frfs(run / "frfs.uff", frfs.transfers)
    write_frfs(run / "rebuilt.uff", _with_values(frfs.transfers, found.rebuilt()))


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
