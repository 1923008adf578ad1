"""Identify stage of a test, or of a universal file's FRFs as those of one structure: modes and shapes."""

from analysis.mains import likely_mains
from analysis.progress import Progress
from app.modal_test.frf_set import FrfSet, cut
from app.modal_test.modes_of_test import TestModes, identify_test, save_test
from app.stages.identify import Wanted

save = save_test


def compute(frfs: FrfSet, wanted: Wanted, report: Progress, *, mains_named: bool) -> tuple[TestModes, Wanted]:
    """Identify FRFs with one set of poles, and take shapes out of their residues.

    Parameters
    ----------
    frfs : FrfSet
        Of one structure.
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
    ResultFileError
        Where nothing can be identified.
    """
    frfs = cut(frfs, wanted.band)
    if frfs.mains is not None:
        wanted = wanted.at_mains(frfs.mains)
    elif not mains_named and (heard := likely_mains(frfs.frequency, frfs.h)):
        wanted = wanted.at_mains(heard)
    return identify_test(frfs, wanted, report), wanted
