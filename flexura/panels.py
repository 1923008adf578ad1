"""Filters of a panel that follow the temperature: designed over temperature, and by networks."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from analysis.compensation.settings import Training
from analysis.focusing.methods import METHODS, Method
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from app.files.panel_file import SECTION_2, read_panel
from app.files.provenance import sha256
from app.files.run_folder import run_folder
from app.stages import compensate as compensate_stage
from app.stages import focus as focus_stage
from app.stages.panel_inputs import checked_device, method_for, panel_for
from app.stages.panel_laws import laws_of, range_of, within
from app.stages.update import Updating
from flexura.campaigns import File, computing

Laws = File | MaterialLaws | Updating
"""A run folder of ``flexura update`` (or its laws.h5), laws, or what `flexura.update` returned."""


def focus(
    laws: Laws,
    panel: File | Panel = SECTION_2,
    *,
    temperature: Sequence[float] | None = None,
    method: Method = "stif",
    out: File | None = None,
    progress: bool = False,
) -> focus_stage.FocusedPanel:
    """Design filters of a panel over temperature, as ``flexura focus``.

    Parameters
    ----------
    laws : path, MaterialLaws or Updating
        Which the panel's plate obeys.
    panel : path or Panel
        The paper's section 2 where it is left out.
    temperature : sequence of float, optional
        Degrees Celsius; every 5 K of what laws and panel share where it is left out.
    method : str
        How filters are designed: ``stif``, ``time-reversal``, ``modal-control`` or ``none``.
    out : path, optional
        Run folder for filters.h5; wants `laws` and `panel` as paths, whose SHA-256 the file keeps.
    progress : bool
        Draw progress bars on the error stream, where that is a terminal.

    Returns
    -------
    FocusedPanel

    Raises
    ------
    ValueError
        For an unknown method, and for `out` with laws or a panel that are in no file.
    app.files.bad_file.ResultFileError
        For a file that cannot be used, a temperature outside the laws' range, and laws that share no temperatures
        with the panel.
    """
    _require_method(method)
    origin, found_laws = _laws(laws, "focus")
    file = None if isinstance(panel, Panel) else Path(panel)
    declared = panel if isinstance(panel, Panel) else read_panel(Path(panel))
    run, inputs = _kept(out, origin, file)
    range_of(declared, found_laws, origin or Path("laws"))
    wanted = None
    if temperature is not None:
        wanted = within(np.unique(np.asarray(temperature, float)), found_laws, origin or Path("laws"))
    with computing(shown=progress) as report:
        found = focus_stage.compute(declared, found_laws, report, temperature=wanted, method=method)
    if run is not None:
        focus_stage.save(run, found, inputs)
    return found


def compensate(
    laws: Laws,
    panel: File | Panel | None = None,
    *,
    training: Training | None = None,
    spacing: float = 5.0,
    place: int | None = None,
    across: Sequence[float] = (),
    method: Method | None = None,
    device: str = "cpu",
    out: File | None = None,
    progress: bool = False,
) -> compensate_stage.CompensatedPanel:
    """Train networks that give filters at any temperature, and judge them and their rivals.

    As ``flexura compensate``.

    Parameters
    ----------
    laws : path, MaterialLaws or Updating
        Which the panel's plate obeys.
    panel : path or Panel, optional
        That of filters.h5 beside the laws where it is left out, else the paper's section 2.
    training : Training, optional
        Standard settings where it is left out, with fewer hidden nodes for few temperatures placed.
    spacing : float
        Between training temperatures, K.
    place : int, optional
        How many training temperatures are placed where the filters need them, instead of every `spacing`.
    across : sequence of float
        Differences of temperature between two opposite sides of the panel, K, at which the filters are tried.
    method : str, optional
        How the filters are designed that are followed; as those of filters.h5 whose panel is taken where it is
        left out, else ``stif``.
    device : str
        Where torch trains: ``cpu``, ``cuda``, ``cuda:1``.
    out : path, optional
        Run folder for compensation.h5; wants `laws` and `panel` as paths, whose SHA-256 the file keeps.
    progress : bool
        Draw progress bars on the error stream, where that is a terminal.

    Returns
    -------
    CompensatedPanel

    Raises
    ------
    analysis.compensation.evidence_collapse.EvidenceCollapseError
        Where a network is refused.
    ValueError
        For an unknown method, temperatures that cannot be chosen so, and for `out` with laws or a panel that are
        in no file.
    app.files.bad_file.ResultFileError
        For a file that cannot be used, a device that torch cannot use, and laws that share no temperatures with
        the panel.
    """
    if method is not None:
        _require_method(method)
    if not spacing > 0.0:
        raise ValueError(f"spacing {spacing:g} K: above 0 wanted")
    origin, found_laws = _laws(laws, "compensate")
    declared, file, followed = _followed(panel, method, origin)
    run, inputs = _kept(out, origin, file)
    range_of(declared, found_laws, origin or Path("laws"))
    checked_device(device)
    with computing(shown=progress) as report:
        found = compensate_stage.compute(
            declared,
            found_laws,
            report,
            training=training,
            spacing=spacing,
            place=place,
            across=across,
            method=followed,
            device=device,
        )
    if run is not None:
        compensate_stage.save(run, found, inputs)
    return found


def _laws(laws: Laws, verb: str) -> tuple[Path | None, MaterialLaws]:
    """File of the laws, None for laws in memory, and the laws."""
    if isinstance(laws, MaterialLaws):
        return None, laws
    if isinstance(laws, Updating):
        if laws.laws is None:
            raise ValueError("no laws over temperature: at least 3 temperatures with settled estimates are needed")
        return None, laws.laws
    return laws_of(Path(laws), verb)


def _followed(
    panel: File | Panel | None, method: Method | None, laws: Path | None
) -> tuple[Panel, Path | None, Method]:
    """Return panel, its file, and the method of the filters that networks follow, as the verb takes them."""
    if isinstance(panel, Panel):
        return panel, None, method or "stif"
    named = None if panel is None else Path(panel)
    if laws is None:
        file = named or SECTION_2
        return read_panel(file), file, method or "stif"
    return *panel_for(named, laws.parent, {}), method_for(method, named, laws.parent)


def _require_method(method: str) -> None:
    if method not in METHODS:
        raise ValueError(f"method {method!r}: {' or '.join(METHODS)}")


def _kept(out: File | None, laws: Path | None, panel: Path | None) -> tuple[Path | None, Mapping[str, str]]:
    """Run folder for the results, and SHA-256 of the files they follow from."""
    if out is None:
        return None, {}
    if laws is None or panel is None:
        raise ValueError(
            "out keeps the SHA-256 of the files that filters follow from: name the run folder that holds laws.h5 "
            "in place of laws, and the panel's file in place of a panel"
        )
    return run_folder(Path(out), Path(out)), {path.name: sha256(path) for path in (laws, panel)}
