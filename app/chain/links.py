"""The stages of a run: what each needs, reads and writes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from analysis.progress import Progress
from app.chain import panel_links, plate_links
from app.chain.work import Made, Work
from app.files.declarations.run_settings import Stage


@dataclass(frozen=True)
class Link:
    """A stage in the chain.

    Attributes
    ----------
    make : callable
        Does the work and saves it.
    inputs : callable
        Returns the SHA-256 of all that it reads, by name.
    settings : callable
        Returns everything chosen that decides its result.
    results : tuple of str
        Files that it alone writes, into the run folder, those of import into the campaign's; ``frf.h5`` is written
        by three stages.
    needs : tuple of str
        Stages without which it cannot be done, if they were asked for.
    reads_campaign : bool
        Whether it needs the sweeps themselves.
    """

    make: Callable[[Work, Progress], Made]
    inputs: Callable[[Work], dict[str, str]]
    settings: Callable[[Work], Mapping[str, Any]]
    results: tuple[str, ...]
    needs: tuple[Stage, ...] = ()
    reads_campaign: bool = False


LINKS: Mapping[Stage, Link] = {
    "import": Link(plate_links.do_import, plate_links.import_inputs, plate_links.no_settings, ("protocol.json",)),
    "identify": Link(
        plate_links.do_identify,
        plate_links.campaign_inputs,
        plate_links.identify_settings,
        ("modes.h5", "modes.csv"),
        reads_campaign=True,
    ),
    "update": Link(
        plate_links.do_update,
        plate_links.update_inputs,
        plate_links.update_settings,
        ("laws.h5",),
        reads_campaign=True,
    ),
    "gap": Link(
        plate_links.do_gap,
        plate_links.gap_inputs,
        plate_links.update_settings,
        ("gap.json", "gap.h5", "twin.toml", "laws-corrected.h5"),
        ("update",),
        reads_campaign=True,
    ),
    "focus": Link(
        panel_links.do_focus,
        panel_links.focus_inputs,
        panel_links.focus_settings,
        ("filters.h5",),
        ("update",),
    ),
    "compensate": Link(
        panel_links.do_compensate,
        panel_links.compensate_inputs,
        panel_links.compensate_settings,
        ("compensation.h5",),
        ("update",),
    ),
    "report": Link(
        panel_links.do_report,
        panel_links.report_inputs,
        panel_links.report_settings,
        ("report.html",),
    ),
}
