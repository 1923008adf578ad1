"""Declared quantities as parameters of the twin: each with its tolerance, applied before any effect.

They use the machinery of effects, but are no candidates: all of them are free in every fit, with the tolerance as
standard deviation of their prior about zero.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.declaration.transducers import Drive, Patch, Sensor
from analysis.effect_card import EffectCard, Parameter, Values
from analysis.estimates import LOSS, MODULI, TRANSVERSE
from analysis.experiment import Experiment
from analysis.twin_model import NO_EFFECTS, Effects
from simulation.effects.effect import Effect, isotropic
from simulation.state.plate_state import (
    FARTHEST_LOSS,
    FARTHEST_MODULI,
    FARTHEST_SHEAR,
    Circumstances,
    Departures,
    PlateState,
    departed_loss,
    departed_moduli,
    departed_transverse,
)

RANGE_IN_TOLERANCES = 8.0
"""Range of every quantity, in tolerances: far enough to see that a declaration is wrong."""

Change = Callable[[Any, Mapping[str, Any]], dict[str, Any]]
"""(departures, or anything with their attributes; values) -> attributes of `Departures` that change."""


@dataclass(frozen=True)
class Tolerance(Effect):
    """A declared quantity, and what it changes in the departures.

    Attributes
    ----------
    change : Change or None
        None where it changes the state otherwise.
    made_at : mapping
        Values about which the twin was made; empty where these are the declared ones. Changes count from there.
    """

    change: Change | None = None
    made_at: Mapping[str, float] = field(default_factory=dict)

    def changed(self, away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the attributes of departures that these values change."""
        if self.change is None:
            raise ValueError("this quantity is no departure")
        if self.made_at:
            values = {name: value - self.made_at.get(name, 0.0) for name, value in values.items()}
        return self.change(away, values)


def depart(
    known: Mapping[str, Effect],
    state: PlateState,
    circumstances: Circumstances,
    values: Mapping[str, Mapping[str, Any]],
) -> PlateState:
    """Apply those declared quantities that have values: all departures at once, which is faster than one by one.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping of str to mapping
        Of effects, too: these are not applied.
    """
    away = SimpleNamespace(**vars(state.departures))
    for name, one in known.items():
        if isinstance(one, Tolerance) and one.change is not None:
            if name in values or one.made_at:  # without a value it is as declared
                away.__dict__.update(one.changed(away, values.get(name, dict.fromkeys(one.made_at, 0.0))))
        elif name in values:
            state = one.apply(state, circumstances, values[name])
    return state.with_(departures=Departures(**vars(away)))


def tolerances(
    experiment: Experiment, movable: Real, made_at: Effects = NO_EFFECTS, *, attachable: bool = False
) -> dict[str, Effect]:
    """Return the declared quantities that are not exact, by name.

    Parameters
    ----------
    movable : (P,) ndarray
        1 for patches that have room around them to be moved, see `EffectOperators.movable`.
    made_at : mapping
        Values of declared quantities about which the twin was made, where these are not the declared ones.
    attachable : bool
        Whether something undeclared may be attached anywhere, see `EffectOperators.places`.
    """
    parts = (
        _of_the_plate(experiment),
        _of_patches(experiment, movable),
        _of_instruments(experiment),
        _of_attachments(experiment),
        _of_undeclared(experiment) if attachable else (),
        _of_the_theory(experiment),
        sheet_tolerances(experiment),
    )
    known = {effect.card(experiment).name: effect for part in parts for effect in part}
    return known | {name: _made_at(known[name], experiment, values) for name, values in made_at.items()}


def _made_at(one: Effect, experiment: Experiment, values: Values) -> Effect:
    """Return a quantity that counts its changes from the values about which the twin was made."""
    card = one.card(experiment)
    parameters = tuple(replace(p, made_at=values.get(p.name, 0.0)) for p in card.parameters)
    shown = replace(card, parameters=parameters)
    if not isinstance(one, Tolerance):
        raise ValueError(f"{card.name}: a twin cannot be made about a value of it")
    moved = Tolerance(lambda _: shown, one.apply, change=one.change, made_at=values)

    def apply(state: PlateState, circumstances: Circumstances, given: Mapping[str, Any]) -> PlateState:
        return state.with_(departures=replace(state.departures, **moved.changed(state.departures, given)))

    return replace(moved, apply=apply)


