"""``flexura import``: a recorded campaign becomes a campaign folder."""

import json
from pathlib import Path

import click

from app.commands.bad_input import bad_input


@click.command(name="import")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path), help="Campaign folder (default: FOLDER-campaign beside FOLDER)."
)
@click.option("--allow-missing", is_flag=True, help="Go on without sweeps that are not there or clipped.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@bad_input
def command(folder: Path, out: Path | None, allow_missing: bool, as_json: bool) -> None:
    """Import FOLDER, a recorded campaign (campaign.toml and NI TDMS files), as a campaign folder.

    Every file is checked against the declaration: channels, lengths, sample rate, units, clipping, silence,
    temperatures. Anything wrong is named, all of it at once, and nothing is written. An import that was killed
    is completed by the same command; importing the same recording again changes nothing.
    """
    from app.files.import_recording import import_recording
    from app.progress import progress
    from drivers.ni.modules import find_module

    with progress() as report:
        imported = import_recording(folder, out, allow_missing, report)
    recording, experiment = imported.recording, imported.recording.campaign.experiment
    if as_json:
        click.echo(
            json.dumps(
                {
                    "campaign": str(imported.folder),
                    "state": imported.state,
                    "title": experiment.title,
                    "sweeps": len(recording.campaign.sweeps),
                    "sensors": [sensor.id for sensor in experiment.sensors],
                    "left_out": [str(problem) for problem in recording.left_out],
                    "missing": [str(place) for place in recording.missing],
                    "inputs": recording.campaign.hashes,
                },
                indent=2,
            )
        )
    for problem in recording.left_out:
        click.echo(f"note: left out {problem}", err=True)
    for place in recording.missing:
        click.echo(f"note: missing {place}", err=True)
    if not find_module(experiment.acquisition.module):
        told = f"note: module {experiment.acquisition.module!r} is unknown: rate and range were not checked"
        click.echo(told, err=True)
    what = {"imported": "imported into", "completed": "completed in", "unchanged": "unchanged: already in"}
    temperatures = [round(sweep.temperature) for sweep in recording.campaign.sweeps]
    click.echo(
        f"{experiment.title}: {len(temperatures)} sweeps, {min(temperatures)} to {max(temperatures)} °C, "
        f"{what[imported.state]} {imported.folder}",
        err=True,
    )
