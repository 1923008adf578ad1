"""``flexura simulate-daq``: server of the simulated cards on a local port, for any nidaqmx program."""

import json
import signal
import threading
from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import EXPERIMENT
from app.commands.output import Output, output_options
from app.files.shipped import shipped

EXAMPLE = shipped("simulated-rig.toml")
EXAMPLES = """\b
Examples:
  flexura simulate-daq
  flexura simulate-daq my-experiment.toml --port 0 --json
"""


@click.command(name="simulate-daq", epilog=EXAMPLES, short_help="Serve simulated NI cards to any nidaqmx program.")
@click.argument("experiment", type=EXPERIMENT, required=False)
@click.option(
    "--port", type=click.IntRange(0, 65_535), default=31_763, show_default=True, help="Port; 0 takes any free one."
)
@output_options("address and terminals")
@bad_input
def command(experiment: Path | None, port: int, output: Output) -> None:
    """Serve the simulated cards of EXPERIMENT (default: the shipped one) as an NI gRPC Device Server.

    Only this computer can reach it. Any program that uses nidaqmx can: nidaqmx.GrpcSessionOptions with a channel
    to the address printed. The plate of [simulation], at room temperature, is connected to the cards. Time is
    virtual: it advances only while a program waits for samples. Ends with Ctrl-C.
    """
    from app.files.campaign_error import CampaignFileError, Problem
    from app.files.declarations.experiment import read_acquired_experiment
    from drivers.ni.wiring import Wiring

    file = experiment or EXAMPLE
    declared = read_acquired_experiment(file)
    if not isinstance(declared.cards, Wiring):
        seen, allowed = repr(declared.cards.kind), "'ni': only these cards have a device server"
        raise CampaignFileError(file.parent, [Problem(file.name, "cards.kind", seen, allowed)])
    from app.rig.simulated_rig import simulated_rig  # slow import: a wrong file is reported before it
    from drivers.ni.simulated.servicer import serving

    with output.progress() as report:
        parts = simulated_rig(declared, file, report)
    server = parts.server
    if server is None:
        raise AssertionError("NI cards are simulated by a server")
    ended = threading.Event()

    def end(number: int, frame: object) -> None:
        ended.set()

    before = {number: signal.signal(number, end) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        with serving(server, port) as address:
            terminals = list(server.chassis.surroundings.terminals())
            line = json.dumps({"address": address, "terminals": terminals}) if output.as_json else address
            click.echo(line)  # in one line, even if quiet: a program waits for it
            output.summary(f"serving {declared.title}: {', '.join(terminals)}; Ctrl-C ends it")
            while not ended.wait(0.5):  # in short waits: on Windows Ctrl-C does not interrupt a waiting thread
                pass
    except OSError as error:
        raise click.ClickException(f"{error}; choose another with --port") from error
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if server.lacking:
        output.note(f"asked for what is not simulated: {', '.join(sorted(server.lacking))}")