def _of_the_plate(experiment: Experiment) -> Iterator[Effect]:
    given, plate = experiment.tolerances, experiment.plate
    for kind, value in (("thickness", plate.thickness), ("mass", plate.mass)):
        share = given.of(f"plate.{kind}", getattr(given, kind) * value) / value
        yield from _quantity(f"plate_{kind}", f"{kind} of the plate", {"share": ("1", share)}, _scaled(kind))
    for axis, length in (("x", plate.length_x), ("y", plate.length_y)):
        yield from _quantity(
            f"plate_length_{axis}",
            f"length of the plate along {axis}",
            {"longer": ("m", given.of(f"plate.length_{axis}", given.length))},
            _stretched(axis, length, experiment.patch, _scanned(experiment, axis)),
        )
    yield from _oven(experiment)
    if experiment.unseen_lag:
        yield from _lag(experiment)


def _oven(experiment: Experiment) -> Iterator[Effect]:
    """Temperature of the plate less the reading: an offset at room temperature, and a slope."""
    given = experiment.tolerances
    wanted = {"offset": ("K", given.oven_offset), "slope": ("1", given.oven_slope)}

    def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
        warmer = circumstances.point.temperature - circumstances.room_temperature
        away = values.get("offset", 0.0) + values.get("slope", 0.0) * warmer
        return state.with_(temperature=state.temperature + away)

    card = _card("oven_reading", "temperature of the plate less the oven's reading", wanted)
    if card is not None:
        yield Effect(lambda _: card, apply)


def _lag(experiment: Experiment) -> Iterator[Effect]:
    """Lag of the plate behind the air, as `simulation.effects.thermal_lag`; one ramp cannot tell it."""
    card = _card(
        "plate_lag", "lag of the plate behind the air", {"behind": ("s", experiment.tolerances.plate_lag)}
    )

    def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
        behind = values.get("behind", 0.0) * circumstances.point.rate
        return state.with_(temperature=state.temperature - behind)

    if card is not None:
        yield Effect(lambda _: card, apply)


def _of_patches(experiment: Experiment, movable: Real) -> Iterator[Effect]:
    given, count = experiment.tolerances, len(experiment.patch)
    for k, patch in enumerate(experiment.patch):
        name = patch.id
        centre = given.of(f"patch.{name}.center", given.patch_place)
        size = given.of(f"patch.{name}.size", given.patch_size)
        thickness = given.of(f"patch.{name}.thickness", given.patch_thickness * patch.thickness) / patch.thickness
        if movable[k]:
            yield from _quantity(
                f"patch_place {name}",
                f"place of patch {name}",
                {"dx": ("m", centre), "dy": ("m", centre)},
                _moved("shift_x", "shift_y", k, count),
            )
            yield from _quantity(
                f"patch_size {name}",
                f"sides of patch {name}",
                dict.fromkeys(SIDES if patch.diameter is None else ROUND, ("m", size)),
                _enlarged(k, count, patch),
            )
        shares = {
            "patch_thickness": (f"thickness of patch {name}", thickness),
            "patch_modulus": (f"stiffness of patch {name}", given.patch_modulus),
            "strain_constant": (f"strain constant d31 of patch {name}", given.strain_constant),
            "permittivity": (f"permittivity of patch {name}", given.permittivity),
        }
        if patch.role != "sensor" or patch.quantity == "charge":  # its voltage is given, or kept at zero
            del shares["permittivity"]
        for kind, (words, tolerance) in shares.items():
            yield from _quantity(
                f"{kind} {name}", words, {"share": ("1", tolerance)}, _scaled_of(kind, k, count, 1.0, "share")
            )


