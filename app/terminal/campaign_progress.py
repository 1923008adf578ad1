"""A running campaign on the error stream: a bar with the time left, or plain lines where it is no terminal."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from app.summaries.numbers import duration
from drivers.rig.campaign import Moment, Observer


@contextmanager
def campaign_screen(clock_is_virtual: bool, *, shown: bool = True) -> Iterator[Observer]:
    """Yield an observer that shows every moment of a campaign.

    Parameters
    ----------
    clock_is_virtual : bool
        The time left is that of a simulated rig, which passes faster than ours.
    shown : bool
        False: an observer that prints nothing.
    """
    console = Console(stderr=True, quiet=not shown)
    columns = (
        TextColumn("{task.description:<16}"),
        TextColumn("{task.fields[temperature]:>6.2f} °C"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[left]}"),
    )
    suffix = " of simulated time" if clock_is_virtual else ""
    with Progress(*columns, console=console, disable=not (shown and console.is_terminal)) as bars:
        bar = bars.add_task("opening", total=None, temperature=0.0, left="")
        last = -1

        def show(moment: Moment) -> None:
            nonlocal last
            left = f"{duration(moment.seconds_left)} left{suffix}"
            bars.update(
                bar,
                description=moment.stage,
                completed=moment.done,
                total=moment.total,
                temperature=moment.temperature,
                left=left,
            )
            if not console.is_terminal and moment.done != last:
                last = moment.done
                now = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M:%S %z")  # this goes into a log
                console.print(
                    f"{now} {moment.done} of {moment.total} sweeps, {moment.stage}, {moment.temperature:.2f} °C, "
                    f"{left}",
                    soft_wrap=True,
                )

        yield show
