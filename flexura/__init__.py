"""Flexura as a library: load a campaign, identify, update, compare with the twin, focus, compensate, plot, run.

Each function does what the verb of the same name does, and calls the same stage. What a function needs is imported
when it is first asked for, so that ``import flexura`` costs little. See ``docs/guide/library.md``.

====================  ==============================================================
``campaigns``         `load`, `frf`, `identify`, `update`, `update_modes`, `gap`: a plate over temperature
``modal_tests``       `frfs_of_test`, `identify_test`: a structure at one temperature
``files_out``         `report`, `export_filters`, `export_sweeps`
``whole_run``         `run`: all of it, and the report
``panels``            `focus`, `compensate`: filters that follow the temperature; `health`: what has changed;
                      `study`: the paper's figures
``sound``             `radiation`, `render`, `thermometer`: what is heard of a panel, what it plays, how warm it is
``forward_twin``      `twin`: material and effects in, FRFs, derivatives, modes and matrices out
``um_bridge``         the same served to samplers and optimisers elsewhere: `serve`
``arguments``         paths and numbers as the functions take them, and the progress of a call
``figures``           `plot`: figures of all these results
``shipped_examples``  `example`: those that come with it
``keywords``          errors name keywords, where those of a verb name options; arguments are of their kind, or
                      refused
``own_packages``      Flexura's own packages are imported, not others of the same name
====================  ==============================================================
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from flexura.own_packages import claim_names

claim_names()

if TYPE_CHECKING:
    from flexura.campaigns import frf, gap, identify, load, update, update_modes
    from flexura.figures import plot
    from flexura.files_out import export_filters, export_sweeps, report
    from flexura.forward_twin import twin
    from flexura.modal_tests import frfs_of_test, identify_test
    from flexura.panels import compensate, focus, health, study
    from flexura.shipped_examples import example
    from flexura.sound import radiation, render, thermometer
    from flexura.um_bridge import serve
    from flexura.whole_run import run

__all__ = [
    "compensate",
    "example",
    "export_filters",
    "export_sweeps",
    "focus",
    "frf",
    "frfs_of_test",
    "gap",
    "health",
    "identify",
    "identify_test",
    "load",
    "plot",
    "radiation",
    "render",
    "report",
    "run",
    "serve",
    "study",
    "thermometer",
    "twin",
    "update",
    "update_modes",
]

_MODULES = {
    "load": "campaigns",
    "frf": "campaigns",
    "identify": "campaigns",
    "update": "campaigns",
    "update_modes": "campaigns",
    "gap": "campaigns",
    "focus": "panels",
    "compensate": "panels",
    "health": "panels",
    "study": "panels",
    "plot": "figures",
    "run": "whole_run",
    "example": "shipped_examples",
    "identify_test": "modal_tests",
    "frfs_of_test": "modal_tests",
    "report": "files_out",
    "export_filters": "files_out",
    "export_sweeps": "files_out",
    "twin": "forward_twin",
    "serve": "um_bridge",
    "radiation": "sound",
    "render": "sound",
    "thermometer": "sound",
}


def __getattr__(name: str) -> Any:
    """Import a public function when it is first asked for."""
    if name == "__version__":
        return import_module("analysis").__version__
    if name not in _MODULES:
        raise AttributeError(f"module 'flexura' has no attribute {name!r}; it has {', '.join(__all__)}")
    from flexura.keywords import keyworded

    globals()[name] = keyworded(getattr(import_module(f"flexura.{_MODULES[name]}"), name))
    return globals()[name]


def __dir__() -> list[str]:
    """List the public functions, imported or not."""
    return sorted({*globals(), *__all__, "__version__"})
