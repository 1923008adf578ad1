"""Digest of the code that runs, so that machines which share work can be seen to run the same.

The version alone does not tell: of a checkout it stays the same while files change.
"""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from app.files.run_record import versions

PACKAGES_OF_OURS = ("analysis", "app", "drivers", "flexura", "simulation")
CARRIES = {".py", ".in", ".css", ".js", ".html"}
"""Endings of what decides how Flexura works: modules, and the templates beside them."""


@cache
def code_digest() -> str:
    """SHA-256 of all modules of Flexura as they lie on this machine's disk, and of their names, once a process."""
    found = hashlib.sha256()
    for package in PACKAGES_OF_OURS:
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            raise ImportError(f"{package}: not installed beside the others")
        root = Path(spec.origin).parent
        for path in sorted(root.rglob("*"), key=lambda one: one.relative_to(root).as_posix()):
            if path.suffix in CARRIES and path.is_file():
                name = f"{package}/{path.relative_to(root).as_posix()}"
                found.update(f"{name}\0{path.stat().st_size}\0".encode())
                found.update(path.read_bytes())
    return found.hexdigest()


def running() -> dict[str, str]:
    """Return what runs here, by name: the digest of Flexura's code, the versions of Python and of libraries."""
    return dict(_running())


@cache
def _running() -> dict[str, str]:
    """Find it once a process: every task of a cluster asks."""
    known = versions()
    libraries = {name: str(one) for name, one in known["packages"].items()}
    return {"flexura": known["flexura"], "code": code_digest(), "python": known["python"], **libraries}


def unlike(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """Say in which parts two machines run something else; empty where they do not."""
    names = [name for name in (*ours, *theirs) if ours.get(name) != theirs.get(name)]
    told = []
    for name in dict.fromkeys(names):
        seen, wanted = (one.get(name, "none")[:12] for one in (theirs, ours))
        told.append(f"{name} {seen} (here {wanted})")
    return ", ".join(told)
