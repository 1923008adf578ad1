"""Flexura's packages are imported from beside this one, whatever else has their names.

`analysis`, `app`, `drivers` and `simulation` are usual names: the folder of a script comes first in ``sys.path``,
and may hold a package called ``app``. A finder at the front of ``sys.meta_path`` answers for these four names
before ``sys.path`` is searched. Where one of them has been imported from elsewhere already, both cannot be used in
one process, and importing ``flexura`` is refused.
"""

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType

NAMES = ("analysis", "app", "drivers", "simulation")
ROOT = Path(__file__).resolve().parents[1]
"""Where our packages lie: the project, or the environment's site-packages."""


class OwnPackages(MetaPathFinder):
    """Finds our packages beside ``flexura``."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find one of our packages or modules; None for all other names.

        Parameters
        ----------
        fullname : str
            Dotted name of the module.
        path : sequence of str or None
            Folders of the package it is in; None for a name without dot.
        target : ModuleType or None
            Not used.

        Raises
        ------
        ModuleNotFoundError
            For a module that we lack while a package of the same name on ``sys.path`` may have it.
        """
        name = fullname.partition(".")[0]
        if name not in NAMES:
            return None
        found = PathFinder.find_spec(fullname, [str(ROOT)] if path is None else path, target)
        if found is None and path is not None:
            other = PathFinder.find_spec(name)
            where = other and elsewhere([*(other.submodule_search_locations or ()), other.origin], name)
            if where:
                raise ModuleNotFoundError(
                    f"No module named {fullname!r}: {name!r} is Flexura's package since flexura was imported, not "
                    f"{where}. Rename that one, or use it in a process without flexura",
                    name=fullname,
                )
        return found


def claim_names() -> None:
    """Have our packages found from now on; ImportError where a foreign one of the same name is imported."""
    for name in NAMES:
        module = sys.modules.get(name)
        if module is None:
            continue
        where = elsewhere([*getattr(module, "__path__", ()), getattr(module, "__file__", None)], name)
        if where:
            raise ImportError(
                f"flexura needs its own package {name!r} in {ROOT}, but this process has imported {name!r} from "
                f"{where}. One process cannot hold both: rename that one, or use it in another process"
            )
    if not any(isinstance(finder, OwnPackages) for finder in sys.meta_path):
        sys.meta_path[:0] = [OwnPackages()]


def put_first() -> None:
    """Put our folder before the first of ``sys.path`` that holds one of our names.

    Processes that Python starts itself (``multiprocessing`` with ``spawn``) get ``sys.path``, but no finder. In
    the program nothing else is imported by these names, so that changing ``sys.path`` does no harm there.
    """
    for place, entry in enumerate(sys.path):
        if any(PathFinder.find_spec(name, [entry]) for name in NAMES):
            if Path(entry).resolve() != ROOT:
                sys.path.insert(place, str(ROOT))
            return


def elsewhere(places: Sequence[str | None], name: str) -> str:
    """Say where a module of one of our names lies, given its folders and file; empty where it is ours."""
    known = [place for place in places if place]
    if any(Path(place).resolve() == ROOT / name for place in known):
        return ""
    return known[0] if known else "no file"
