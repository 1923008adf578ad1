"""``flexura doctor``: what works on this computer, and what to do about what does not."""

import json
from pathlib import Path

import click

from app.commands.bad_input import bad_input

COLOURS = {"good": "green", "note": "yellow", "bad": "red"}


@click.command(name="doctor")
@click.argument("experiment", type=click.Path(path_type=Path), required=False)
@click.option("--out", type=click.Path(path_type=Path), help="Folder the campaign would be written to.")
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
@bad_input
def command(experiment: Path | None, out: Path | None, as_json: bool) -> None:
    """Look at driver, cards, serial ports, oven, disk and clock; with EXPERIMENT, at those it names.

    Nothing is set or switched: cards are listed, and the oven is asked for its temperature. Exit status 1 where
    something that is needed is not there.
    """
    from app.doctor import examine
    from app.files.experiment_toml import read_acquired_experiment
    from drivers.rig.survey import State

    declared = read_acquired_experiment(experiment) if experiment is not None else None
    folder = (out or (experiment.parent if experiment is not None else Path())).resolve()
    findings = list(examine(declared, folder))
    bad = [finding for finding in findings if finding.state is State.BAD]
    if as_json:
        rows = [
            {"what": one.what, "state": str(one.state), "seen": one.seen, "next_step": one.next_step}
            for one in findings
        ]
        click.echo(json.dumps({"ready": not bad, "findings": rows}, indent=1))
    else:
        for one in findings:
            click.echo(f"{click.style(f'{one.state:<5}', fg=COLOURS[one.state])}{one.what}: {one.seen}")
            if one.next_step:
                click.echo(f"       {one.next_step}")
    click.echo("ready" if not bad else f"not ready: {', '.join(one.what for one in bad)}", err=True)
    if bad:
        raise click.exceptions.Exit(1)
