"""Reduced models kept between runs, in the user's cache folder, one HDF5 file per basis.

A file is named by all that decides its content: one that is damaged, cut short (`app.files.hdf5_file`) or of
another layout is made again, never trusted.
"""

import hashlib
import logging
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike
from platformdirs import user_cache_path

from analysis.channel import Footprint
from analysis.experiment import Patch, Plate
from analysis.geometry.loop import GeometryError
from analysis.material import MaterialBox
from analysis.progress import Progress
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.disk_room import UnwrittenFileError
from app.files.hdf5_file import Hdf5FileError, opened_hdf5

if TYPE_CHECKING:
    from simulation.reduction.basis_key import BasisTraining
    from simulation.reduction.plate_basis import PlateBasis
    from simulation.reduction.reduced_model import ReducedModel
    from simulation.shell.fineness import Fineness

log = logging.getLogger(__name__)
FORMAT = "flexura-basis/4"
ARRAYS = (
    "stiffness_1",
    "stiffness_2",
    "stiffness_patch",
    "coupling",
    "capacitance",
    "dashpots",
    "deflection",
    "points",
    "footprints",
)


def cache_folder() -> Path:
    """Where bases are kept: ``FLEXURA_CACHE`` if it is set, else the user's cache folder."""
    chosen = os.environ.get("FLEXURA_CACHE")
    return Path(chosen) if chosen else user_cache_path("flexura", appauthor=False)


@cache
def told_unkept(file: str, reason: str) -> None:
    """Say that a model is not kept, and how another folder is named; once of each file."""
    log.warning(
        "note: %s: %s; the model is built again next time (FLEXURA_CACHE=FOLDER keeps models elsewhere)",
        file,
        reason,
    )


def cached_reduction(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    *,
    footprints: Sequence[Footprint] = (),
    driven: Sequence[int] = (),
    attached: Sequence[Footprint] | None = None,
    points: ArrayLike | None = None,
    field_certified: bool = True,
    fineness: "Fineness | None" = None,
    training: "BasisTraining | None" = None,
    progress: Progress | None = None,
) -> "ReducedModel":
    """Reduced model of a plate with patches, from the cache or made and kept there.

    Parameters
    ----------
    box : MaterialBox
        Materials over which the model is trained and its error certified.
    band : (float, float)
        Hz.
    footprints : sequence of Footprint
        Of the transducers.
    driven : sequence of int
        Those of them on which forces act.
    attached : sequence of Footprint, optional
        Discs of strings and cables. Where they are given, none too, effects will be asked of the plate, and the
        basis behind the model is kept as well, see `load_plate_basis`.
    points : (K, 2) array_like, optional
        Where the deflection will be asked for, m.
    field_certified : bool
        Whether the deflection there counts in the error.
    fineness : Fineness, optional
        The converged one unless given.
    training : BasisTraining, optional
        The strict one unless given.
    progress : callable, optional
        Called with the stage's name and the share done.

    Raises
    ------
    ResultFileError
        Where the plate cannot be reduced, with what to change.
    """
    file = basis_file(
        plate, patches, box, band, points, fineness, training, field_certified, footprints, driven, attached
    )
    stored = load_basis(file)
    if stored is not None:
        return stored

    from simulation.reduction.plate_basis import plain_reduction  # it meshes and assembles

    with reducing(box, band):
        _, reduced, basis = plain_reduction(
            plate,
            patches,
            box,
            band,
            attached=attached or (),
            footprints=footprints,
            driven=driven,
            points=points,
            field_certified=field_certified,
            fineness=fineness,
            training=training,
            progress=progress,
        )
    try:
        save_basis(file, reduced, None if attached is None else basis)
    except UnwrittenFileError as error:
        told_unkept(error.filename, error.strerror)
    # as it will be read next time: arrays laid out otherwise in memory round otherwise in the last digit
    return load_basis(file) or reduced


