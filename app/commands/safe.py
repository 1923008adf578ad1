"""``flexura safe``: bring a rig to rest, from whatever state it was left in."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import EXPERIMENT, which_rig
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.files.declarations.experiment import RigKind

EXAMPLES = """\b
Examples:
  flexura safe my-experiment.toml
"""


@click.command(name="safe", epilog=EXAMPLES, short_help="Bring the rig to rest, from any state.")
@click.argument("experiment", type=EXPERIMENT)
@which_rig
@output_options("how the rig was left")
@bad_input
def command(experiment: Path, rig: "RigKind | None", output: Output) -> None:
    """Bring the oven of EXPERIMENT to rest, then its drive to 0 V; no campaign is needed or touched.

    For use after a crash, a power cut or another program. If a campaign is running on the rig, its process is
    named and nothing is done: stop it (Ctrl-C, or flexura view), which brings the rig to rest.

    Exit status 3 where something could not be verified to be at rest (NOT AT REST: go there and switch it off).
    """
    from app.files.declarations.experiment import read_declared_experiment
    from app.files.declarations.hammer_experiment import declares_hammer_test, read_hammer_experiment
    from app.rig.assembly import rig_places, still_oven, still_rig
    from app.terminal.campaign import NOT_AT_REST, not_at_rest
    from drivers.rig.end_requests import EndRequests
    from drivers.rig.occupancy import RigInUse, occupied
    from drivers.rig.session import bring_to_rest

    if declares_hammer_test(experiment):
        of_hits = read_hammer_experiment(experiment)
        kind = rig or of_hits.rig
        oven, places = still_oven(of_hits, kind, experiment), rig_places(of_hits, kind)
        if oven is None:
            output.result(lambda: {"rig": kind, "unsafe": []})
            output.summary("a hammer test without an oven: nothing is heated or driven")
            return
    else:
        declared = read_declared_experiment(experiment)
        kind = rig or declared.rig
        oven, places = still_rig(declared, kind, experiment), rig_places(declared, kind)
    with EndRequests():  # must not be interrupted
        try:
            with occupied(places, "flexura safe"):
                unsafe = bring_to_rest(oven)
        except RigInUse as error:
            unsafe = (str(error),)
    output.result(lambda: {"rig": kind, "unsafe": list(unsafe)})
    if unsafe:
        output.failure(not_at_rest(unsafe).lstrip())
        raise click.exceptions.Exit(NOT_AT_REST)
    output.summary("the oven is at rest and the drive at 0 V")
