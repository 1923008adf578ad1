"""``flexura doctor``: check of this computer and its instruments, with advice."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import EXPERIMENT, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from drivers.rig.survey import Finding

COLOURS = {"good": "green", "note": "yellow", "bad": "red"}


EXAMPLES = """\b
Examples:
  flexura doctor
  flexura doctor my-experiment.toml --out /data/campaigns
"""


@click.command(name="doctor", epilog=EXAMPLES, short_help="Check this computer and the rig, and say what to do.")
@click.argument("experiment", type=EXPERIMENT, required=False)
@out_folder("Folder the campaign would be written to (default: that of EXPERIMENT).")
@output_options("the findings")
@bad_input
def command(experiment: Path | None, out: Path | None, output: Output) -> None:
    """Check driver, cards, serial ports, oven, disk and clock; with EXPERIMENT, those that it names.

    EXPERIMENT may be a campaign of sweeps or a hammer test.

    Nothing is set or switched: cards are listed, and the oven's temperature is read. Exit status 1 where something
    required is missing.
    """
    from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
    from app.files.declarations.hammer_experiment import (
        HammerExperiment,
        declares_hammer_test,
        read_hammer_experiment,
    )

    declared: AcquiredExperiment | HammerExperiment | None = None
    if experiment is not None:
        read = read_hammer_experiment if declares_hammer_test(experiment) else read_acquired_experiment
        declared = read(experiment)
        if isinstance(declared, AcquiredExperiment) and declared.rig == "simulated":
            from app.rig.simulated_rig import silent_rig

            silent_rig(declared, experiment)  # refuses wiring and modules, as acquire does

    from app.rig.doctor import examine
    from drivers.rig.survey import FindingState

    folder = (out or (experiment.parent if experiment is not None else Path())).resolve()
    findings = list(examine(declared, folder))
    bad = [finding for finding in findings if finding.state is FindingState.BAD]
    rows = [
        {"what": one.what, "state": str(one.state), "seen": one.seen, "next_step": one.next_step}
        for one in findings
    ]
    output.result(lambda: {"ready": not bad, "findings": rows}, lambda: show(findings))
    if bad:
        output.failure(f"not ready: {', '.join(one.what for one in bad)}")
        raise click.exceptions.Exit(1)
    output.summary(ready(experiment, findings))


def ready(experiment: Path | None, findings: "Sequence[Finding]") -> str:
    """Describe what this computer is ready for; without an experiment nothing is required."""
    from drivers.rig.survey import FindingState

    if experiment is not None:
        return f"ready for {experiment}"
    of_rig = [one for one in findings if one.what.startswith(("NI ", "serial port"))]
    missing = [one.what for one in of_rig if one.state is not FindingState.GOOD]
    if missing:
        return f"ready for analysis and the simulated rig; for a real rig is missing: {', '.join(missing)}"
    return "ready for analysis and the simulated rig; whether a real one fits: flexura doctor EXPERIMENT.toml"


def show(findings: "Sequence[Finding]") -> None:
    """Print a line for each finding, followed by advice for those that are not good."""
    for one in findings:
        seen = f": {one.seen}" if one.seen else ""
        click.echo(f"{click.style(f'{one.state:<5}', fg=COLOURS[one.state])}{one.what}{seen}")
        if one.next_step:
            click.echo(f"       {one.next_step}")
