"""The stages of a run, on the measured plate and on the panel: what each needs, reads, does and writes."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from analysis.progress import Progress
from app.chain.models_ahead import EFFECTS, PANEL, PLATE
from app.chain.work import Made, Work, effect_hashes, file_hashes
from app.files.campaigns.of_run import campaign_typed
from app.files.declarations.panel import SECTION_2
from app.files.declarations.run_settings import Stage
from app.files.results.run_folder import MADE_BY
from app.files.results.run_record import hashed
from app.terminal.end_signals import held_back

OF_LAWS = ("laws.h5", "laws-corrected.h5", "gap.json")
"""Files that decide which laws a panel's plate obeys."""


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


def no_settings(_: Work) -> dict[str, Any]:
    """Nothing is chosen."""
    return {}


def import_inputs(work: Work) -> dict[str, str]:
    """Files of the recording."""
    return dict(work.recorded)


def campaign_inputs(work: Work) -> dict[str, str]:
    """Files of the campaign."""
    return dict(work.hashes)


def update_inputs(work: Work) -> dict[str, str]:
    """Files of the campaign, and the modes that are paired."""
    return work.hashes | hashed(work.run, ("modes.h5",))


def gap_inputs(work: Work) -> dict[str, str]:
    """Those of `update_inputs`, the laws that the corrected ones must belong to, and a user's own effects."""
    return update_inputs(work) | hashed(work.run, ("laws.h5",)) | effect_hashes(work.effects)


def identify_settings(work: Work) -> dict[str, Any]:
    """Options of identify, and the mains frequency."""
    return work.settings.identify.model_dump(mode="json") | {"mains": work.settings.mains}


def update_settings(work: Work) -> dict[str, Any]:
    """Mains frequency."""
    return {"mains": work.settings.mains}


def do_import(work: Work, report: Progress) -> Made:
    """Import the recording; one that lacks sweeps is not imported but read where it stands, as by other verbs."""
    from app.files.campaigns.import_recording import import_read
    from app.files.campaigns.recorded import read_recording
    from app.stages.comparison.temperature_notes import recorded_notes

    target, source = work.request.imported, work.request.campaign
    if target is None:
        raise AssertionError("a campaign that is read where it stands is not imported")
    recording = read_recording(source, report=report, allow_absent=True)
    notes = recorded_notes(recording.campaign)
    if recording.missing:
        work.in_place = True
        work.renew()
        count = len(recording.campaign.sweeps)
        said = f"{count} of {count + len(recording.missing)} sweeps are there: read where they are, not imported"
        return Made(said, notes)
    with held_back():
        imported = import_read(recording, source, target, report)
    work.renew()
    return Made(f"{len(recording.campaign.sweeps)} sweeps, {imported.state}: {target}", notes)


def do_identify(work: Work, report: Progress) -> Made:
    """Find the modes and follow them over temperature."""
    from analysis.identification.settings import Settings
    from app.stages import identify
    from app.stages.identify_options import Wanted
    from app.summaries.modes import headline

    options = work.settings.identify
    settings = Settings(mains=work.settings.mains)
    wanted = Wanted(settings, options.damping, options.method, options.band, options.actuator)
    found = identify.compute(work.campaign, wanted, report)
    with held_back():
        identify.save(work.run, work.campaign, found, wanted)
    good = any(modes.real.any() for modes in found.tracked.modes)
    return Made(headline(found.tracked), (*found.frf.notes, *found.tracked.notes), good)


def do_update(work: Work, report: Progress) -> Made:
    """Fit E, nu and eta at every temperature, and laws through them."""
    from app.stages import update
    from app.stages.update import UpdateRequest
    from app.summaries.update import gains_text, headline, notes

    work.models.wait_for(PLATE, report)
    campaign, mains = work.campaign, work.settings.mains
    request = UpdateRequest(campaign, mains=mains)
    work.plain = update.updated_twin(campaign, mains, report, work.run)
    found = update.compute(request, report, run=work.run, plain=work.plain)
    with held_back():
        update.save(work.run, request, found)
    inputs = campaign.experiment.inputs
    gains = (f"gains: {gains_text(found.updated, inputs)}",) if len(inputs) > 1 else ()
    said = notes(found.updated, found.laws, found.pairing, campaign_typed(work.folder, work.run))
    told = (*gains, *found.frf.notes, *said)
    good = bool(found.updated.settled.all()) and (found.pairing is None or found.pairing.fits)
    return Made(headline(found.updated), told, good)


def do_gap(work: Work, report: Progress) -> Made:
    """Compare the campaign with its twin, and name what the twin lacks."""
    from app.stages import gap
    from app.stages.gap import GapRequest
    from app.summaries.gap import headline

    request = GapRequest(work.campaign, effects=work.effects, mains=work.settings.mains)
    work.models.wait_for(EFFECTS, report)
    started = time.perf_counter()
    found = gap.compute(request, report, run=work.run, plain=work.plain)
    with held_back():
        record = gap.save(work.run, request, found, time.perf_counter() - started)
    return Made(headline(record), (*found.frf.notes, *record["notes"]), record["verdict"] in gap.GOOD)


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
    from app.stages.panel.requests import FocusRequest
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
    from app.stages.panel.inputs import checked_device
    from app.stages.panel.requests import CompensateRequest
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


LINKS: Mapping[Stage, Link] = {
    "import": Link(do_import, import_inputs, no_settings, ("protocol.json",)),
    "identify": Link(
        do_identify,
        campaign_inputs,
        identify_settings,
        ("modes.h5", "modes.csv"),
        reads_campaign=True,
    ),
    "update": Link(
        do_update,
        update_inputs,
        update_settings,
        ("laws.h5",),
        reads_campaign=True,
    ),
    "gap": Link(
        do_gap,
        gap_inputs,
        update_settings,
        ("gap.json", "gap.h5", "twin.toml", "laws-corrected.h5"),
        ("update",),
        reads_campaign=True,
    ),
    "focus": Link(
        do_focus,
        focus_inputs,
        focus_settings,
        ("filters.h5",),
        ("update",),
    ),
    "compensate": Link(
        do_compensate,
        compensate_inputs,
        compensate_settings,
        ("compensation.h5",),
        ("update",),
    ),
    "report": Link(
        do_report,
        report_inputs,
        report_settings,
        ("report.html",),
    ),
}
