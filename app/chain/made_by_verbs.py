"""Results of single verbs that a run need not make again: their provenance is what the run would write.

Of identify, update and gap it holds everything that decides the result. Of focus, compensate and report it does
not, so that a run makes these itself once.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.chain.work import Work, effect_hashes
from app.files.bad_file import ResultFileError
from app.files.campaigns.folder import SWEEPS
from app.files.campaigns.inputs import EXTENT
from app.files.campaigns.kind import DECLARATION, PROTOCOL
from app.files.declarations.run_settings import Stage
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp, sha256
from app.files.results.best_twin import gap_record_of
from app.files.results.laws_file import load_pairing, load_updated
from app.files.results.modes_file import load_modes
from app.files.results.run_record import versions
from app.summaries.modes import no_fit_words

FREE = (EXTENT, "campaign")
"""Settings that follow from the inputs: how many sweeps, and the folder's name."""
MADE_IN = {"identify": "modes.h5", "update": "laws.h5", "gap": "gap.h5"}


def made_alike(work: Work, stage: Stage, known: Mapping[str, str]) -> bool | None:
    """Say whether a result that a stage's verb made, as this run would, is good enough.

    Parameters
    ----------
    stage : str
    known : mapping of str to str
        SHA-256 of what a run made: if it is that, and the run's record does not hold any more, something else has
        changed that provenance does not tell.

    Returns
    -------
    bool or None
        None where there is no such result.
    """
    name = MADE_IN.get(stage)
    if name is None or not (work.run / name).is_file() or not (work.run / "frf.h5").is_file():
        return None
    if known.get(name) == sha256(work.run / name):
        return None
    try:
        with result_file(work.run / name, stage) as file:
            held = read_stamp(file)
        good = _good(work.run, stage)
    except ResultFileError:
        return None
    wanted = {**versions(), "inputs": _inputs(work, stage), "settings": _settings(work, stage)}
    found = {**held, "settings": {key: one for key, one in held["settings"].items() if key not in FREE}}
    same = all(found.get(key) == value for key, value in wanted.items())
    return good if same and _all_there(work.run, stage) else None


def _good(run: Path, stage: Stage) -> bool:
    """Whether a result is good enough, as the exit status of its verb said; ResultFileError if unreadable."""
    if stage == "gap":
        record = gap_record_of(run)
        return record is not None and record["verdict"] in ("none", "explained")
    if stage == "update":
        settled = load_updated(run / "laws.h5")[0].settled.all()
        return bool(settled) and not no_fit_words(load_pairing(run / "laws.h5"))
    return any(modes.real.any() for modes in load_modes(run / "modes.h5").modes)


def _all_there(run: Path, stage: Stage) -> bool:
    beside = {"identify": ("modes.csv",), "update": (), "gap": ("gap.json", "twin.toml")}
    return all((run / name).is_file() for name in beside[stage])


def _inputs(work: Work, stage: Stage) -> dict[str, str]:
    """Return inputs as a result's provenance holds them."""
    kept = {
        name: digest
        for name, digest in work.hashes.items()
        if name in (PROTOCOL, DECLARATION) or name.startswith(f"{SWEEPS}/")
    }
    return kept | (effect_hashes(work.effects) if stage == "gap" else {})


def _settings(work: Work, stage: Stage) -> dict[str, Any]:
    if stage != "identify":
        return {"mains": work.settings.mains}
    from analysis.identification.settings import Settings
    from app.stages.identify_options import Wanted

    options = work.settings.identify
    wanted = Wanted(
        Settings(mains=work.settings.mains), options.damping, options.method, options.band, options.actuator
    )
    return wanted.record()