def _of_instruments(experiment: Experiment) -> Iterator[Effect]:
    given = experiment.tolerances
    if any(one.patch is not None and one.quantity == "voltage" for one in experiment.outputs):
        for kind in ("resistance", "capacitance"):
            declared = getattr(experiment.acquisition, f"input_{kind}")
            usual = getattr(given, f"input_{kind}")
            own = given.of(f"acquisition.input_{kind}", usual * declared)
            share = own / declared if declared else 0.0
            yield from _quantity(f"input_{kind}", f"{kind} of the inputs", {"share": ("1", share)}, _scaled(kind))
    yield from _sensitivities(experiment)
    placed = (*experiment.inputs, *experiment.outputs)
    feet = [channel for channel in placed if channel.footprint is not None]
    yield from _contacts(experiment, [channel.id for channel in feet])
    if len(feet) > MOST_PLACED:  # a scan: its points are known by their grid, which lies somewhere on the plate
        place = given.transducer_place
        yield from _quantity(
            "scan_place",
            "place of all points of the scan",
            {"dx": ("m", place), "dy": ("m", place)},
            _moved("place_x", "place_y", slice(None), len(feet)),
        )
        return
    for k, channel in enumerate(feet):
        table = "drive" if k in experiment.driven else "sensor"
        place = given.of(f"{table}.{channel.id}.point", given.transducer_place)
        yield from _quantity(
            f"transducer_place {channel.id}",
            f"place of {channel.id}",
            {"dx": ("m", place), "dy": ("m", place)},
            _moved("place_x", "place_y", k, len(feet)),
        )
        if channel.footprint is not None and channel.footprint.mass:
            yield from _quantity(
                f"transducer_mass {channel.id}",
                f"mass of {channel.id}",
                {"heavier": ("kg", given.of(f"sensor.{channel.id}.mass", given.transducer_mass))},
                _added_to("added_mass", np.arange(len(feet)) == k, "heavier"),
            )


def _scanned(experiment: Experiment, axis: str) -> Real:
    """Coordinates (S,) of a scan's points, m, which were measured on the plate, however long it is; else none."""
    points = [one.point[axis == "y"] for one in experiment.footprints]
    return np.array(points if len(points) > MOST_PLACED else [])


def _contacts(experiment: Experiment, feet: Sequence[str]) -> Iterator[Effect]:
    """Discs over which forces act and motions are felt: one of every instrument, with all its points."""
    given = experiment.tolerances
    placed: list[tuple[str, Drive | Sensor, list[str]]] = [
        *(("drive", one, [one.id]) for one in experiment.drive[:MOST_PLACED]),
        *(("sensor", one, [point.id for point in one.channels(experiment.plate)]) for one in experiment.sensor),
    ]
    for table, one, own in placed:
        radius, place = one.contact_radius, f"{table}.{one.id}.radius"
        if radius > 0.0:  # a laser's spot is a point
            share = 2.0 * given.own[place] / radius if place in given.own else given.transducer_contact
            yield from _quantity(
                f"transducer_contact {one.id}",
                f"contact area of {one.id}",
                {"larger": ("1", share)},
                _added_to("contact", np.isin(feet, own), "larger"),
            )


def _sensitivities(experiment: Experiment) -> Iterator[Effect]:
    """One of every instrument: a laser's points, or those of a hammer, were all measured by the same."""
    outputs = [output.id for output in experiment.outputs]
    if len(experiment.sensors) + len(experiment.sensor) < 2:  # of a single one it is the gain
        return
    for sensor in experiment.sensor:
        own = [channel.id for channel in sensor.channels(experiment.plate)]
        yield from _quantity(
            f"sensitivity {sensor.id}",
            f"sensitivity of {sensor.id}",
            {"share": ("1", experiment.tolerances.sensitivity)},
            _added_to("log_sensitivity", np.isin(outputs, own), "share"),
        )


