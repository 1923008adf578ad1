"""Everything from files to the report in one call."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any

from threadpoolctl import threadpool_limits

from app.chain.run_chain import RunListener, run_chain
from app.chain.work import RunRequest, chosen_stages
from app.files.campaigns.kind import is_campaign_folder, is_recorded_campaign
from app.files.campaigns.loading import not_a_campaign
from app.files.declarations.plate import declares_plate
from app.files.declarations.run_settings import Stage, read_run_options, run_options_of
from app.files.results.run_record import RunRecord
from app.terminal.engine import spare_workers
from app.terminal.progress import progress as bars
from flexura.arguments import File, as_path


def run(
    campaign: File,
    *,
    out: File | None = None,
    first: Stage | None = None,
    last: Stage | None = None,
    without: Stage | Sequence[Stage] = (),
    options: Mapping[str, Any] | None = None,
    force: bool = False,
    workers: bool = False,
    progress: bool | None = None,
) -> RunRecord:
    """Do all stages with a campaign, from import to report, as ``flexura run``; those up to date are skipped.

    Parameters
    ----------
    campaign : path
        Recorded, imported or acquired, complete or not; or a plate with FRFs of other programs.
    out : path, optional
        Run folder; ``NAME-run`` beside the campaign where it is left out.
    first, last : str, optional
        Begin with this stage, end with this one.
    without : str or sequence of str
        Stages left out.
    options : mapping, optional
        What the table ``[run]`` of a file holds, for example ``{"focus": {"panel": "door.toml"}}``; that of the
        campaign's declaration where it is left out.
    force : bool
        Make again what is up to date.
    workers : bool
        Build models and draw figures in worker processes. They import the calling script: its own work must then
        stand below ``if __name__ == "__main__":``.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Returns
    -------
    RunRecord
        What ``run.json`` holds. A stage that failed is told there, not raised.

    Raises
    ------
    ValueError
        For options that are not allowed, or no stage left.
    app.files.campaign_error.CampaignFileError
        For a campaign that cannot be read.
    app.files.bad_file.ResultFileError
        For a run folder that cannot be used.
    """
    folder = as_path(campaign)
    if not (is_campaign_folder(folder) or is_recorded_campaign(folder) or declares_plate(folder)):
        raise not_a_campaign(folder)
    chosen = read_run_options(folder, None, ()) if options is None else run_options_of(options)
    left_out = (*((without,) if isinstance(without, str) else without), *chosen.settings.without)
    stages = chosen_stages(first, last, (), left_out)
    run_folder = None if out is None else as_path(out)
    request = RunRequest(folder, run_folder, stages, chosen, force, in_place="import" in left_out)
    listener = RunListener(
        lambda stage, state: None,
        lambda: bars(shown=progress),
        lambda models: spare_workers(models) if workers else nullcontext(),
    )
    with threadpool_limits(1):
        return run_chain(request, listener)
