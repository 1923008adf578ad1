"""Make the environment once, then run Flexura in it.

    python3 start.py demo          Windows: py start.py demo
    python3 start.py tests [...]   the tests, on up to four cores; further words go to pytest
    python3 start.py docs [...]    the documentation as a site, into site/; further words go to Sphinx
    python3 start.py VERB ...      any other word goes to flexura
    python3 start.py --lean VERB ...   the same without torch, which only --device needs: half the disk

Needs nothing but Python 3.11 or newer with pip and venv. Everything is installed into
``.venv`` beside this file, pinned by ``constraints.txt``; a stamp holding a digest of the pins says
that the installation finished, so a killed one is made again and a changed pin rebuilds it. What only ``tests``
or ``docs`` need is installed when they are first asked for; after that, no command needs the network.
"""

from __future__ import annotations  # an older Python must get as far as the sentence that refuses it

import configparser
import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
ENVIRONMENT = Path(os.environ.get("FLEXURA_VENV", ROOT / ".venv")).absolute()
PYTHON = ENVIRONMENT / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
STAMP = ENVIRONMENT / "installed-pins.sha256"
EXTRAS = {"tests": "dev", "docs": "docs"}
"""What else is installed for a word, when it is first asked for."""
EVERYBODY = ("audio", "drawings", "meshes", "onnx")
"""Extras that are installed for every word."""
LEAN = "--lean"
LEAN_STAMP = ENVIRONMENT / "installed-lean.sha256"
HEAVY = ("torch",)
"""What `LEAN` leaves out: half of the environment, for the networks' training on a GPU."""
EXTRA_STAMPS = {word: ENVIRONMENT / f"installed-{word}.sha256" for word in EXTRAS}
TORCH_CPU_INDEX = "https://download.pytorch.org/whl/cpu"
SIDE_BY_SIDE = ["-n", "auto", "--maxprocesses", "4", "--dist", "loadfile"]
"""Tests of one file share a set-up, so a file stays with one process; some need 2 GB, hence four at most."""
NEVER_READ = (
    *("torch/bin/[!t]*", "torch/bin/test_*", "torch/include", "torch/test"),
    *("PySide6/Qt/qml", "PySide6/Qt/metatypes", "PySide6/Qt/translations", "PySide6/Qt/plugins/qmltooling"),
    *(f"PySide6/Qt/lib/libQt6{part}*" for part in ("Quick", "Qml", "Designer", "Labs", "Lottie", "Help")),
    *(f"PySide6/{tool}" for tool in ("assistant", "designer", "linguist", "lrelease", "lupdate", "qml[!t]*")),
    *("scipy/*/tests", "sympy/*/tests", "sympy/*/*/tests", "numpy/*/tests", "matplotlib/tests"),
    *("onnx/backend/test", "ezdxf/acc/*.c", "ezdxf/acc/*.cpp"),
)
"""Parts of packages, 0.33 GB, that nothing here reads: their own tests, torch's C++ headers, C sources, Qt's QML,
translations and tools for developers."""
IMPORT_EVERYTHING = """\
import contextlib, importlib, pkgutil
for package in map(importlib.import_module, ("analysis", "simulation", "drivers", "app", "flexura")):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not module.name.endswith("__main__"):
            with contextlib.suppress(Exception):  # Qt, where this system lacks a library of its
                importlib.import_module(module.name)
"""
OURS = {"bin", "include", "lib", "lib64", "share", "Include", "Lib", "Scripts", "etc", "pyvenv.cfg", ".gitignore"}
"""What a virtual environment holds at its top, finished or killed half way."""


def declared() -> configparser.ConfigParser:
    """Return what setup.cfg says."""
    settings = configparser.ConfigParser(interpolation=None)
    settings.read(ROOT / "setup.cfg", encoding="utf-8")
    return settings


def required() -> list[str]:
    """Return what every environment holds, but for what a lean one leaves out."""
    settings = declared()
    lists = [settings["options.extras_require"][extra] for extra in EVERYBODY]
    words = "\n".join([settings["options"]["install_requires"], *lists]).split()
    return [word for word in words if not word.startswith(HEAVY)]


def pins_digest(*extras: str) -> str:
    """Digest of all that decides what is installed for everybody and for `extras` besides, and where.

    The project itself is installed as a link to this folder: its packages and data may change.
    """
    settings = declared()
    asked = [settings["options.extras_require"][extra] for extra in (*EVERYBODY, *extras)]
    wanted = [settings["options"]["install_requires"], settings["options.entry_points"]["console_scripts"], *asked]
    pins = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    return hashlib.sha256("\n".join([str(ROOT), sys.version, *wanted, pins]).encode()).hexdigest()


def torch_index() -> list[str]:
    """Pip options that spare a Linux machine gigabytes of CUDA libraries it has no use for.

    A site that serves its own CPU wheel is left alone; otherwise PyTorch's CPU index is added
    where it can be reached.
    """
    if not sys.platform.startswith("linux"):
        return []
    import urllib.request  # here, because every later call would pay for it

    listed = subprocess.run(
        [str(PYTHON), "-m", "pip", "index", "versions", "torch"], capture_output=True, text=True, check=False
    )
    if "+cpu" in listed.stdout:
        return []
    try:
        with urllib.request.urlopen(TORCH_CPU_INDEX + "/torch/", timeout=5):  # noqa: S310 (a constant https address)
            return ["--extra-index-url", TORCH_CPU_INDEX]
    except OSError:
        return []


