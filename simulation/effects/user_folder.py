"""A user's own effects: Python files in a folder, each defining EFFECT."""

import importlib.util
from collections.abc import Container
from pathlib import Path
from types import ModuleType

from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.effects.verification import verify


def load_folder(folder: Path, experiment: Experiment, taken: Container[str] = ()) -> dict[str, Effect]:
    """Run every ``*.py`` of `folder` and return their effects by name, in the order of the files' names.

    Files whose names begin with an underscore are ignored.

    Parameters
    ----------
    experiment : Experiment
        Declaration for which the effects are made and verified.
    taken : container of str
        Names already used in the library.

    Raises
    ------
    ValueError
        With the file and the error: it raises, defines no EFFECT, has an invalid card or a name that is `taken`
        (or another file's), or fails `verify`. Also if `folder` is no folder or contains no effect.
    """
    if not folder.is_dir():
        raise ValueError(f"{folder}: not a folder; a folder of Python files that define EFFECT is wanted")
    loaded: dict[str, Effect] = {}
    origin: dict[str, Path] = {}
    for file in sorted(folder.glob("[!_]*.py")):
        effect, name = _checked(file, experiment)
        if name in taken:
            raise ValueError(f"{file}: its effect is called {name!r}, which the library has already; rename it")
        if name in loaded:
            raise ValueError(f"{file}: its effect is called {name!r}, as that of {origin[name].name}; rename one")
        loaded[name], origin[name] = effect, file
    if not loaded:
        raise ValueError(f"{folder}: holds no *.py file; an effect is a Python file that defines EFFECT")
    return loaded


def _checked(file: Path, experiment: Experiment) -> tuple[Effect, str]:
    """Return the effect of a file and its name."""
    effect = getattr(_run(file), "EFFECT", None)
    if not isinstance(effect, Effect):
        found = "no EFFECT" if effect is None else f"an EFFECT that is a {type(effect).__name__}"
        raise ValueError(f"{file}: defines {found}; EFFECT = Effect(card, apply) is wanted")
    try:
        card = effect.card(experiment)
        wanted = effect.available(experiment)
    except Exception as error:
        raise ValueError(f"{file}: its card cannot be made: {type(error).__name__}: {error}") from error
    if not isinstance(card, EffectCard):
        raise ValueError(f"{file}: card returns a {type(card).__name__}; an EffectCard is wanted")
    if wanted:
        try:
            verify(effect, experiment)
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from error
    return effect, card.name


def _run(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"user_effect_{file.stem}", file)
    if spec is None or spec.loader is None:
        raise ValueError(f"{file}: Python knows no way to import it")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise ValueError(f"{file}: cannot be run: {type(error).__name__}: {error}") from error
    return module
