"""A described cause as a file for a user's effects folder: ``described/described_FORM.py``."""

from pathlib import Path

from analysis.gap.description.describing import Description, Form
from app.files.atomic import write_text

FOLDER = "described"
PRIOR_WIDTH = 3.0
"""Prior of an amplitude, in its value as described: the next campaign may find another strength."""
PRIOR_OF_PLACE = 0.03
"""Prior of a place, m."""


def described_name(form: Form) -> str:
    """Return the name of the effect and of its file."""
    return f"described_{form.name}"


def write_described_effect(run: Path, description: Description) -> Path:
    """Write the effect's file into a run folder, older ones removed.

    Returns
    -------
    Path
        Of the file; ``flexura gap CAMPAIGN --effects`` takes its folder.
    """
    folder, form = run / FOLDER, description.best
    folder.mkdir(exist_ok=True)
    for older in folder.glob("described_*.py"):
        older.unlink()
    target = folder / f"{described_name(form)}.py"
    write_text(target, _load(form) if form.curve is None else _curve(form))
    return target


HEAD = '''"""{words}, as `flexura gap` described it.

Change it, give it its name, and compare again: flexura gap, with --effects and the folder of this file.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import {state}Circumstances, PlateState
'''

CARD = '''

def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; ranges and sites are about what was found."""
    return EffectCard(
        name="{name}",
        summary="{words}",
        parameters=(
{parameters}        ),
        needs="what the campaign had that showed it",
        separated_by="look there, and change what is found",
        sites=({sites},),
    )
'''

TAIL = """

EFFECT = Effect(card, apply)
"""

LAWS = {
    "mass": ("added mass at a place", '    stiffness, loss = -(omega**2) * values["mass"], 0.0 * omega\n'),
    "spring": ("spring at a place", '    stiffness, loss = values["stiffness"] + 0.0 * omega, 0.0 * omega\n'),
    "dashpot": ("dashpot at a place", '    stiffness, loss = 0.0 * omega, omega * values["damping"]\n'),
    "resonator": (
        "mass on a spring at a place",
        '    square = (2.0 * np.pi * values["resonance"]) ** 2\n'
        '    below, late = square - omega**2, values["loss"] * square\n'
        '    share = values["mass"] * omega**2 / (below**2 + late**2)\n'
        '    stiffness = -share * square * (below + values["loss"] * late)\n'
        '    loss = share * square * values["loss"] * omega**2\n',
    ),
}
"""Words, and dynamic stiffness, of the loads that have a formula."""
AMPLITUDES = {"mass": "mass", "spring": "stiffness", "dashpot": "damping", "resonator": "mass"}


def _load(form: Form) -> str:
    words, law = LAWS[form.name]
    amplitude, lines, shapes = AMPLITUDES[form.name], [], {}
    for one in form.parameters:
        value = float(one.value)
        if one.name == amplitude:
            sigma = abs(value) * PRIOR_WIDTH or 1.0
            lines.append(f'Parameter("{one.name}", "{one.unit}", 0.0, {10.0 * sigma!r}, {sigma!r}),')
            continue
        shapes[one.name] = value
        spread = PRIOR_OF_PLACE if one.name in ("x", "y") else max(abs(value), 1e-3)
        low = value - 2.0 * PRIOR_OF_PLACE if one.name in ("x", "y") else value / 3.0
        high = value + 2.0 * PRIOR_OF_PLACE if one.name in ("x", "y") else value * 3.0
        lines.append(
            f'Parameter("{one.name}", "{one.unit}", {low!r}, {high!r}, {spread!r}, shape=True, typical={value!r}),'
        )
    apply = f'''

def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add its dynamic stiffness to the normal motion of the place."""
    omega = 2.0 * np.pi * circumstances.frequency
{law}    one = Attached(values["x"], values["y"], stiffness, loss)
    return state.with_(attached=(*state.attached, one))
'''
    return _whole(form, words, lines, repr(shapes), apply, "Attached, ")


def _curve(form: Form) -> str:
    curve = form.curve
    if curve is None:
        raise ValueError(f"{form.name} has a formula, no curve")
    table = "".join(
        f"{name} = np.array({[round(float(v), 9) for v in row]!r})\n"
        for name, row in (("FREQUENCY", curve.frequency), ("A", curve.value[0]), ("B", curve.value[1]))
    )
    lines = ['Parameter("share", "1", 0.0, 5.0, 1.0),']
    shapes: dict[str, float] = {}
    if form.place is not None:
        for one in form.place:
            value = float(one.value)
            shapes[one.name] = value
            lines.append(
                f'Parameter("{one.name}", "m", {value - 2.0 * PRIOR_OF_PLACE!r}, '
                f"{value + 2.0 * PRIOR_OF_PLACE!r}, {PRIOR_OF_PLACE!r}, shape=True, typical={value!r}),"
            )
    words, body, state = {
        "load": (
            "load of this dynamic stiffness at a place",
            '    one = Attached(values["x"], values["y"], -(omega**2) * a, omega**2 * b)\n'
            "    return state.with_(attached=(*state.attached, one))\n",
            "Attached, ",
        ),
        "modulus": (
            "modulus and loss factor over frequency",
            "    stiffer = 1.0 + a\n"
            "    return state.with_(storage=state.storage * stiffer, loss=state.loss * stiffer * (1.0 + b))\n",
            "",
        ),
        "gain": (
            "gain over frequency",
            "    return state.with_(log_gain=state.log_gain + a, phase=state.phase + b)\n",
            "",
        ),
    }[form.name]
    frequency = "    omega = 2.0 * np.pi * circumstances.frequency\n" if form.name == "load" else ""
    apply = f'''

# Hz, and the two curves there, with straight lines over log f between. A formula may take their place.
{table}

def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Apply a share of what was found: 1 is all of it."""
{frequency}    lines = np.log(circumstances.frequency)
    a = values["share"] * np.interp(lines, np.log(FREQUENCY), A)
    b = values["share"] * np.interp(lines, np.log(FREQUENCY), B)
{body}'''
    return _whole(form, words, lines, repr(shapes), apply, state)


def _whole(form: Form, words: str, lines: list[str], sites: str, apply: str, state: str) -> str:
    parameters = "".join(f"            {line}\n" for line in lines)
    card = CARD.format(name=described_name(form), words=words, parameters=parameters, sites=sites)
    head = HEAD.format(words=words[0].upper() + words[1:], state=state)
    return head + card + apply.rstrip("\n") + "\n" + TAIL
