"""Stages on the panel as a run does them, and the report: focus, compensate, report."""

from typing import Any

from analysis.progress import Progress
from app.chain.input_files import file_hashes
from app.chain.models_ahead import PANEL
from app.chain.work import Made, Work
from app.files.declarations.panel import SECTION_2
from app.files.results.run_folder import MADE_BY
from app.files.results.run_record import hashed
from app.terminal.end_signals import held_back

OF_LAWS = ("laws.h5", "laws-corrected.h5", "gap.json")
"""Files that decide which laws a panel's plate obeys."""


def focus_inputs(work: Work) -> dict[str, str]:
    """Laws of the run's best twin, and the panel's file."""
    return hashed(work.run, OF_LAWS) | file_hashes(work.panel or SECTION_2)


def compensate_inputs(work: Work) -> dict[str, str]:
    """Those of `focus_inputs`, the filters that are followed, and the weather they are judged in."""
    weather = {} if work.weather is None else file_hashes(work.weather)
    return focus_inputs(work) | hashed(work.run, ("filters.h5",)) | weather


def report_inputs(work: Work) -> dict[str, str]:
    """All results, and the campaign, of which the page says whether it has got more sweeps."""
    return work.hashes | hashed(work.run, tuple(dict.fromkeys((*MADE_BY, *OF_LAWS))))


def focus_settings(work: Work) -> dict[str, Any]:
    """Options of focus."""
    return work.settings.focus.model_dump(mode="json", exclude={"panel"})


def compensate_settings(work: Work) -> dict[str, Any]:
    """Options of compensate."""
    return work.settings.compensate.model_dump(mode="json", exclude={"weather"})


def report_settings(work: Work) -> dict[str, Any]:
    """Options of the report."""
    return work.settings.report.model_dump(mode="json")


def do_focus(work: Work, report: Progress) -> Made:
    """Design filters over temperature."""
    from app.stages import focus
    from app.stages.focus_request import FocusRequest
    from app.summaries.focusing import correction, notes

    options = work.settings.focus
    task = FocusRequest(work.run, None, work.panel, options.changes(), options.method, options.temperatures).task()
    work.models.wait_for(PANEL, report)
    found = task.compute(report)
    with held_back():
        focus.save(work.run, found, task.hashes(), task.extent)
    told = (*notes(found.panel, found.focusing), *task.notes, *correction(found.focusing, found.uncorrected))
    return Made(repr(found).splitlines()[0].strip("<>").removeprefix("FocusedPanel: "), told)


def do_compensate(work: Work, report: Progress) -> Made:
    """Train networks that give the filters at any temperature, and compare other methods."""
    from analysis.compensation.settings import Training
    from app.stages import compensate
    from app.stages.compensate_request import CompensateRequest
    from app.stages.panel_inputs import checked_device
    from app.summaries.compensation import notes

    options, focusing = work.settings.compensate, work.settings.focus
    own = "focus" in work.broken or not (work.run / "filters.h5").is_file()
    task = CompensateRequest(  # follows the run's filters, as the verb does; without them, what they would be
        work.run,
        panel=(work.panel or SECTION_2) if own else None,
        changes=focusing.changes() if own else {},
        method=focusing.method if own else None,
        spacing=options.spacing,
        place=options.place,
        across=options.across,
        training=Training(**options.training()),
        nodes_chosen=options.nodes is not None,
        weather=work.weather,
    ).task()
    checked_device(options.device)
    work.models.wait_for(PANEL, report)
    computed = task.compute(report, options.device)
    with held_back():
        compensate.save(work.run, computed, task.hashes(), task.extent)
    found = computed.compensation
    said = repr(computed).splitlines()[0].strip("<>").removeprefix("CompensatedPanel: ")
    good = bool(found.largest_loss[0] <= compensate.GOOD_LOSS)
    return Made(said, (*task.notes, *notes(found, task.training)), good, options.seed)


def do_report(work: Work, report: Progress) -> Made:
    """Write all results on one page."""
    from app.report.written import write_report

    written = write_report(work.run, work.run, report, pictures=work.settings.report.pictures, parts=work.parts)
    return Made(written.line(), written.amiss)
