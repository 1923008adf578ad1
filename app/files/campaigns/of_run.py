"""Which campaign a run folder belongs to, so that commands on its report can be copied.

A run folder named with ``--out`` has ``campaign.json`` with the path of its campaign, relative to it; ``NAME-run``
beside the campaign needs none.
"""

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from app.files.atomic import write_json
from app.files.bad_file import quoted
from app.files.campaigns.inputs import OF_CAMPAIGN
from app.files.campaigns.kind import is_campaign_folder, is_recorded_campaign
from app.files.declarations.plate import declares_plate
from app.files.parsed_text import parse_json, read_text
from app.files.results.run_folder import MADE_BY, beside

POINTER = "campaign.json"


def remember_campaign(run: Path, campaign: Path) -> None:
    """Write where the campaign of a run folder is, unless it stands beside it under its name, or is told there."""
    if run.resolve() == beside(campaign):
        (run / POINTER).unlink(missing_ok=True)
        return
    try:
        there = os.path.relpath(campaign.resolve(), run.resolve())
    except ValueError:  # on another drive
        there = str(campaign.resolve())
    told = {"campaign": Path(there).as_posix()}
    with suppress(OSError, ValueError):
        if parse_json(read_text(run / POINTER)) == told:
            return
    write_json(run / POINTER, told)


def campaign_typed(campaign: Path, out: Path | None) -> str:
    """Return what stands behind ``flexura gap`` for a campaign whose results go to `out`."""
    into = "" if out is None or out.resolve() == beside(campaign) else f" --out {quoted(out)}"
    return f"{quoted(campaign)}{into}"


def campaign_of(run: Path) -> str:
    """Return what stands behind ``flexura gap`` so that its results go into a run folder, as whole paths.

    ``CAMPAIGN``, and where the results go, where the campaign is not to be found.
    """
    run = run.resolve()
    for campaign in _candidates(run):
        if is_campaign_folder(campaign) or is_recorded_campaign(campaign) or declares_plate(campaign):
            return campaign_typed(campaign, run)
    return f"CAMPAIGN --out {quoted(run)}"


def made_by(run: Path, name: str) -> str:
    """Return the command that makes a result of a run folder again, without ``flexura``."""
    verb = MADE_BY[name].split(" or ")[0]
    return f"{verb} {campaign_of(run) if name in OF_CAMPAIGN else quoted(run.resolve())}"


def _candidates(run: Path) -> Iterator[Path]:
    with suppress(OSError, ValueError, TypeError, KeyError):
        if (run / POINTER).is_file():
            yield (run / str(parse_json(read_text(run / POINTER))["campaign"])).resolve()
    with suppress(OSError):
        yield from (one for one in sorted(run.parent.iterdir()) if one != run and beside(one) == run)
