"""The twin of an experiment, from the cache if it is there, and with effects as one campaign wants it.

A campaign's twin with what it might have next: sensors at other places, and a known mass.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.declaration.plate_material import material_box
from analysis.declaration.transducers import Sensor
from analysis.effect_card import EffectCard, Values
from analysis.estimates import ACROSS, MODULI, RATIOS, TOLERANCES, Estimate
from analysis.experiment import Experiment, Patch, Plate, Point
from analysis.gap.data.groups import LawSmoothness, TemperatureGroups, mean_laws
from analysis.gap.data.noise import allowed_error
from analysis.progress import Progress
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import NO_EFFECTS, Effects
from analysis.updated import Updated
from app.files.bad_file import ResultFileError
from app.files.basis_cache import basis_file, cached_reduction, load_plate_basis
from app.files.effect_cache import cached_departures, cached_operators
from app.files.results.twin_file import TwinFile, read_twin, require_known_effects, require_same_plate
from simulation.effects.effect import Effect
from simulation.effects.library import library, seconds
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.sufficient_fineness import RequiredError, sufficient_fineness
from simulation.shell.points import attached_discs
from simulation.state.attached import deflection_at
from simulation.tolerances import tolerances
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

if TYPE_CHECKING:
    from simulation.reduction.plate_basis import PlateBasis
    from simulation.shell.fineness import Fineness
    from simulation.state.plate_state import Sheet

OFFSET = "sensor_offset"
"""Effect that needs operators of its own."""
SHAPE_POINTS = 32
"""Points along the longer side of the box around a plate on which its mode shapes are known."""


def campaign_twin(experiment: Experiment, report: Progress) -> Twin[DeclaredPlate]:
    """Twin of a campaign's plate over its band, certified over its material's box; its shapes known on a grid."""
    return Twin.of(experiment, DeclaredPlate(campaign_reduction(experiment, report)))


def campaign_reduction(experiment: Experiment, report: Progress) -> ReducedModel:
    """Reduced model of that twin."""
    return cached_reduction(**_asked(experiment), progress=report)


def effect_twin(
    experiment: Experiment,
    report: Progress,
    folder: Path | None = None,
    required: RequiredError | None = None,
    declared: Effects = NO_EFFECTS,
    also: Mapping[str, Effect] | None = None,
    *,
    offset: bool = True,
) -> Twin[EffectPlate]:
    """Return the twin of a campaign's plate with the project's effects and a user's own.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    folder : Path, optional
        A user's own effects.
    required : RequiredError, optional
        The mesh is refined if the twin is not as exact, and a finer one within the bound of its cost is.
    declared : mapping, optional
        Values of declared quantities, as of model updating: the moduli of an orthotropic sheet about which the
        twin is made.
    also : mapping, optional
        Further effects, which act last.
    offset : bool
        Whether `sensor_offset` is among them, which takes a third of the time and half of the memory. The first
        sensor's patch is then as declared, whatever its place in `declared`.

    Raises
    ------
    ValueError
        For a user's effects that cannot be loaded.
    """
    effects = library(experiment, folder)
    known: Mapping[str, Effect] = effects | seconds(effects) | dict(also or {})
    box = material_box(experiment.plate.material)
    fixed = {f"patch_place {one.id}" for one in experiment.sensors[:1]} if offset else ()
    about, made_at = placed(experiment, {name: one for name, one in declared.items() if name not in fixed})
    fineness = None if required is None else finer(about, required, report)
    basis = (lambda: plate_basis(about, report)) if fineness is None else lambda: None
    near = sheet_near(experiment, declared)
    operators = cached_operators(about, box, report, fineness=fineness, basis=basis, near=near, offset=offset)
    if not operators.offset_range:
        known = {name: effect for name, effect in known.items() if name != OFFSET}
    quantities = tolerances(experiment, operators.movable, made_at, attachable=bool(len(operators.places)))
    if MODULI in quantities:  # the moduli of a declared orthotropic sheet are free already
        known = {name: effect for name, effect in known.items() if name != "orthotropy"}
    return Twin.of(experiment, EffectPlate(operators), known, quantities)


def tolerant_twin(experiment: Experiment, report: Progress, declared: Effects = NO_EFFECTS) -> Twin[EffectPlate]:
    """Twin of a campaign's plate without effects, whose declared quantities have tolerances.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    declared : mapping, optional
        As in `effect_twin`.
    """
    box, near = material_box(experiment.plate.material), sheet_near(experiment, declared)
    about, made_at = placed(experiment, declared)
    operators = cached_departures(about, box, report, basis=lambda: plate_basis(about, report), near=near)
    known = tolerances(experiment, operators.movable, made_at)
    return Twin.of(experiment, EffectPlate(operators), tolerances=known)


def placed(experiment: Experiment, declared: Effects) -> tuple[Experiment, Effects]:
    """Return the experiment about which a twin is made, patches where they were found, and its values there.

    A twin is linear in moves of patches. What the second order leaves grows with their square: on the paper's
    plate 0.05 % of the response at 0.3 mm, 0.16 % at 0.5 mm, where the noise of a fit to 30 sweeps sees 0.02 %.

    Parameters
    ----------
    declared : mapping
        Values of declared quantities, as of model updating.
    """
    patches, made_at = list(experiment.patch), dict[str, Values]()
    for k, patch in enumerate(experiment.patch):
        found = {
            name: _rounded(declared.get(f"{name} {patch.id}", {}), step) for name, step in PATCH_STEPS.items()
        }
        place, size = found["patch_place"], found["patch_size"]
        along, across = (size.get(name, size.get("wider", 0.0)) for name in ("along", "across"))
        thicker = found["patch_thickness"].get("share", 0.0)
        moves = (place.get("dx", 0.0), place.get("dy", 0.0), along, across)
        if max(map(abs, moves)) < FAR_MOVED:
            continue
        table = patch.model_dump(exclude_none=True) | {
            "center": (patch.center[0] + moves[0], patch.center[1] + moves[1]),
            "thickness": patch.thickness * float(np.exp(thicker)),
        }
        if patch.diameter is None:
            table["size"] = (patch.size[0] + along, patch.size[1] + across)
        else:
            table |= {"diameter": patch.diameter + along}
            del table["size"]
        try:
            patches[k] = Patch.model_validate(table)
        except ValueError:  # beyond what a patch can be: the declared one stays
            continue
        made_at |= {f"{name} {patch.id}": values for name, values in found.items() if values}
    if not made_at:
        return experiment, NO_EFFECTS
    try:
        return Experiment.model_validate(experiment.model_dump() | {"patch": patches}), made_at
    except ValueError:  # patches that overlap, or leave the plate
        return experiment, NO_EFFECTS


def offset_wanted(experiment: Experiment, declared: Effects = NO_EFFECTS) -> bool:
    """Whether `sensor_offset` is a candidate: the place of the first sensor is exact, or beyond its tolerance.

    Parameters
    ----------
    declared : mapping
        Values of declared quantities, as of model updating.
    """
    if not experiment.sensors:
        return False
    name, given = experiment.sensors[0].id, experiment.tolerances
    tolerance = given.of(f"patch.{name}.center", given.patch_place)
    away = max(map(abs, declared.get(f"patch_place {name}", {}).values()), default=0.0)
    return tolerance == 0.0 or away > TOLERANCES * tolerance


def _rounded(values: Values, step: float) -> dict[str, float]:
    return {name: round(step * round(value / step), 9) for name, value in values.items()}


def sheet_near(experiment: Experiment, declared: Effects) -> "Sheet | None":
    """Logarithms of an orthotropic sheet's moduli about which its twin is made, to `MODULI_STEP`; else None."""
    if MODULI not in declared:
        return None
    material = experiment.plate.material
    if material is None or material.departure is None:
        return None
    found = [declared.get(name, {}).get(parameter, 0.0) for name, parameter in (*RATIOS[:2], *ACROSS)]
    ratio, shear, xz, yz = (round(MODULI_STEP * round(one / MODULI_STEP), 6) for one in found)
    return ratio, shear, xz, yz


