"""``flexura simulate-daq``: the simulated cards on a port of this computer, for any nidaqmx program."""

import json
import signal
import threading
from pathlib import Path

import click

from app.commands.bad_input import bad_input

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "simulated-rig.toml"


@click.command(name="simulate-daq")
@click.argument("experiment", type=click.Path(path_type=Path), required=False)
@click.option(
    "--port", type=click.IntRange(0, 65_535), default=31_763, show_default=True, help="0 takes any free one."
)
@click.option("--json", "as_json", is_flag=True, help="Print the address as JSON.")
@bad_input
def command(experiment: Path | None, port: int, as_json: bool) -> None:
    """Serve the simulated cards of EXPERIMENT (default: the shipped one) as an NI gRPC Device Server.

    Only this computer can reach it. Any program that uses nidaqmx can: nidaqmx.GrpcSessionOptions with a channel
    to the address printed. Behind the cards hangs the plate of [simulation] at room temperature. Time is virtual:
    it passes when a program waits for samples. Ends with Ctrl-C.
    """
    from app.files.experiment_toml import read_acquired_experiment
    from app.progress import progress
    from app.rig import simulated_rig
    from drivers.ni.simulated.loopback import serving

    file = experiment or EXAMPLE
    declared = read_acquired_experiment(file)
    with progress() as report:
        parts = simulated_rig(declared, file, report)
    ended = threading.Event()

    def end(number: int, frame: object) -> None:
        ended.set()

    before = {number: signal.signal(number, end) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        with serving(parts.server, port) as address:
            channels = ", ".join(parts.server.chassis.surroundings.terminals())
            click.echo(json.dumps({"address": address, "terminals": channels.split(", ")}) if as_json else address)
            click.echo(f"serving {declared.title}: {channels}; Ctrl-C ends it", err=True)
            while not ended.wait(0.5):  # in pieces: on Windows a waiting thread hears no Ctrl-C
                pass
    except OSError as error:
        raise click.ClickException(f"{error}; choose another with --port") from error
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if parts.server.lacking:
        click.echo(f"asked for what is not simulated: {', '.join(sorted(parts.server.lacking))}", err=True)
