"""Modal tests: FRFs of one structure at one temperature to modes and mode shapes."""

from collections.abc import Sequence
from dataclasses import replace

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.modes import Damping
from analysis.identification.settings import Settings
from analysis.progress import Progress
from app.files.results.run_folder import writable_folder
from app.modal_test.declared_test import frfs_of_file
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import TestModes
from app.stages import identify_structure as stage
from app.stages.identify_options import Method, Wanted
from flexura.arguments import File, as_path, computing

Test = File | FrfSet | Sequence[MeasuredTransfer]
"""``test.toml`` or its folder, a universal file, or FRFs in memory that share their lines."""


def frfs_of_test(test: File, *, progress: bool | None = None) -> FrfSet:
    """FRFs of a modal test, estimated from its recordings or read; they may be changed and identified.

    Parameters
    ----------
    test : path
        ``test.toml`` or its folder, or a universal file.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError, app.files.campaign_error.CampaignFileError
        For files that cannot be used, with all that is wrong with them.
    """
    with computing(shown=progress) as report:
        return frfs_of_file(as_path(test), report)


def identify_test(
    test: Test,
    *,
    band: tuple[float, float] | None = None,
    damping: Damping = "viscous",
    method: Method = "auto",
    mains: float | None = None,
    out: File | None = None,
    progress: bool | None = None,
) -> TestModes:
    """Identify a structure's FRFs with one set of poles, with mode shapes, as ``flexura identify``.

    Parameters
    ----------
    test : path, FrfSet or sequence of MeasuredTransfer
        ``test.toml`` or its folder, a universal file, or FRFs in memory, all over the same lines.
    band : (float, float), optional
        Hz; all lines where it is left out.
    damping : str
        How poles are read: ``viscous`` (undamped natural frequency and damping ratio) or ``hysteretic``.
    method : str
        ``peak-picking`` is the paper's recipe.
    mains : float, optional
        Hz; that of the declaration, or the one whose hum the FRFs show, where it is left out.
    out : path, optional
        Run folder for transfers.h5, modes.h5, shapes and tables; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    ValueError
        For an option outside what it allows, and FRFs in memory that do not share their lines.
    app.files.bad_file.ResultFileError, app.files.campaign_error.CampaignFileError
        For files that cannot be used, and where nothing can be identified.
    """
    settings = Settings() if mains is None else Settings(mains=mains)
    wanted = Wanted(settings, damping, method, band)
    run = None if out is None else writable_folder(as_path(out), "out")
    with computing(shown=progress) as report:
        frfs = _taken(test, report)
        if mains is not None:
            frfs = replace(frfs, mains=mains)
        found, wanted = stage.compute(frfs, wanted, report, mains_named=mains is not None)
    if run is not None:
        stage.save(run, found, wanted)
    return found


def _taken(test: Test, report: Progress) -> FrfSet:
    if isinstance(test, FrfSet):
        return test
    if isinstance(test, Sequence) and not isinstance(test, str):
        lines = {one.frequency.tobytes() for one in test}
        if len(lines) != 1:
            raise ValueError(f"{len(test)} FRFs over {len(lines)} different sets of lines; one set is wanted")
        return FrfSet("FRFs in memory", tuple(test))
    return frfs_of_file(as_path(test), report)
