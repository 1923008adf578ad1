"""Reduced plates with effects kept between runs, in the user's cache folder, one HDF5 file per plate.

As in `app.files.basis_cache`: named by all that decides the content, made again where damaged. Symmetric
matrices are stored as their upper triangles.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, fields
from math import isqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment
from analysis.material import MaterialBox
from analysis.progress import Progress
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.basis_cache import cache_folder, reducing, told_unkept
from app.files.disk_room import UnwrittenFileError
from app.files.hdf5_file import Hdf5FileError, opened_hdf5

if TYPE_CHECKING:
    from simulation.reduction.effect_operators import EffectOperators
    from simulation.reduction.plate_basis import PlateBasis
    from simulation.shell.fineness import Fineness
    from simulation.state.plate_state import Sheet

FORMAT = "flexura-effect-operators/1"
METHOD = 30
"""Raised whenever the same declaration would give other operators."""
SCALARS = ("offset_range", "cell", "thickness", "angle", "place_spacing", "error", "plain_error", "dropped")
PLAIN = (
    "capacitance",
    "coupling",
    "points",
    "deflection",
    "footprints",
    "zone",
    "zone_fit",
    "strain",
    "sheet",
    "strain_points",
    "places",
    "place_deflection",
    "place_compliance",
    "movable",
    "patch_zone",
    "thicker_coupling",
    "footprint_slopes",
    "deflection_slopes",
    "moved_coupling",
)


def cached_operators(
    experiment: Experiment,
    box: MaterialBox,
    report: Progress,
    fineness: "Fineness | None" = None,
    basis: "Callable[[], PlateBasis | None]" = lambda: None,
    near: "Sheet | None" = None,
    *,
    exact: bool = False,
    offset: bool = True,
) -> "EffectOperators":
    """Operators of an experiment's plate, from the cache or made and kept there; about a minute where made.

    Parameters
    ----------
    box : MaterialBox
        Materials over which the operators are trained.
    report : callable
        Called with the stage's name and the share done.
    fineness : Fineness, optional
        The converged one unless given.
    basis : callable, optional
        Asked only where they are made: returns what the plain reduction rests on, None where it is not known.
    near : (4,) tuple of float, optional
        Moduli of an orthotropic sheet about which they are made.
    exact : bool
        Whether patches are exactly as declared, as those of a simulated plate.
    offset : bool
        Whether the first sensor may lie millimetres beside its place.

    Raises
    ------
    ResultFileError
        Where the plate cannot be reduced, with what to change.
    """
    from simulation.reduction.effect_reduction import reduce_with_effects

    def made() -> "EffectOperators":
        ops, _, _ = reduce_with_effects(
            experiment,
            box,
            basis=basis(),
            fineness=fineness,
            near=near,
            exact=exact,
            offset=offset,
            progress=report,
        )
        return ops

    kind = ("exact" if exact else "effects") + ("" if offset else "-in-place")
    return _kept(kind, experiment, box, fineness, near, made)


def cached_departures(
    experiment: Experiment,
    box: MaterialBox,
    report: Progress,
    fineness: "Fineness | None" = None,
    basis: "Callable[[], PlateBasis | None]" = lambda: None,
    near: "Sheet | None" = None,
) -> "EffectOperators":
    """Operators of an experiment's plate for errors of its declaration alone; some seconds where they are made.

    Parameters
    ----------
    report : callable
        Called with the stage's name and the share done.
    near : (4,) tuple of float, optional
        As in `cached_operators`.

    Raises
    ------
    ResultFileError
        Where the plate cannot be reduced, with what to change.
    """
    from simulation.reduction.effect_reduction import reduce_with_departures

    def made() -> "EffectOperators":
        known = basis()
        return reduce_with_departures(experiment, box, basis=known, fineness=fineness, near=near, progress=report)

    return _kept("departures", experiment, box, fineness, near, made)


def _kept(
    kind: str,
    experiment: Experiment,
    box: MaterialBox,
    fineness: "Fineness | None",
    near: "Sheet | None",
    made: "Callable[[], EffectOperators]",
) -> "EffectOperators":
    """Operators from the cache, made and kept there if they are not in it."""
    file = cache_folder() / f"{kind}-{operators_key(experiment, box, fineness, near)}.h5"
    stored = load_operators(file)
    if stored is None:
        with reducing(box, experiment.protocol.band):
            fresh = made()
        try:
            save_operators(file, fresh)
        except UnwrittenFileError as error:
            told_unkept(error.filename, error.strerror)
            return fresh
        del fresh  # half a gigabyte: what is used is read back, as by every later run
        stored = load_operators(file)
    if stored is None:
        raise ResultFileError(f"{file}: just written, and cannot be read back; check the disk, then start again")
    return stored


def operators_key(
    experiment: Experiment, box: MaterialBox, fineness: "Fineness | None" = None, near: "Sheet | None" = None
) -> str:
    """Return a hash over all that decides an experiment's operators.

    Parameters
    ----------
    near : (4,) tuple of float, optional
        Moduli of an orthotropic sheet about which they are made.

    Returns
    -------
    str
        SHA-256, hexadecimal.
    """
    from simulation.reduction.basis_key import basis_key

    attached = [(*a.point, -1.0 if a.radius is None else a.radius) for a in experiment.attachments]
    points = np.array(attached).reshape(-1, 3)
    plain = basis_key(experiment.plate, experiment.patch, box, experiment.protocol.band, points, fineness)
    first = next((k for k, patch in enumerate(experiment.patch) if patch.role == "sensor"), None)
    decides: list[object] = [plain, first, METHOD]
    if experiment.footprints:
        acting = enumerate(experiment.footprints)
        decides.append([(*f.point, f.radius, f.mass > 0.0, k in experiment.driven) for k, f in acting])
    if near is not None:
        decides.append(list(near))
    return hashlib.sha256(json.dumps(decides).encode()).hexdigest()


def save_operators(file: Path, operators: "EffectOperators") -> None:
    """Write operators, whole or not at all."""
    with atomic_hdf5(file, shared=True) as stored:
        stored.attrs["format"] = FORMAT
        stored.attrs["band"] = operators.band
        for name in SCALARS:
            stored.attrs[name] = getattr(operators, name)
        for name, edges in asdict(operators.box).items():
            stored.attrs[name] = edges
        for entry in fields(operators):
            value = getattr(operators, entry.name)
            if isinstance(value, np.ndarray):
                packed = value if entry.name in PLAIN else _packed(value)
                stored.create_dataset(entry.name, data=packed)


def load_operators(file: Path) -> "EffectOperators | None":
    """Read operators; None where there are none or they are not what was written."""
    from simulation.reduction.effect_operators import EffectOperators

    if not file.is_file():
        return None
    try:
        with opened_hdf5(file) as stored:
            if stored.attrs["format"] != FORMAT:
                return None
            arrays: dict[str, NDArray[np.float64]] = {}
            edges = {
                n: tuple(float(x) for x in stored.attrs[n])
                for n in ("youngs_modulus", "poisson_ratio", "loss_factor")
            }
            for entry in fields(EffectOperators):
                if entry.name in stored:
                    packed = stored[entry.name][()]
                    arrays[entry.name] = packed if entry.name in PLAIN else _square(packed)
            low, high = (float(x) for x in stored.attrs["band"])
            scalars = {name: float(stored.attrs[name]) for name in SCALARS}
            box = MaterialBox(**edges)  # type: ignore[arg-type]
            return EffectOperators(**arrays, **scalars, box=box, band=(low, high))  # type: ignore[arg-type]
    except Hdf5FileError:
        return None


def _packed(stack: NDArray[np.float64]) -> NDArray[np.float64]:
    """Upper triangles of symmetric matrices, (..., r, r) -> (..., r (r + 1)/2)."""
    row, column = np.triu_indices(stack.shape[-1])
    return np.asarray(stack[..., row, column])


def _square(packed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Full symmetric matrices from their upper triangles."""
    size = (isqrt(8 * packed.shape[-1] + 1) - 1) // 2
    full = np.empty((*packed.shape[:-1], size, size))
    row, column = np.triu_indices(size)
    full[..., row, column] = packed
    full[..., column, row] = packed
    return full
