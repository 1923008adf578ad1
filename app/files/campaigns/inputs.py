"""Of which sweeps of which campaign a result was made: its provenance held against the campaign as it is now.

A campaign can get further sweeps after it was identified or updated. What was made of fewer sweeps is not wrong,
but it must not be taken for a result of all of them: the hashes of its inputs tell.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from analysis.recordings.campaign import CampaignExtent
from analysis.recordings.frf_campaign import AnyCampaign
from app.files.bad_file import quoted
from app.files.campaigns.folder import SWEEPS, sweep_paths
from app.files.campaigns.kind import DECLARATION, PROTOCOL, is_campaign_folder
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp, sha256
from app.files.results.run_folder import beside

EXTENT = "extent"
"""Key of the settings under which an incomplete campaign's sweeps are kept."""
OF_CAMPAIGN = ("frf.h5", "modes.h5", "laws.h5", "gap.h5")
"""Results that are made from the sweeps themselves; the others follow from the laws."""
Hashes = Mapping[str, str]
"""SHA-256 of every input of a result, by name."""


def campaign_settings(campaign: AnyCampaign) -> dict[str, Any]:
    """Return what a result's provenance keeps of its campaign: the name, and how many sweeps of how many."""
    return {"campaign": campaign.name, **extent_settings(campaign.extent)}


def extent_settings(extent: CampaignExtent | None) -> dict[str, Any]:
    """Return the part of it that says how many; nothing of a complete campaign."""
    return {} if extent is None else {EXTENT: asdict(extent)}


def stored_extent(made_from: Mapping[str, Any]) -> CampaignExtent | None:
    """Read that back; None of a complete campaign, and of versions that kept none.

    ValueError or TypeError where the provenance holds something else.
    """
    held = made_from["settings"].get(EXTENT)
    return None if held is None else CampaignExtent(**held)


@dataclass(frozen=True)
class Origin:
    """What a result was made from.

    Attributes
    ----------
    inputs : dict
        SHA-256 of every input, by name.
    settings : dict
    extent : CampaignExtent or None
        Of the campaign, where that was not complete.
    """

    inputs: dict[str, str]
    settings: dict[str, Any]
    extent: CampaignExtent | None


def origin_of_result(path: Path, verb: str) -> Origin:
    """Read it from a result's provenance; ResultFileError names the verb that makes an unreadable file again."""
    with result_file(path, verb) as file:
        stamp = read_stamp(file)
        return Origin(dict(stamp["inputs"]), dict(stamp["settings"]), stored_extent(stamp))


def sweeps_of(hashes: Hashes) -> dict[str, str]:
    """Return the sweeps among a result's inputs."""
    return {name: digest for name, digest in hashes.items() if name.startswith(f"{SWEEPS}/")}


def has_other_sweeps(made_from: Hashes, now: Hashes) -> bool:
    """Whether a result and a later reading are of one campaign, but not of the same sweeps of it."""
    declared = _declared(now)
    return declared is not None and declared == _declared(made_from) and sweeps_of(made_from) != sweeps_of(now)


def _declared(hashes: Hashes) -> str | None:
    """SHA-256 of a campaign's declaration."""
    return hashes.get(PROTOCOL, hashes.get(DECLARATION))


def said_of_more_sweeps(run: Path, made_from: Hashes, again: str) -> str | None:
    """Say that a campaign beside a run folder holds other sweeps now than a result was made from.

    Parameters
    ----------
    run : Path
        Run folder of the result.
    made_from : mapping
        SHA-256 of the result's inputs.
    again : str
        Verb that makes it again.

    Returns
    -------
    str or None
        None where the campaign is not to be found beside the run, and where its sweeps are the same.
    """
    run, used = run.resolve(), sweeps_of(made_from)
    for campaign in _campaigns_near(run, made_from):
        there = {f"{SWEEPS}/{path.name}": path for path in sweep_paths(campaign)}
        try:
            kept = used.keys() <= there.keys() and all(sha256(there[name]) == used[name] for name in used)
        except OSError:  # moved just now
            continue
        if kept and len(used) == len(there):
            return None
        if kept or run == beside(campaign):  # a copy of the campaign may have gone another way
            others = "" if len(used) != len(there) else ", others"
            into = "" if run == beside(campaign) else f" --out {quoted(run)}"
            return (
                f"made from {_counted(len(used))} of a campaign that has {len(there)} finished ones now{others}; "
                f"to take them in: flexura {again} {quoted(campaign)}{into}"
            )
    return None


def _counted(count: int) -> str:
    return f"{count} sweep{'' if count == 1 else 's'}"


def _campaigns_near(run: Path, made_from: Hashes) -> Iterator[Path]:
    """Yield the folders beside a run folder that hold its campaign, by the frozen declaration; its own first."""
    declared = made_from.get(PROTOCOL)
    if declared is None or not sweeps_of(made_from):
        return
    with suppress(OSError):
        near = sorted([run, *run.parent.iterdir()], key=lambda one: (run != beside(one), one))
        for one in near:
            if is_campaign_folder(one) and sha256(one / PROTOCOL) == declared:
                yield one
