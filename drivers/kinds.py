"""Kinds of instruments: our own, and those that installed packages bring through Python's entry points."""

import difflib
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, distributions
from typing import Generic, TypeVar

from analysis.declaration.strict import Declared

Settings = TypeVar("Settings", bound=Declared)


class KindError(ValueError):
    """A kind that no package provides, or whose package is broken.

    Attributes
    ----------
    seen, allowed, remedy : str
        What was asked for, what there is, what to do.
    """

    def __init__(self, seen: str, allowed: str, remedy: str) -> None:
        self.seen, self.allowed, self.remedy = seen, allowed, remedy
        super().__init__(f"{seen}; allowed: {allowed}; {remedy}")


@dataclass(frozen=True)
class Brought:
    """One kind, and who brings it.

    Attributes
    ----------
    package : str
        Name of the distribution; ``flexura`` for our own.
    entry : EntryPoint
    """

    package: str
    entry: EntryPoint


class Kinds(Generic[Settings]):
    """The kinds of one sort of instrument, each a class of settings that can open what it declares.

    Our own stand in a table, not in the metadata of the installation: they are there in a source tree that was
    never installed, and no other package can take their names. Nothing of a kind is imported before it is asked
    for, so a broken package hurts only those who name its kind.

    Parameters
    ----------
    group : str
        Of the entry points: ``flexura.ovens``.
    base : type
        What the class of every kind derives from.
    ours : mapping of str to str
        Kind -> ``module:class``.
    """

    def __init__(self, group: str, base: type[Settings], ours: Mapping[str, str]) -> None:
        self.group = group
        self._base = base
        self._ours = {name: Brought("flexura", EntryPoint(name, value, group)) for name, value in ours.items()}

    def all(self) -> dict[str, tuple[Brought, ...]]:
        """Return who brings each kind: our own first, then those of installed packages."""
        found: dict[str, dict[str, Brought]] = {name: {"": ours} for name, ours in self._ours.items()}
        for distribution in distributions():
            try:
                entries = [entry for entry in distribution.entry_points if entry.group == self.group]
                brought = [Brought(distribution.name, entry) for entry in entries]
            except Exception:  # noqa: BLE001, S112 (a package with damaged metadata provides nothing and must not affect the others)
                continue
            for one in brought:
                if one.entry.name not in self._ours:  # of a package twice on the path, Python takes the first
                    found.setdefault(one.entry.name, {}).setdefault(one.package.lower(), one)
        return {name: tuple(by.values()) for name, by in found.items()}

    def find(self, name: str) -> type[Settings]:
        """Return the class of a kind.

        Raises
        ------
        KindError
            If no package provides it, two packages do, or its package cannot be loaded.
        """
        there = {name: (self._ours[name],)} if name in self._ours else self.all()
        if name not in there:
            close = difflib.get_close_matches(name, there, 1)
            hint = f"did you mean {close[0]}? " if close else ""
            raise KindError(
                repr(name),
                " or ".join(map(repr, there)) or "none: no package brings any",
                f"{hint}another kind is brought by a package that registers it as an entry point of {self.group}: "
                f"install that with pip into {sys.prefix}",
            )
        if len(there[name]) > 1:
            packages = " and ".join(one.package for one in there[name])
            raise KindError(
                f"{name!r}, brought by {packages}", "one package for each kind", "uninstall the others"
            )
        return self._loaded(name, there[name][0])

    def _loaded(self, name: str, brought: Brought) -> type[Settings]:
        remedy = f"repair, update or remove the package {brought.package} (pip show {brought.package})"
        try:
            found = brought.entry.load()
        except (Exception, SystemExit) as error:
            message = " ".join(f"{type(error).__name__}: {error}".split())
            seen = f"{name!r}, whose {brought.entry.value} cannot be loaded ({message[:200]})"
            raise KindError(seen, "a kind whose package works", remedy) from error
        if not (isinstance(found, type) and issubclass(found, self._base)):
            seen = f"{name!r}, whose {brought.entry.value} is {found!r:.80}"
            base = f"{self._base.__module__}.{self._base.__qualname__}"
            raise KindError(seen, f"a class derived from {base}", remedy)
        return found