FAR_MOVED = 3e-4
"""Smallest move of a patch, m, for which a twin is made anew."""
PATCH_STEPS = {"patch_place": 5e-5, "patch_size": 5e-5, "patch_thickness": 5e-3}
"""Quantities about which it is made, and their steps: a fit of the same data finds it again in the cache."""
MODULI_STEP = 0.05
"""Of these logarithms: a fit of the same data finds them again in the cache."""


def finer(experiment: Experiment, required: RequiredError, report: Progress) -> "Fineness | None":
    """Fineness that a twin needs to be as exact as required.

    Parameters
    ----------
    report : callable
        Called with the stage's name and the share done.

    Returns
    -------
    Fineness or None
        None for the usual one: if it is sufficient, and if no finer one within the bound of its cost is.
    """
    known = plate_basis(experiment, report)
    if known is None or required.met(known.dropped, known.error):
        return None
    report("refining the mesh", 0.0)
    asked = _asked(experiment)
    names = ("plate", "patches", "box", "band", "footprints", "attached")
    return sufficient_fineness(**{name: asked[name] for name in names}, required=required)


def plate_basis(experiment: Experiment, report: Progress) -> "PlateBasis | None":
    """Functions and vectors behind the twin of `campaign_twin`, which is made where it is not in the cache."""
    asked = _asked(experiment)
    file = basis_file(**asked)
    found = load_plate_basis(file)
    if found is None:
        cached_reduction(**asked, progress=report)
        found = load_plate_basis(file)
    return found


