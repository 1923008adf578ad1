"""``flexura check-instrument``: test of an instrument's driver in normal use and under faults."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import EXPERIMENT
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from app.files.declarations.instruments import DeclaredInstruments
    from drivers.checks.trial import CheckVerdict
    from drivers.rig.end_requests import EndRequests

COLOURS = {"passed": "green", "FAILED": "red", "not checked": "yellow"}

EXAMPLES = """\b
Examples:
  flexura check-instrument watlow-f4t
  flexura check-instrument my-experiment.toml
  flexura check-instrument my-experiment.toml --really
"""


@click.command(
    name="check-instrument", epilog=EXAMPLES, short_help="Put an instrument's driver through its faults."
)
@click.argument("instrument", metavar="EXPERIMENT.toml|KIND")
@click.option("--really", is_flag=True, help="At the hardware itself; the oven stays within 2 K of where it is.")
@output_options("the verdicts")
@bad_input
def command(instrument: str, really: bool, output: Output) -> None:
    """Check the drivers of the cards, oven and thermometer that EXPERIMENT.toml declares, or of a KIND of oven.

    Silence, noise, late and stale answers, refusals, a pulled cable, commands not accepted, Ctrl-C: each must end
    in a correct temperature or in an error that says what to do, and the oven must rest after each. Kinds of
    installed packages are checked like our own. Of the file, only [cards], [oven] and [thermometer] are read.

    No hardware is touched: the driver uses the simulated instrument of its kind. With --really it uses the
    instrument itself, over the port declared: faults are made on this computer's side of it, and the oven ramps
    by 1 K and comes to rest, some twenty times in minutes; cards play a hundredth of output_range. Nothing else
    may use them meanwhile.

    Exit status 1 where a check failed; 3 where oven or drive are not known to be at rest, or another process of
    this computer uses them: then nothing is sent to them.
    """
    if instrument.endswith(".toml"):
        EXPERIMENT.convert(instrument, None, None)

    from app.files.declarations.instruments import declared_instruments
    from app.terminal.campaign import NOT_AT_REST
    from drivers.rig.end_requests import EndRequests
    from drivers.rig.occupancy import RigInUse, occupied

    declared = declared_instruments(instrument)
    found: dict[str, list[CheckVerdict]] = {}
    unsafe: tuple[str, ...] = ()
    try:
        with occupied(declared.places if really else (), "flexura check-instrument"), EndRequests() as requests:
            try:
                for name, run in _trials(declared, really):
                    if really:
                        output.note(f"{name}: the instrument itself is used now")
                    found[name] = _run(run, output, name, requests)
            finally:
                if really:
                    unsafe = _rest(declared)
                    _say(unsafe, output)
    except RigInUse as error:
        unsafe = (str(error),)
        _say(unsafe, output)
    rows = [{"instrument": name, **vars(one)} for name, verdicts in found.items() for one in verdicts]
    failed = [f"{row['name']} ({row['instrument']})" for row in rows if row["result"] == "FAILED"]
    passed = not (failed or unsafe)
    output.result(lambda: {"passed": passed, "really": really, "checks": rows, "unsafe": list(unsafe)})
    if unsafe:
        raise click.exceptions.Exit(NOT_AT_REST)
    if failed:
        output.failure(f"{len(failed)} of {len(rows)} checks failed: {', '.join(failed)}")
        raise click.exceptions.Exit(1)
    unchecked = sum(row["result"] == "not checked" for row in rows)
    rest = f", {unchecked} could not be made" if unchecked else ""
    output.summary(f"{len(rows) - unchecked} of {len(rows)} checks passed{rest}")


def _trials(
    declared: "DeclaredInstruments", really: bool
) -> "Iterator[tuple[str, Callable[[], Iterator[CheckVerdict]]]]":
    """Yield the name of each instrument, and the function that runs its checks."""
    from drivers.checks.cards import check_cards, check_real_cards
    from drivers.checks.instruments import check_oven, check_real_oven, check_thermometer

    cards, oven, thermometer = declared.cards, declared.oven, declared.thermometer
    if cards is not None:
        yield f"cards {cards.kind}", lambda: check_real_cards(cards) if really else check_cards(cards)
    if oven is not None:
        yield f"oven {oven.kind}", lambda: check_real_oven(oven) if really else check_oven(oven)
    if thermometer is not None:
        yield f"thermometer {thermometer.kind}", lambda: check_thermometer(thermometer, real=really)


def _run(
    run: "Callable[[], Iterator[CheckVerdict]]", output: Output, name: str, requests: "EndRequests"
) -> "list[CheckVerdict]":
    """Run the checks of one instrument and show each when done; Ctrl-C takes effect between two checks."""
    from drivers.checks.instruments import NoCounterpart
    from drivers.checks.trial import CheckVerdict
    from drivers.ovens.error import OvenError

    shown = not (output.quiet or output.as_json)
    if shown:
        click.echo(name)
    found: list[CheckVerdict] = []
    try:
        for verdict in _until_asked_to_end(run, requests):
            found.append(verdict)
            if shown:
                show([verdict])
    except NoCounterpart:
        said = "it brings no simulated counterpart: connect the instrument, and add --really"
        found.append(CheckVerdict("all checks", "a campaign relies on each", "not checked", said))
        if shown:
            show(found)
    except Exception as error:  # noqa: BLE001 (a driver from elsewhere may raise anything)
        said = str(error) if isinstance(error, OvenError) else f"{type(error).__name__}: {error}"
        found.append(CheckVerdict("answers at all", "nothing can be checked otherwise", "FAILED", said))
        if shown:
            show(found[-1:])
    return found


def _until_asked_to_end(
    run: "Callable[[], Iterator[CheckVerdict]]", requests: "EndRequests"
) -> "Iterator[CheckVerdict]":
    """Yield the verdicts; after a request to end, the last one reports the checks left out."""
    from drivers.checks.trial import CheckVerdict

    checks = run()
    while requests.arrived is None:
        verdict = next(checks, None)
        if verdict is None:
            return
        yield verdict
    why = f"stopped by {requests.arrived} before the others"
    yield CheckVerdict("the other checks", "all of them count", "FAILED", why)


def _say(unsafe: tuple[str, ...], output: Output) -> None:
    from app.terminal.campaign import not_at_rest

    if unsafe:
        output.failure(not_at_rest(unsafe).lstrip())


def _rest(declared: "DeclaredInstruments") -> tuple[str, ...]:
    """Bring oven and drive to rest once more; return what could not be verified."""
    from drivers.clock import SystemClock
    from drivers.rig.session import rest_drive, rest_oven

    oven, cards, clock = declared.oven, declared.cards, SystemClock()
    outcomes = (
        None if oven is None else rest_oven(lambda: oven.open(clock), clock),
        None if cards is None else rest_drive(cards.open),
    )
    return tuple(what for what in outcomes if what is not None)


def show(verdicts: "Sequence[CheckVerdict]") -> None:
    """Print the result of each check, and why it matters."""
    for one in verdicts:
        result = click.style(f"{one.result:<11}", fg=COLOURS[one.result])
        click.echo(f"  {result} {one.name:<34} {one.why}")
        if one.said:
            click.echo(f"              {one.said}")