def _of_attachments(experiment: Experiment) -> Iterator[Effect]:
    """Places of strings and cables, as far as the twin has to know them: where an effect acts there."""
    places = [*(f"string {k + 1}" for k in range(len(experiment.string)))]
    places += [f"cable {k + 1}" for k in range(len(experiment.cable))]
    tolerance = experiment.tolerances.attachment_place
    for k, name in enumerate(places):
        yield from _quantity(
            f"attachment_place {name}",
            f"place of {name}",
            {"dx": ("m", tolerance), "dy": ("m", tolerance)},
            _moved("attached_x", "attached_y", k, len(places)),
        )


def _of_undeclared(experiment: Experiment) -> Iterator[Effect]:
    yield from _quantity(
        "place_contact",
        "compliance under an undeclared attachment",
        {"share": ("1", experiment.tolerances.place_contact)},
        _scaled("place_compliance"),
    )


def _of_the_theory(experiment: Experiment) -> Iterator[Effect]:
    """Shear across an isotropic plate; what elasticity adds to the theory, which is not known on curved plates."""
    if isotropic(experiment):
        shear = {"share": ("1", experiment.tolerances.plate_shear)}
        across, along = _scaled("shear_x"), _scaled("shear_y")
        yield from _quantity(
            "plate_shear",
            "transverse shear modulus of the plate",
            shear,
            lambda away, values: across(away, values) | along(away, values),
        )
    if experiment.plate.curvature is None:
        yield from _quantity(
            "plate_theory",
            "elasticity beyond Mindlin's plate",
            {"share": ("1", experiment.tolerances.plate_theory)},
            lambda away, values: {"momentum": away.momentum + values["share"]},
        )


SIDES, ROUND = ("along", "across"), ("wider",)
"""What of a patch may be larger: its first side and its second; of a round one, its diameter."""
MOST_PLACED = 12
"""Number of transducers up to which each has a place of its own to be wrong."""


def _quantity(name: str, words: str, wanted: dict[str, tuple[str, float]], change: Change) -> Iterator[Effect]:
    """Yield a quantity with its parameters, {name: (unit, tolerance)}, unless all of them are exact."""
    card = _card(name, words, wanted)
    if card is None:
        return

    def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
        return state.with_(departures=replace(state.departures, **change(state.departures, values)))

    yield Tolerance(lambda _: card, apply, change=change)


def _card(name: str, words: str, wanted: dict[str, tuple[str, float]]) -> EffectCard | None:
    parameters = tuple(
        Parameter(
            key, unit, -RANGE_IN_TOLERANCES * tolerance, RANGE_IN_TOLERANCES * tolerance, tolerance, declared=True
        )
        for key, (unit, tolerance) in wanted.items()
        if tolerance > 0.0
    )
    if not parameters:
        return None
    return EffectCard(name, words, parameters, "nothing: it is always free", "measure it more exactly")


def _scaled(attribute: str, factor: float = 1.0, key: str = "share") -> Change:
    """Scale by an exponential: what a modulus, a thickness and lengths do together adds up, however large each is.

    With shares added to 1, a fit along what they cannot tell apart bends, and takes three times the steps.
    """
    return lambda away, values: {attribute: getattr(away, attribute) * np.exp(factor * values[key])}