def basis_file(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    points: ArrayLike | None = None,
    fineness: "Fineness | None" = None,
    training: "BasisTraining | None" = None,
    field_certified: bool = True,
    footprints: Sequence[Footprint] = (),
    driven: Sequence[int] = (),
    attached: Sequence[Footprint] | None = None,
) -> Path:
    """Return where the cache keeps a reduced model, there or not.

    Parameters
    ----------
    plate, patches, box : Plate, sequence of Patch, MaterialBox
    band : (float, float)
        Hz.
    points : (K, 2) array_like, optional
        m.
    fineness, training, field_certified : Fineness, BasisTraining, bool
    footprints, driven, attached : sequence
        These and all others as of `cached_reduction`.

    Returns
    -------
    Path
        Its name is a hash of all arguments.
    """
    from simulation.reduction.basis_key import basis_key

    key = basis_key(plate, patches, box, band, points, fineness, training, field_certified)
    acting = [(*one.point, one.radius, one.mass > 0.0, k in driven) for k, one in enumerate(footprints)]
    if acting or attached is not None:
        held = None if attached is None else [(*one.point, one.radius) for one in attached]
        key = hashlib.sha256(repr((key, acting, held)).encode()).hexdigest()
    return cache_folder() / f"basis-{key}.h5"


@contextmanager
def reducing(box: MaterialBox, band: tuple[float, float]) -> Iterator[None]:
    """Turn a plate that cannot be meshed, or reduced, into a ResultFileError that says what to change."""
    try:
        yield
    except GeometryError as error:
        raise ResultFileError(f"this plate cannot be meshed: {error}") from error
    except RuntimeError as error:
        (low, high), least = box.youngs_modulus, box.loss_factor[0]
        raise ResultFileError(
            f"no reduced model of this plate is exact enough over E {low / 1e9:.4g} to {high / 1e9:.4g} GPa, loss "
            f"factor from {least:g}, {band[0]:g} to {band[1]:g} Hz ({error}). Lower the upper end of the band, or "
            "narrow youngs_modulus or raise the lower loss_factor in [plate.material]; is the thickness right?"
        ) from error


def save_basis(file: Path, reduced: "ReducedModel", basis: "PlateBasis | None" = None) -> None:
    """Write a reduced model, and what it rests on, whole or not at all.

    Parameters
    ----------
    basis : PlateBasis, optional
        Kept where effects will be asked of the plate.
    """
    with atomic_hdf5(file, shared=True) as stored:
        stored.attrs["format"] = FORMAT
        stored.attrs["error"] = reduced.error
        stored.attrs["band"] = reduced.band
        for name in ("youngs_modulus", "poisson_ratio", "loss_factor"):
            stored.attrs[name] = getattr(reduced.box, name)
        for name in ARRAYS:
            stored.create_dataset(name, data=getattr(reduced, name))
        if basis is not None:
            stored.create_dataset("kept", data=basis.kept)
            stored.create_dataset("vectors", data=basis.vectors)
            stored.attrs["dropped"] = basis.dropped


def load_plate_basis(file: Path) -> "PlateBasis | None":
    """Read what a reduced model rests on; None where it is not there or not what was written."""
    from simulation.reduction.plate_basis import PlateBasis

    if not file.is_file():
        return None
    try:
        with opened_hdf5(file) as stored:
            kept, vectors = stored["kept"][()], stored["vectors"][()]
            return PlateBasis(kept, float(stored.attrs["dropped"]), vectors, float(stored.attrs["error"]))
    except Hdf5FileError:
        return None


def load_basis(file: Path) -> "ReducedModel | None":
    """Read a reduced model; None where there is none or it is not what was written."""
    from simulation.reduction.reduced_model import ReducedModel

    if not file.is_file():
        return None
    try:
        with opened_hdf5(file) as stored:
            if stored.attrs["format"] != FORMAT:
                return None
            names = ("youngs_modulus", "poisson_ratio", "loss_factor")
            edges = {name: tuple(float(x) for x in stored.attrs[name]) for name in (*names, "band")}
            return ReducedModel(
                **{name: stored[name][()] for name in ARRAYS},
                box=MaterialBox(**{name: edges[name] for name in names}),  # type: ignore[arg-type]
                band=edges["band"],  # type: ignore[arg-type]
                error=float(stored.attrs["error"]),
            )
    except Hdf5FileError:
        return None
