"""``flexura import``: import of a recorded campaign into a campaign folder."""

from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import CAMPAIGN, out_folder
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura import examples/pp-plate --out plate
  flexura import recording --allow-missing --json
  flexura import plate-A1 plate-A2 --out plate
"""


@click.command(name="import", epilog=EXAMPLES, short_help="Turn a recorded campaign into a campaign folder.")
@click.argument("folders", metavar="FOLDER...", type=CAMPAIGN, nargs=-1, required=True)
@click.option("--allow-missing", is_flag=True, help="Continue without sweeps that are missing or clipped.")
@click.option("--actuator", metavar="ID", help="Of several that drove one after the other: take its sweeps.")
@out_folder("Campaign folder (default: FOLDER-campaign beside FOLDER).")
@output_options("the summary")
@bad_input
def command(
    folders: tuple[Path, ...], allow_missing: bool, actuator: str | None, out: Path | None, output: Output
) -> None:
    """Import FOLDER, a recorded campaign (campaign.toml and NI TDMS files), as a campaign folder.

    Every file is checked against the declaration: channels, lengths, sample rate, units, clipping, silence,
    temperatures. All errors are reported at once; then nothing is written, except a picture of a wrong geometry.
    An import that was killed is completed by the same command; importing the same recording again changes nothing,
    or, where more sweeps have come since, takes these in.
    Where several actuators drove the plate one after the other, each gives a campaign of its own: name it with
    --actuator.

    Several FOLDERs are joined to one campaign in --out: campaigns of one plate, recorded, imported or acquired,
    each with actuators of its own. An acquired one may be running or interrupted: its finished sweeps are taken.
    """
    from app.files.campaigns.import_recording import import_joined, import_recording
    from app.stages.comparison.temperature_notes import recorded_notes
    from drivers.ni.modules import find_module

    if len(folders) > 1 and actuator is not None:
        raise click.UsageError("--actuator is for one FOLDER; leave it out")
    if len(folders) > 1 and out is None:
        raise click.UsageError("several FOLDERs are joined into --out; give it")
    with output.progress() as report:
        if len(folders) > 1 and out is not None:
            imported = import_joined(folders, out, allow_missing, report)
        else:
            imported = import_recording(folders[0], out, allow_missing, report, actuator)
    recording, experiment = imported.recording, imported.recording.campaign.experiment
    notes = recorded_notes(recording.campaign)
    output.result(
        lambda: {
            "campaign": str(imported.folder),
            "state": imported.state,
            "title": experiment.title,
            "sweeps": len(recording.campaign.sweeps),
            "sensors": [output.id for output in experiment.outputs],
            "left_out": [str(problem) for problem in recording.left_out],
            "missing": [str(place) for place in recording.missing],
            "notes": list(notes),
            "inputs": recording.campaign.hashes,
        }
    )
    for problem in recording.left_out:
        output.note(f"left out {problem}")
    for place in recording.missing:
        output.note(f"missing {place}")
    for note in notes:
        output.note(note)
    if not find_module(experiment.acquisition.module):
        output.note(f"module {experiment.acquisition.module!r} is unknown: rate and range were not checked")
    what = {
        "imported": "imported into",
        "completed": "completed in",
        "renewed": "with the sweeps that have come since, imported anew into",
        "unchanged": "unchanged: already in",
    }
    temperatures = [round(sweep.temperature) for sweep in recording.campaign.sweeps]
    asked = len(temperatures) + len(recording.missing)
    count = f"{len(temperatures)} of {asked}" if recording.missing else f"{asked}"
    output.summary(
        f"{experiment.title}: {count} sweeps, {min(temperatures)} to {max(temperatures)} °C, "
        f"{what[imported.state]} {imported.folder}"
    )
