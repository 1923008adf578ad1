"""Stages on the measured plate as a run does them: import, identify, update, gap."""

import time
from typing import Any

from analysis.progress import Progress
from app.chain.input_files import campaign_hashes, effect_hashes
from app.chain.models_ahead import EFFECTS, PLATE
from app.chain.work import Made, Work
from app.files.results.run_record import hashed
from app.terminal.end_signals import held_back


def no_settings(_: Work) -> dict[str, Any]:
    """Nothing is chosen."""
    return {}


def import_inputs(work: Work) -> dict[str, str]:
    """Files of the recording."""
    return campaign_hashes(work.request.campaign)


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
    from app.stages.temperature_notes import recorded_notes

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
    from app.stages.comparison_request import UpdateRequest
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
    told = (*gains, *found.frf.notes, *notes(found.updated, found.laws, found.pairing))
    good = bool(found.updated.settled.all()) and (found.pairing is None or found.pairing.fits)
    return Made(headline(found.updated), told, good)


def do_gap(work: Work, report: Progress) -> Made:
    """Compare the campaign with its twin, and name what the twin lacks."""
    from app.stages import gap
    from app.stages.comparison_request import GapRequest
    from app.summaries.gap import headline

    request = GapRequest(work.campaign, effects=work.effects, mains=work.settings.mains)
    work.models.wait_for(EFFECTS, report)
    started = time.perf_counter()
    found = gap.compute(request, report, run=work.run, plain=work.plain)
    with held_back():
        record = gap.save(work.run, request, found, time.perf_counter() - started)
    return Made(headline(record), (*found.frf.notes, *record["notes"]), record["verdict"] in gap.GOOD)
