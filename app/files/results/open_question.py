"""What an earlier comparison left open, read from its gap.json."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.gap.plan.measurement import OVEN_FIXED
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.of_run import campaign_of
from app.files.parsed_text import parse_json, read_text

TURNED = "turned_plate"
LARGEST_GAP_FILE = 50_000_000
"""Bytes of a gap.json that is read."""


def open_before(run: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Read from a run what its plan left open.

    Parameters
    ----------
    run : Path
        Run folder with a gap.json of ``flexura gap --plan``.

    Returns
    -------
    effects : tuple of str
        All that its questions are about.
    turned : tuple of str
        Those whose amplitudes change sign, where the plan was to turn the plate.

    Raises
    ------
    ResultFileError
        Where there is none, or nothing was open.
    """
    file = run / "gap.json"
    try:
        record: Mapping[str, Any] = parse_json(read_text(file, LARGEST_GAP_FILE))
        plan = record["plan"]
        names = [name for one in plan["questions"] for name in (one["effect"], one["rival"]) if name]
        chosen = plan["next"] or {}
    except (OSError, CampaignFileError, ValueError, KeyError, TypeError) as error:
        wanted = f"make it with: flexura gap {campaign_of(run)} --plan"
        raise ResultFileError(f"{file}: holds no plan; {wanted}") from error
    if not names:
        raise ResultFileError(f"{file}: its plan has no questions; nothing was open that could be decided")
    turned = OVEN_FIXED if chosen.get("key") == TURNED else ()
    return tuple(dict.fromkeys(str(name) for name in names)), turned