def install(*, lean: bool) -> None:
    """Build the environment from nothing and stamp it; where a lean one is there, add to it what that lacks."""
    if not lean and ready(LEAN_STAMP):
        print(
            "Flexura: installing what a lean environment lacks (once, a minute) ...", file=sys.stderr, flush=True
        )
        wanted = declared()["options"]["install_requires"].split()
        add(*torch_index(), *(word for word in wanted if word.startswith(HEAVY)))
        lighten()
        STAMP.write_text(pins_digest())
        return
    print(f"Flexura: installing into {ENVIRONMENT} (once, a minute or two) ...", file=sys.stderr, flush=True)
    if ENVIRONMENT.exists():
        known = {*OURS, STAMP.name, LEAN_STAMP.name, *(stamp.name for stamp in EXTRA_STAMPS.values())}
        strangers = [child.name for child in ENVIRONMENT.iterdir() if child.name not in known]
        if strangers and not (ENVIRONMENT / "pyvenv.cfg").exists():
            sys.exit(
                f"{ENVIRONMENT} holds {strangers[0]} and is no virtual environment: set FLEXURA_VENV to another"
            )
        for stamp in (STAMP, LEAN_STAMP):  # first: a kill from here on must not look finished
            stamp.unlink(missing_ok=True)
        shutil.rmtree(ENVIRONMENT)
    python = getattr(sys, "_base_executable", sys.executable)  # where it is .venv's own, that was just deleted
    subprocess.run([python, "-m", "venv", str(ENVIRONMENT)], check=True)
    if lean:  # by name: of the project itself pip would install all that it declares
        add(*required())
        add("--no-deps", "-e", str(ROOT))
    else:
        add(*torch_index(), "-e", f"{ROOT}[{','.join(EVERYBODY)}]")
    lighten()
    compile_imports()
    (LEAN_STAMP if lean else STAMP).write_text(
        pins_digest()
    )  # half a digest is no digest: a torn stamp means another installation


def add(*words: str) -> None:
    """Install what pip is given, at the pinned versions, and compile none of it: see `compile_imports`."""
    pip = [str(PYTHON), "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--no-compile"]
    subprocess.run([*pip, "-c", str(ROOT / "constraints.txt"), *words], check=True, cwd=ROOT)


def lighten() -> None:
    """Delete what installed packages bring along and nothing here reads; a file that Windows holds open stays."""
    for packages in (*ENVIRONMENT.glob("lib/python3*/site-packages"), *ENVIRONMENT.glob("Lib/site-packages")):
        for path in [found for pattern in NEVER_READ for found in packages.glob(pattern)]:
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                with contextlib.suppress(OSError):
                    path.unlink()


def compile_imports() -> None:
    """Import every module of ours once: Python keeps the bytecode of all that they import, and of nothing else.

    Whoever runs Flexura later may be unable to keep it (no right to write here, PYTHONDONTWRITEBYTECODE as in
    many containers), and would compile what a verb imports at every start.
    """
    keeping = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run([str(PYTHON), "-c", IMPORT_EVERYTHING], check=False, cwd=ROOT, env=keeping)


def install_for(word: str) -> None:
    """Add what `word` needs besides, and stamp it."""
    print(f"Flexura: installing what {word} needs besides (once, seconds) ...", file=sys.stderr, flush=True)
    # by name: pip would take the project itself out and install it anew, and a kill in between would lose it
    add(*declared()["options.extras_require"][EXTRAS[word]].split())
    EXTRA_STAMPS[word].write_text(pins_digest(EXTRAS[word]))


def ready(stamp: Path = STAMP, *extras: str) -> bool:
    """Whether the installation that writes this stamp is finished and belongs to today's pins."""
    return PYTHON.exists() and stamp.exists() and stamp.read_text() == pins_digest(*extras)


def main() -> int:
    """Install if need be, then hand the words on."""
    if sys.version_info < (3, 11):  # noqa: UP036 (an older Python gets this far, and deserves a sentence)
        sys.exit(f"Flexura needs Python 3.11 or newer; this is {sys.version.split()[0]}")
    words = sys.argv[1:]
    lean = words[:1] == [LEAN]
    words = words[1:] if lean else words
    asked = words[0] if words and words[0] in EXTRAS else None
    there = ready() or (lean and ready(LEAN_STAMP))  # a whole environment is a lean one, too
    if not there or (asked and not ready(EXTRA_STAMPS[asked], EXTRAS[asked])):
        try:
            if not there:
                install(lean=lean)
            if asked:
                install_for(asked)
        except subprocess.CalledProcessError as error:
            sys.exit(f"the installation failed (see above): {error}\nRun the same command again to retry.")
        except KeyboardInterrupt:
            sys.exit("the installation was stopped; the same command begins it anew")
    if words[:1] == ["tests"]:
        pytest = [str(PYTHON), "-m", "pytest", "--rootdir", str(ROOT), "-c", str(ROOT / "setup.cfg")]
        whole = not any((ROOT / word.partition("::")[0]).exists() for word in words[1:])  # few tests: one process
        command = [*pytest, *(SIDE_BY_SIDE if whole else []), *words[1:]]
        folder = str(ROOT)
    elif words[:1] == ["docs"]:
        sphinx = ["sphinx", "--jobs", "auto", "--fresh-env", "--fail-on-warning", "--keep-going"]
        command = [str(PYTHON), "-m", *sphinx, "--conf-dir", "docs/site", *words[1:], ".", "site"]
        folder = str(ROOT)
    else:
        safe = "-P"  # a folder called app where the user stands is not ours
        command = [str(PYTHON), safe, "-m", "flexura", *words]
        folder = None
    with subprocess.Popen(command, cwd=folder) as child:
        while True:
            try:
                return child.wait()
            except KeyboardInterrupt:  # the child has the signal too: let it make things safe, then end with it
                continue


if __name__ == "__main__":
    sys.exit(main())
