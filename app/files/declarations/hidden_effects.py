"""``[simulation.effects]`` of an experiment held against the cards of the library."""

from collections.abc import Iterator, Mapping

import numpy as np

from analysis.effect_card import EffectCard, Parameter, Values
from analysis.experiment import Experiment
from app.files.allowed_values import nearest
from app.files.campaign_error import Problem
from simulation.effects.library import LIBRARY, library

TABLE = "simulation.effects"


def effect_problems(file: str, experiment: Experiment, effects: Mapping[str, Values]) -> list[Problem]:
    """Everything in `effects` that the library does not know, or that this experiment cannot hold.

    Parameters
    ----------
    file : str
        The experiment's, for messages.
    effects : mapping
        Parameters' values by effect.

    Returns
    -------
    list of Problem
        Empty where nothing is wrong.
    """
    problems: list[Problem] = []
    for name, values in effects.items():
        key = f"{TABLE}.{name}"
        effect = LIBRARY.get(name)
        if effect is None:
            known = "the effects " + ", ".join(LIBRARY)
            problems.append(Problem(file, key, "unknown effect", known, _nearest(name, LIBRARY)))
        elif not effect.available(experiment):
            held = "the effects " + ", ".join(library(experiment))
            seen = "an effect that this plate cannot have as it is declared"
            problems.append(Problem(file, key, seen, held, f"declare {effect.wants}"))
        else:
            problems += _of_one(file, key, effect.card(experiment), values)
            if {"x", "y"} <= set(values) and not experiment.plate.contains(np.array([[values["x"], values["y"]]]))[
                0
            ]:
                seen = f"x {values['x']:g}, y {values['y']:g} m, off the plate or in a hole"
                problems.append(Problem(file, key, seen, "a place on the plate"))
    return problems


def with_shapes(cards: Mapping[str, EffectCard], effects: Mapping[str, Values]) -> dict[str, Values]:
    """Return `effects` with the shapes that were left out at their cards' typical values."""
    return {name: {**cards[name].zero(), **values} for name, values in effects.items()}


def _of_one(file: str, key: str, card: EffectCard, values: Values) -> Iterator[Problem]:
    parameters = {parameter.name: parameter for parameter in card.parameters}
    for name, value in values.items():
        parameter = parameters.get(name)
        if parameter is None:
            known = "the parameters " + ", ".join(map(_range, card.parameters))
            yield Problem(file, f"{key}.{name}", "unknown parameter", known, _nearest(name, parameters))
        elif not parameter.low <= value <= parameter.high:
            yield Problem(file, f"{key}.{name}", f"{value:g}", _range(parameter))
    for parameter in card.amplitudes:
        if parameter.name not in values:
            yield Problem(
                file, f"{key}.{parameter.name}", "nothing", _range(parameter), "the parameter is missing"
            )


def _range(parameter: Parameter) -> str:
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    return f"{parameter.name} from {parameter.low:g} to {parameter.high:g}{unit}"


def _nearest(name: str, known: Mapping[str, object]) -> str:
    return nearest(name, known) or "remove it"