def _scaled_of(attribute: str, place: int, count: int, factor: float, key: str) -> Change:
    unit = np.arange(count) == place

    def change(away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        return {attribute: getattr(away, attribute) * np.exp(unit * (factor * values[key]))}

    return change


def _added_to(attribute: str, places: NDArray[np.bool_], key: str) -> Change:
    def change(away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        return {attribute: getattr(away, attribute) + places * values[key]}

    return change


def _stretched(axis: str, length: float, patches: Sequence[Patch], scanned: Real) -> Change:
    """Stretch the plate with its patches, which keep their size: they are as much smaller along that axis.

    Points of a scan (S,) stay where they are: they were as far from the plate's origin, however long it is.
    """
    longer = _scaled(f"stretch_{axis}", 1.0 / length, "longer")
    turn = np.array([0.0 if axis == "x" else 90.0]) - [patch.angle for patch in patches]
    share = np.array([np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))]) ** 2
    smaller = share * np.reshape([patch.size for patch in patches], (-1, 2)).T

    def change(away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        lost = smaller * (values["longer"] / length)
        sides = {name: getattr(away, name) - one for name, one in zip(SIDES, lost, strict=True)}
        place = f"place_{axis}"
        held = {place: getattr(away, place) - scanned * (values["longer"] / length)} if scanned.size else {}
        return {**longer(away, values), **(sides if patches else {}), **held}

    return change


def _enlarged(place: int, count: int, patch: Patch) -> Change:
    """Make a patch larger, along each of its sides or, where it is round, along both."""
    here = np.arange(count) == place

    def change(away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        larger = [values.get(name, values.get(ROUND[0])) for name in SIDES]
        area = sum(more / side for more, side in zip(larger, patch.size, strict=True))
        sides = {name: getattr(away, name) + here * more for name, more in zip(SIDES, larger, strict=True)}
        return {**sides, "patch_area": away.patch_area * np.exp(here * area)}

    return change


def _moved(along_x: str, along_y: str, place: int | slice, count: int) -> Change:
    here = np.zeros(count, dtype=bool)
    here[place] = True
    x, y = _added_to(along_x, here, "dx"), _added_to(along_y, here, "dy")
    return lambda away, values: {**x(away, values), **y(away, values)}


UNDECLARED_TOLERANCE = 1.5
"""Tolerance of the logarithm of a transverse shear modulus that is not declared: that of wood's yz plane is a
twentieth, those of laminates are a half to one of the shear modulus in the plane."""


def sheet_tolerances(experiment: Experiment) -> Iterator[Effect]:
    """Yield the quantities of a declared orthotropic sheet that are not exact; none for an isotropic one.

    All are natural logarithms of ratios, see `simulation.state.plate_state`.
    """
    material, given = experiment.plate.material, experiment.tolerances
    sheet = None if material is None else material.departure
    if sheet is None:
        return
    each = float(np.sqrt(2.0)) * given.moduli  # a ratio of two, each known so well
    yield from _sheet_quantity(
        MODULI,
        "moduli of the sheet, over their mean",
        {"ratio": each, "shear": each},
        FARTHEST_MODULI,
        lambda v: departed_moduli(sheet, v.get("ratio", 0.0), v.get("shear", 0.0)),
    )
    across = (
        given.transverse_shear if sheet.declared_transverse or not given.transverse_shear else UNDECLARED_TOLERANCE
    )
    yield from _sheet_quantity(
        TRANSVERSE,
        "transverse shear moduli of the sheet",
        {"xz": across, "yz": across},
        FARTHEST_SHEAR,
        lambda v: departed_transverse(v["xz"], v["yz"]),
    )
    yield from _sheet_quantity(
        LOSS,
        "loss factors of the sheet by direction",
        {"ratio": given.loss_direction, "shear": given.loss_direction},
        FARTHEST_LOSS,
        lambda v: departed_loss(v["ratio"], v["shear"]),
    )


def _sheet_quantity(
    name: str,
    words: str,
    wanted: Mapping[str, float],
    farthest: float,
    factors: Callable[[Mapping[str, Any]], dict[str, Any]],
) -> Iterator[Effect]:
    """Yield a quantity with its parameters, {name: tolerance}, unless it is exact."""
    if not all(tolerance > 0.0 for tolerance in wanted.values()):
        return
    parameters = tuple(
        Parameter(key, "log", -reach, reach, tolerance, declared=True)
        for key, tolerance in wanted.items()
        for reach in (min(farthest, RANGE_IN_TOLERANCES * tolerance),)
    )
    card = EffectCard(name, words, parameters, "nothing: it is always free", "cut strips and measure their moduli")

    def change(away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        return {attribute: getattr(away, attribute) * share for attribute, share in factors(values).items()}

    def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
        return state.with_(departures=replace(state.departures, **change(state.departures, values)))

    yield Tolerance(lambda _: card, apply, change=change)
