"""Identify stage of a test, or of a universal file's FRFs as those of one structure: modes and shapes."""

from pathlib import Path

from analysis.mains import likely_mains
from analysis.progress import Progress
from app.files.modal_test_toml import declares_test
from app.files.uff58 import read_frfs
from app.modal_test.declared_test import declared_frfs
from app.modal_test.frf_set import cut, of_universal
from app.modal_test.modes_of_test import TestModes, identify_test, save_test
from app.stages.identify import Wanted

save = save_test


def compute(path: Path, wanted: Wanted, report: Progress, *, mains_named: bool) -> tuple[TestModes, Wanted]:
    """Identify FRFs with one set of poles, and take shapes out of their residues.

    Parameters
    ----------
    path : Path
        Declaration of a test, its folder, or a universal file.
    wanted : Wanted
    report : callable
        Told the stage's name and the share done.
    mains_named : bool
        Whether the mains frequency in `wanted` was chosen by the user: then it is not looked for in the FRFs.

    Returns
    -------
    found : TestModes
    wanted : Wanted
        At the mains frequency of the declaration, or the one whose hum the FRFs show.

    Raises
    ------
    CampaignFileError
        For what is wrong with the declaration.
    ResultFileError
        Where nothing can be identified.
    """
    frfs = declared_frfs(path, report) if declares_test(path) else of_universal(path, read_frfs(path))
    frfs = cut(frfs, wanted.band)
    if frfs.mains is not None:
        wanted = wanted.at_mains(frfs.mains)
    elif not mains_named and (heard := likely_mains(frfs.frequency, frfs.h)):
        wanted = wanted.at_mains(heard)
    return identify_test(frfs, wanted, report), wanted