def twin_is_built(experiment: Experiment) -> bool:
    """Whether `campaign_twin` would find its reduced model in the cache."""
    return basis_file(**_asked(experiment)).is_file()


def _asked(experiment: Experiment) -> dict[str, Any]:
    """Return what a campaign asks of the plate's reduced model."""
    plate = experiment.plate
    return {
        "plate": plate,
        "patches": experiment.patch,
        "box": material_box(plate.material),
        "band": experiment.protocol.band,
        "footprints": experiment.footprints,
        "driven": experiment.driven,
        "attached": attached_discs(plate, experiment.attachments),
        "points": shape_points(plate),
        "field_certified": False,
    }


def shape_points(plate: Plate) -> NDArray[np.float64]:
    """Points of an even grid over the box around a plate that lie on it, edges included, x slowest, (K, 2), m."""
    sides = np.array([plate.length_x, plate.length_y])
    counts = np.maximum(np.round(SHAPE_POINTS * sides / sides.max()), 8).astype(int)
    axes = [np.linspace(low, high, n) for low, high, n in zip(*plate.bounds, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return points[plate.contains(points)]


REFERENCE_TEMPERATURE = 25.0
"""Temperature to which strain energies are referred, degrees Celsius."""
LEAST_LOSS = 1e-4
"""Smallest loss factor for which the twin's error is estimated: a fit may end below that of any real plate."""


@dataclass(frozen=True)
class Start:
    """A twin file, checked, and where it stands."""

    path: Path
    twin: TwinFile


def campaign_model(
    experiment: Experiment,
    plain: Updated,
    report: Progress,
    start: Start | None,
    folder: Path | None,
    declared: Effects | None = None,
) -> tuple[Twin[EffectPlate], dict[str, tuple[Estimate, ...]]]:
    """Return a campaign's twin with its library, and the effects of the twin file it starts from.

    Parameters
    ----------
    plain : Updated
        Strain energies are referred to its laws.
    report : callable
        Called with a stage's name and the share of it done.
    folder : Path or None
        A user's own effects.
    declared : mapping, optional
        Values of declared quantities about which the twin is made; those of `plain` by default.

    Returns
    -------
    twin : Twin
    given : dict of str to tuple of Estimate
        Parameters of the effects that are on.

    Raises
    ------
    ResultFileError
        For an effect that does not fit onto the plate.
    """
    declared = plain.departures if declared is None else declared
    offset = offset_wanted(experiment, declared) or (start is not None and OFFSET in start.twin.effects)
    twin = effect_twin(experiment, report, folder, required_error(plain), declared, offset=offset)
    given: dict[str, tuple[Estimate, ...]] = {}
    if start is not None:
        given = {
            effect.name: tuple(Estimate(name, p.value, p.sigma, p.unit) for name, p in effect.parameter.items())
            for effect in start.twin.effect
        }
        missing = [name for name in given if name not in twin.library]
        if missing:
            raise ResultFileError(
                f"{start.path}: {', '.join(missing)} cannot act on this plate: sensor_offset needs room in its "
                "mesh, and orthotropy a sheet whose own moduli are not free (tolerances.moduli = 0)"
            )
    return referred(twin, plain), given


def required_error(plain: Updated) -> RequiredError:
    """Error of a twin with which a campaign can be compared, at the least damping found by model updating."""
    loss_factor = max(float(plain.sharpest.loss_factor.min()), LEAST_LOSS)
    return RequiredError(allowed_error(float(np.median(plain.noise_floor))), loss_factor)


def referred(twin: Twin[EffectPlate], plain: Updated) -> Twin[EffectPlate]:
    """Return a twin whose strain energies are referred to a campaign's laws nearest `REFERENCE_TEMPERATURE`."""
    groups = TemperatureGroups.of(plain.temperature)
    values = mean_laws(plain.material, groups)
    laws = LawSmoothness.of(groups.reference, values).laws(values)
    return twin.referred(min(laws, key=lambda law: abs(law.reference - REFERENCE_TEMPERATURE)))


def start_of(path: Path | None, experiment: Experiment, folder: Path | None) -> Start | None:
    """Read the twin file to start from, if one is named, and check it before anything is computed.

    Parameters
    ----------
    folder : Path or None
        A user's own effects.

    Raises
    ------
    CampaignFileError
        For a file that is no twin, a twin of another plate, and effects that the library does not know or allow.
    ResultFileError
        For a user's effects in `folder` that cannot be loaded.
    """
    cards = known_effects(experiment, folder)
    if path is None:
        return None
    twin = read_twin(path)
    require_same_plate(path, twin, experiment)
    require_known_effects(path, twin, cards)
    return Start(path, twin)


def known_effects(experiment: Experiment, folder: Path | None) -> dict[str, EffectCard]:
    """Cards of the library and of a user's own effects; ResultFileError where these cannot be loaded."""
    if folder is None:
        return {name: effect.card(experiment) for name, effect in library(experiment).items()}
    try:
        return {name: effect.card(experiment) for name, effect in library(experiment, folder).items()}
    except ValueError as error:
        raise ResultFileError(f"--effects: {error}") from error


@contextmanager
def judging(campaign: AnyCampaign) -> Iterator[None]:
    """Turn what the analysis refuses into a ResultFileError that names the campaign.

    A matrix that cannot be inverted is no refusal but a defect, and keeps its traceback.
    """
    try:
        yield
    except (np.linalg.LinAlgError, ResultFileError):
        raise
    except ValueError as error:
        raise ResultFileError(f"{campaign.name}: cannot be judged: {error}") from error


NAME = "further"
"""Of further sensors, with their numbers."""
KNOWN_MASS: Mapping[str, str] = {"effect": "mass_at_place", "parameter": "mass"}
"""Effect by which a known mass is computed."""
SLOPE_STEP = 1e-4
"""m; over it the deflection's slope is taken."""


def with_sensors(twin: Twin[EffectPlate], points: Sequence[Point]) -> Twin[EffectPlate]:
    """Return a twin that also reads the velocity at some points, without loading the plate there.

    The deflection is interpolated between the places at which something may be attached, so that no plate is
    reduced again: good to a thousandth of its rms, which does for a plan.

    Parameters
    ----------
    twin : Twin
        With an experiment.
    points : sequence of (float, float)
        m.

    Returns
    -------
    Twin
        The further outputs are the last.

    Raises
    ------
    ValueError
        For a point off the plate, and for a twin without an experiment.
    """
    if twin.experiment is None:
        raise ValueError("a twin without an experiment declares no sensors")
    ops = twin.plate.operators
    rows = np.array([deflection_at(ops, x, y) for x, y in points])
    along_x = np.array(
        [deflection_at(ops, x + SLOPE_STEP, y) - deflection_at(ops, x - SLOPE_STEP, y) for x, y in points]
    )
    along_y = np.array(
        [deflection_at(ops, x, y + SLOPE_STEP) - deflection_at(ops, x, y - SLOPE_STEP) for x, y in points]
    )
    slopes = np.array([along_x, along_y, np.zeros_like(rows)]) / (2.0 * SLOPE_STEP)  # points have no area
    size = ops.size
    wider = replace(
        ops,
        footprints=np.vstack([ops.footprints.reshape(-1, size), rows]),
        footprint_slopes=np.concatenate([ops.footprint_slopes.reshape(3, -1, size), slopes], axis=1),
    )
    experiment = with_sensors_declared(twin.experiment, points)
    known: Mapping[str, Effect] = tolerances(experiment, ops.movable, attachable=bool(len(ops.places)))
    found = Twin.of(experiment, EffectPlate(wider), twin.library, known)
    return replace(found, peak_energy=twin.peak_energy)


def with_sensors_declared(experiment: Experiment, points: Sequence[Point]) -> Experiment:
    """Declare velocity sensors at some points besides all that is declared."""
    taken = {one.id for one in experiment.sensor}
    names = [f"{NAME}{k}" for k in range(1, len(points) + len(taken) + 1) if f"{NAME}{k}" not in taken]
    more = [Sensor(id=name, kind="velocity", point=point) for name, point in zip(names, points, strict=False)]
    return experiment.model_copy(update={"sensor": (*experiment.sensor, *more)})


def known_mass(place: Point, mass: float) -> dict[str, Values]:
    """Return the effect that a mass of some kilograms at a place is, m."""
    return {KNOWN_MASS["effect"]: {KNOWN_MASS["parameter"]: mass, "x": place[0], "y": place[1]}}
