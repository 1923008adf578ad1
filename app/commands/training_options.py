"""Options of the training of networks."""

import functools
from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeVar, cast

import click
from click.core import ParameterSource

from analysis.compensation.settings import Training

Verb = TypeVar("Verb", bound=Callable[..., object])

PAPER_CHOICES = ("feed", "scale", "start", "split", "design")
"""Options that --as-paper sets."""

TRAINING_OPTIONS = (
    click.option(
        "--nodes",
        type=click.IntRange(1, 100),
        default=Training.nodes,
        show_default=True,
        help="Hidden nodes; fewer where temperatures placed or measured are few.",
    ),
    click.option(
        "--restarts", type=click.IntRange(1, 100), default=1, show_default=True, help="Trainings per actuator."
    ),
    click.option(
        "--feed",
        type=click.Choice(("rigidity", "temperature")),
        default="rigidity",
        show_default=True,
        help="What the networks are fed: log √D of the plate at the temperature, "
        "or the temperature as in the paper.",
    ),
    click.option(
        "--scale",
        type=click.Choice(("global", "tap")),
        default="global",
        show_default=True,
        help="One scale for an actuator's taps, or each tap stretched to -1..1 as MATLAB does.",
    ),
    click.option(
        "--start",
        type=click.Choice(("warm", "random")),
        default="warm",
        show_default=True,
        help="Output layer from a ridge fit, or random as in MATLAB.",
    ),
    click.option(
        "--split",
        type=click.Choice(("none", "matlab")),
        default="none",
        show_default=True,
        help="Train on all temperatures, or leave a random 15 % out as MATLAB does.",
    ),
    click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of all that is random."),
)


def training_options(verb: Verb) -> Verb:
    """Add the options of the training to a verb, which receives them as one mapping, `training`."""

    @functools.wraps(verb)
    def training(*args: Any, **options: Any) -> object:
        given = {one.name: options.pop(one.name) for one in fields(Training) if one.name in options}
        return verb(*args, training=given, **options)

    for option in reversed(TRAINING_OPTIONS):
        training = option(training)
    return cast("Verb", training)


def training_of(choices: dict[str, Any], as_paper: bool) -> Training:
    """Return the training settings; UsageError for an option given together with --as-paper."""
    named = [option for option in PAPER_CHOICES if typed(option)]
    if as_paper and named:
        raise click.UsageError(f"--as-paper sets --{named[0]} itself: leave one of them out")
    return Training(**choices).as_paper() if as_paper else Training(**choices)


def typed(option: str) -> bool:
    """Whether an option was given, not left at its default."""
    return click.get_current_context().get_parameter_source(option) is not ParameterSource.DEFAULT
