"""Identify stage of a modal test, or of a universal file's FRFs of one structure: modes and mode shapes."""

from analysis.progress import Progress
from analysis.recordings.mains import likely_mains
from app.modal_test.frf_set import FrfSet, cut
from app.modal_test.modes_of_test import TestModes, identify_test, save_test
from app.stages.identify_options import Wanted

save = save_test


def compute(frfs: FrfSet, wanted: Wanted, report: Progress, *, mains_named: bool) -> tuple[TestModes, Wanted]:
    """Identify FRFs with one set of poles, and compute mode shapes from their residues.

    Parameters
    ----------
    frfs : FrfSet
        Of one structure.
    report : callable
        Called with the stage's name and the share done.
    mains_named : bool
        Whether the user chose the mains frequency in `wanted`; if not, it is detected in the FRFs.

    Returns
    -------
    found : TestModes
    wanted : Wanted
        With the mains frequency used: that of the declaration, or the one whose hum the FRFs show.

    Raises
    ------
    ResultFileError
        Where nothing can be identified.
    """
    frfs = cut(frfs, wanted.band)
    if frfs.mains is not None:
        wanted = wanted.at_mains(frfs.mains)
    elif not mains_named and (mains := likely_mains(frfs.frequency, frfs.h)):
        wanted = wanted.at_mains(mains)
    return identify_test(frfs, wanted, report), wanted
