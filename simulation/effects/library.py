"""The project's effects in the order of application, and a user's own: Python files, each defining EFFECT.

Requirements on every effect: no change at zero amplitude, and correct derivatives by a complex step.

Candidates only beside another effect: a second of two alike, and the size of a damaged spot.
"""

import importlib.util
from collections.abc import Container, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from analysis.material import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from simulation.effects import (
    accelerometer_mass,
    air_loading,
    amplitude_softening,
    annealing,
    bond_shear_lag,
    cable_stiffness,
    channel_skew,
    crosstalk,
    damage_size,
    damping_dispersion,
    dashpot_at_place,
    density_gradient,
    depolarization,
    draught_gradient,
    elastic_foundation,
    feedthrough,
    fractional_viscosity,
    high_pass,
    insulation_leak,
    local_damage,
    loss_orthotropy,
    low_pass,
    mass_at_place,
    modulus_gradient,
    mounting_resonance,
    orthotropy,
    patch_debond,
    patch_loss,
    permittivity_drift,
    piezo_drift,
    piezo_loss,
    piezo_nonlinearity,
    point_mass,
    poisson_loss,
    relaxation,
    resonator_at_place,
    sensor_offset,
    spring_at_place,
    string_mass,
    surface_damping,
    suspension,
    thermal_crown,
    thermal_gradient,
    thermal_lag,
    thickness_crown,
    thickness_taper,
    transverse_shear,
    viscoelastic_dispersion,
)
from simulation.effects.effect import Effect
from simulation.reduction.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE
from simulation.state.field_basis import field_basis, polynomial, polynomials
from simulation.state.plate_state import Circumstances, PlateState
from simulation.tolerances import tolerances

LIBRARY: Mapping[str, Effect] = MappingProxyType(
    {
        # First the plate's mean temperature, because other effects depend on it.
        "thermal_lag": thermal_lag.EFFECT,
        # Effects that depend on the plate's temperature, or on no temperature.
        "orthotropy": orthotropy.EFFECT,
        "loss_orthotropy": loss_orthotropy.EFFECT,
        "poisson_loss": poisson_loss.EFFECT,
        "transverse_shear": transverse_shear.EFFECT,
        "modulus_gradient": modulus_gradient.EFFECT,
        "density_gradient": density_gradient.EFFECT,
        "thickness_taper": thickness_taper.EFFECT,
        "thickness_crown": thickness_crown.EFFECT,
        "suspension": suspension.EFFECT,
        "string_mass": string_mass.EFFECT,
        "point_mass": point_mass.EFFECT,
        "cable_stiffness": cable_stiffness.EFFECT,
        "accelerometer_mass": accelerometer_mass.EFFECT,
        "bond_shear_lag": bond_shear_lag.EFFECT,
        "patch_debond": patch_debond.EFFECT,
        "patch_loss": patch_loss.EFFECT,
        "piezo_drift": piezo_drift.EFFECT,
        "permittivity_drift": permittivity_drift.EFFECT,
        "insulation_leak": insulation_leak.EFFECT,
        "piezo_loss": piezo_loss.EFFECT,
        "piezo_nonlinearity": piezo_nonlinearity.EFFECT,
        "depolarization": depolarization.EFFECT,
        "viscoelastic_dispersion": viscoelastic_dispersion.EFFECT,
        "fractional_viscosity": fractional_viscosity.EFFECT,
        "relaxation": relaxation.EFFECT,
        "damping_dispersion": damping_dispersion.EFFECT,
        "annealing": annealing.EFFECT,
        "air_loading": air_loading.EFFECT,
        "elastic_foundation": elastic_foundation.EFFECT,
        "surface_damping": surface_damping.EFFECT,
        "local_damage": local_damage.EFFECT,
        "mass_at_place": mass_at_place.EFFECT,
        "spring_at_place": spring_at_place.EFFECT,
        "dashpot_at_place": dashpot_at_place.EFFECT,
        "resonator_at_place": resonator_at_place.EFFECT,
        "sensor_offset": sensor_offset.EFFECT,
        "channel_skew": channel_skew.EFFECT,
        "high_pass": high_pass.EFFECT,
        "low_pass": low_pass.EFFECT,
        "mounting_resonance": mounting_resonance.EFFECT,
        "feedthrough": feedthrough.EFFECT,
        "crosstalk": crosstalk.EFFECT,
        "amplitude_softening": amplitude_softening.EFFECT,
        # Last the temperature gradients, because afterwards the mean over unevenly spaced points is no longer the
        # plate's temperature; the one that uses this temperature comes first.
        "thermal_gradient": thermal_gradient.EFFECT,
        "thermal_crown": thermal_crown.EFFECT,
        "draught_gradient": draught_gradient.EFFECT,
    }
)
"""By name, in the order of application."""


def library(experiment: Experiment, folder: Path | None = None) -> dict[str, Effect]:
    """Return the effects for which `experiment` declares enough, by name, in the order of application.

    Those of the Python files in `folder` follow the project's own, by file name, and act on the resulting state.
    ValueError as from `load_folder`.
    """
    return {name: effect for name, effect in _all(experiment, folder).items() if effect.available(experiment)}


def untried(experiment: Experiment, folder: Path | None = None) -> dict[str, str]:
    """Say what `experiment` must declare for the effects that `library` leaves out, by effect."""
    return {
        name: effect.wants or effect.card(experiment).needs
        for name, effect in _all(experiment, folder).items()
        if not (effect.nothing_missing or effect.available(experiment))
    }


def _all(experiment: Experiment, folder: Path | None) -> dict[str, Effect]:
    if folder is None:
        return dict(LIBRARY)
    declared = tolerances(experiment, np.ones(len(experiment.patch)))
    return {**LIBRARY, **load_folder(folder, experiment, taken={**LIBRARY, **declared})}


def apply_all(
    effects: Mapping[str, Effect],
    state: PlateState,
    circumstances: Circumstances,
    values: Mapping[str, Mapping[str, Any]],
) -> PlateState:
    """Apply those effects that have values, in the order of `effects`.

    With a value v + 1j * step, every number of the state has step times its derivative as imaginary part.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping of str to mapping
        Parameter values of every effect that is on, in the units of its card.

    Raises
    ------
    ValueError
        For values of an effect that is not among `effects`.
    """
    for name in values:
        if name not in effects:
            raise ValueError(f"no effect is named {name!r}; there are {', '.join(effects)}")
    for name, effect in effects.items():
        if name in values:
            state = effect.apply(state, circumstances, values[name])
    return state


TWICE = ("mass_at_place", "spring_at_place")
"""Effects of which a plate may have two. Without a second mass a resonator far above the band stood for it: on an
aluminium L 3 g and 2 g were named a resonator of 2.2 g at 1680 Hz, and 2.1 g."""


def seconds(library: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return what is a candidate once an effect of a library is on, by name."""
    twice = {f"second_{name}": _second(library[name], name) for name in TWICE if name in library}
    return twice | ({"damage_size": damage_size.EFFECT} if "local_damage" in library else {})


def _second(first: Effect, name: str) -> Effect:
    def card(experiment: Experiment) -> EffectCard:
        known = first.card(experiment)
        return replace(
            known,
            name=f"second_{name}",
            summary=f"beside {name}, a second one: {known.summary}",
            title=f"second {known.said}",
            after=name,
        )

    return replace(first, card=card)


def load_folder(folder: Path, experiment: Experiment, taken: Container[str] = ()) -> dict[str, Effect]:
    """Run every ``*.py`` of `folder` and return their effects by name, in the order of the files' names.

    Files whose names begin with an underscore are ignored.

    Parameters
    ----------
    experiment : Experiment
        Declaration for which the effects are made and verified.
    taken : container of str
        Names already used in the library.

    Raises
    ------
    ValueError
        With the file and the error: it raises, defines no EFFECT, has an invalid card or a name that is `taken`
        (or another file's), or fails `verify`. Also if `folder` is no folder or contains no effect.
    """
    if not folder.is_dir():
        raise ValueError(f"{folder}: not a folder; a folder of Python files that define EFFECT is wanted")
    loaded: dict[str, Effect] = {}
    origin: dict[str, Path] = {}
    for file in sorted(folder.glob("[!_]*.py")):
        effect, name = _checked(file, experiment)
        if name in taken:
            raise ValueError(f"{file}: its effect is called {name!r}, which the library has already; rename it")
        if name in loaded:
            raise ValueError(f"{file}: its effect is called {name!r}, as that of {origin[name].name}; rename one")
        loaded[name], origin[name] = effect, file
    if not loaded:
        raise ValueError(f"{folder}: holds no *.py file; an effect is a Python file that defines EFFECT")
    return loaded


def _checked(file: Path, experiment: Experiment) -> tuple[Effect, str]:
    """Return the effect of a file and its name."""
    effect = getattr(_run(file), "EFFECT", None)
    if not isinstance(effect, Effect):
        found = "no EFFECT" if effect is None else f"an EFFECT that is a {type(effect).__name__}"
        raise ValueError(f"{file}: defines {found}; EFFECT = Effect(card, apply) is wanted")
    try:
        card = effect.card(experiment)
        wanted = effect.available(experiment)
    except Exception as error:
        raise ValueError(f"{file}: its card cannot be made: {type(error).__name__}: {error}") from error
    if not isinstance(card, EffectCard):
        raise ValueError(f"{file}: card returns a {type(card).__name__}; an EffectCard is wanted")
    if wanted:
        try:
            verify(effect, experiment)
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from error
    return effect, card.name


def _run(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"user_effect_{file.stem}", file)
    if spec is None or spec.loader is None:
        raise ValueError(f"{file}: Python knows no way to import it")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise ValueError(f"{file}: cannot be run: {type(error).__name__}: {error}") from error
    return module


COMPLEX_STEP = 1e-30
"""Complex step, in prior sigma of the parameter; it may be tiny because nothing is subtracted."""
REAL_STEP = 1e-4
"""Step of central differences, in prior sigma of the parameter."""
LARGEST_DIFFERENCE = 1e-5
"""Largest relative difference of the two derivatives; central differences are accurate to about 1e-8."""
STEEPEST_AT_ZERO = 1e3
"""Largest slope at zero over the mean slope to a third of a sigma: the slope of a square root is infinite."""

FIELD_DEGREES = {
    "temperature": BENDING_DEGREE,
    "thickness": BENDING_DEGREE,
    "modulus": BENDING_DEGREE,
    "density": MEMBRANE_DEGREE,
}
"""Fields of a state, and the degree up to which the twin keeps each."""
LARGEST_LOST = 0.2
"""Largest share (rms over the plate) of a field's change that the twin may lose."""

SPECTRA = ("storage", "loss", "area_mass", "area_resistance", "log_gain", "phase")
"""Attributes of a state with one value per line."""


def verify(effect: Effect, experiment: Experiment) -> None:
    """Raise ValueError, with the reason, unless an effect can be used in the search.

    Requirements, at three sweeps with different temperature, rate and level: with all amplitudes zero the state is
    not changed, whatever the shapes; derivatives by a complex step equal those by central differences, for every
    number of the state; every amplitude has a slope at zero that is finite, and nonzero at one sweep at least,
    because the score test uses this slope. An effect that depends on strain energy does so line by line, in
    spectra only, and accepts complex energies. What it changes of a field is smooth over the plate, because the
    twin keeps fields as polynomials of low degree.
    """
    card = effect.card(experiment)
    idle = {parameter.name for parameter in card.amplitudes}
    axis = np.array([-1.0, -0.4, 0.3, 1.0])
    try:
        for circumstances, state in _trials(experiment, *_grid(axis)):
            _check_absent(effect, card, state, circumstances)
            _check_derivatives(effect, card, state, circumstances)
            _check_energy(effect, card, state, circumstances)
            idle -= _slopes_at_zero(effect, card, state, circumstances)
        _check_fields(effect, card, experiment)
    except ValueError:
        raise
    except Exception as error:  # a user's own code may raise anything
        raise ValueError(f"apply fails: {type(error).__name__}: {error}") from error
    if idle:
        raise ValueError(
            f"{', '.join(sorted(idle))}: no slope at zero in anything of the state, at any sweep tried"
        )


def numbers(state: PlateState) -> dict[str, NDArray[Any]]:
    """All numbers of a state, as flat arrays by attribute, to compare two states.

    Loads and attachments without stiffness, damping and mass, and discs without loss, are left out.
    """
    loads = [load for load in state.point_loads if load.stiffness or load.damping or load.mass]
    attached = [one for one in state.attached if np.any(one.stiffness) or np.any(one.loss)]
    discs = [disc for disc in state.discs if disc.loss]
    flat = {
        "point_loads": [(*load.point, load.stiffness, load.damping, load.mass) for load in loads],
        "attached": [np.hstack([one.x, one.y, one.stiffness, one.loss]) for one in attached],
        "discs": [(disc.x, disc.y, disc.radius, disc.loss) for disc in discs],
        "laws": [state.laws.value, state.laws.slope, state.laws.curvature, np.full(3, state.laws.reference)],
    }
    others = {name: value for name, value in vars(state).items() if name not in (*flat, "departures")}
    departures = {f"departures.{name}": value for name, value in vars(state.departures).items()}
    return {name: np.ravel(value) for name, value in {**others, **flat, **departures}.items()}


def interior_point(card: EffectCard, site: Mapping[str, float]) -> dict[str, float]:
    """Return values with every amplitude a third of a sigma inside its range, and shapes moved off the site."""
    starts = card.zero(site)
    return {parameter.name: _inside(parameter, starts[parameter.name]) for parameter in card.parameters}


def _inside(parameter: Parameter, start: float) -> float:
    """Move up by a third of a sigma if the range allows it, else down, at most half-way to its end."""
    away, up, down = parameter.sigma / 3.0, parameter.high - start, start - parameter.low
    return start + min(away, 0.5 * up) if up > 0.0 else start - min(away, 0.5 * down)


def _grid(axis: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (Q,) along xi and zeta, those of `axis` along both."""
    xi, zeta = np.meshgrid(axis, axis)
    return xi.ravel(), zeta.ravel()


def _trials(
    experiment: Experiment, xi: NDArray[np.float64], zeta: NDArray[np.float64]
) -> list[tuple[Circumstances, PlateState]]:
    """Circumstances and states, at points (Q,), of three sweeps of a plate with steep laws."""
    low, high = experiment.protocol.band
    frequency = np.geomspace(low, high, 7)
    laws = LocalLaws(
        reference=30.0,
        value=np.array([np.log(2e9), 0.38, np.log(0.06)]),
        slope=np.array([-0.02, 0.002, -0.01]),
        curvature=np.array([1e-4, 1e-5, 1e-4]),
    )
    rate = experiment.protocol.ramp_rate / 60.0 or 0.01
    points = [SweepPoint(10.0, rate, 1.0), SweepPoint(45.0, -rate, 1.0), SweepPoint(45.0, rate, 2.0)]
    trials = []
    for point in points:
        declared = Circumstances.of(experiment, point, frequency)
        energy = point.level**2 * np.linspace(0.05, 0.9, frequency.size)
        circumstances = replace(declared, strain_energy=energy)
        trials.append((circumstances, PlateState.baseline(xi, zeta, laws, point.temperature, frequency)))
    return trials


def _check_absent(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> None:
    before = numbers(state)
    for site in (*card.sites, {}):
        after = numbers(effect.apply(state, circumstances, card.zero(site)))
        for name, value in before.items():
            if not _same(after[name], value):
                raise ValueError(f"changes {name} although all its amplitudes are zero")


def _same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    """Whether two attributes are equal; one number may stand for many, as in `Departures`."""
    if a.size != b.size and 1 not in (a.size, b.size):
        return False
    return bool((a == b).all())


def _check_derivatives(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> None:
    base = interior_point(card, card.sites[len(card.sites) // 2])
    for parameter in card.parameters:

        def moved(step: complex, name: str = parameter.name) -> dict[str, NDArray[Any]]:
            return numbers(effect.apply(state, circumstances, {**base, name: base[name] + step}))

        tiny, small = COMPLEX_STEP * parameter.sigma, REAL_STEP * parameter.sigma
        stepped, above, below = moved(1j * tiny), moved(small), moved(-small)
        for name, value in stepped.items():
            if not all(np.isfinite(those).all() for those in (value, above[name], below[name])):
                raise ValueError(f"{parameter.name}: {name} is not finite near {base}")
            exact = np.imag(value) / tiny
            central = np.real(above[name] - below[name]) / (2.0 * small)
            scale = max(_largest(exact), _largest(central))
            if _largest(exact - central) > LARGEST_DIFFERENCE * scale + 1e-12 * _largest(np.real(value)) / small:
                raise ValueError(
                    f"{parameter.name}: a complex step in it does not give the slope of {name}; "
                    "abs, float, real, comparisons and the math module lose the imaginary part"
                )


def _check_fields(effect: Effect, card: EffectCard, experiment: Experiment) -> None:
    """Compare what it changes of each field over the plate with what the twin keeps of that."""
    basis = field_basis(BENDING_DEGREE)
    everywhere = _grid((np.arange(EVERYWHERE) + 0.5) / EVERYWHERE * 2.0 - 1.0)
    terms = {
        degree: np.array([polynomial(one, *everywhere) for one in polynomials(degree)])
        for degree in set(FIELD_DEGREES.values())
    }
    at = interior_point(card, card.sites[len(card.sites) // 2])
    sampled = _trials(experiment, basis.xi, basis.zeta)
    for (circumstances, few), (_, many) in zip(sampled, _trials(experiment, *everywhere), strict=True):
        changed, true = effect.apply(few, circumstances, at), effect.apply(many, circumstances, at)
        for name, degree in FIELD_DEGREES.items():
            change = np.real(getattr(true, name) - getattr(many, name)) * np.ones(len(many.xi))
            seen = np.real(getattr(changed, name) - getattr(few, name)) * np.ones(len(few.xi))
            kept = field_basis(degree).coefficients(seen) @ terms[degree]
            whole, lost = np.linalg.norm(change), np.linalg.norm(change - kept)
            rounding = 1e-9 * np.linalg.norm(getattr(many, name))
            if lost > LARGEST_LOST * whole + rounding:
                raise ValueError(
                    f"the twin loses {100.0 * lost / whole:.0f} % of what it changes of {name}: it keeps a field "
                    f"as a polynomial of degree {degree} over the plate, and no step, strip or spot is one; use "
                    "discs, attached or point_loads for what acts at a place"
                )


EVERYWHERE = 48
"""Points along each side at which a field is compared with what is kept of it."""


def _check_energy(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> None:
    """Step the energy of one line: only that line of spectra may change, with the correct slope."""
    if not effect.needs_strain_energy:
        return
    at, line = interior_point(card, card.sites[len(card.sites) // 2]), circumstances.frequency.size // 2

    def moved(step: complex) -> dict[str, NDArray[Any]]:
        energy = circumstances.strain_energy + step * np.eye(circumstances.frequency.size)[line]
        return numbers(effect.apply(state, replace(circumstances, strain_energy=energy), at))

    stepped, above, below = moved(1j * COMPLEX_STEP), moved(REAL_STEP), moved(-REAL_STEP)
    for name, value in stepped.items():
        exact = np.imag(value) / COMPLEX_STEP
        central = np.real(above[name] - below[name]) / (2.0 * REAL_STEP)
        scale = max(_largest(exact), _largest(central))
        if _largest(exact - central) > LARGEST_DIFFERENCE * scale + 1e-12 * _largest(np.real(value)) / REAL_STEP:
            raise ValueError(f"a complex step in strain_energy does not give the slope of {name}")
        elsewhere = exact != 0.0
        if name in SPECTRA:
            elsewhere[line] = False
        if elsewhere.any():
            raise ValueError(
                f"{name} follows the strain energy of another line; each line of "
                f"{', '.join(SPECTRA)} may follow its own, and nothing else"
            )


def _slopes_at_zero(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> set[str]:
    """Return the amplitudes with a nonzero slope at zero; ValueError for one without a finite slope there."""
    zero, alive = card.zero(card.sites[len(card.sites) // 2]), set()
    for parameter in card.amplitudes:
        tiny, away = COMPLEX_STEP * parameter.sigma, _inside(parameter, 0.0)
        near = numbers(effect.apply(state, circumstances, {**zero, parameter.name: 1j * tiny}))
        far = numbers(effect.apply(state, circumstances, {**zero, parameter.name: away}))
        for name, value in near.items():
            slope = _largest(np.imag(value)) / tiny
            mean = _largest(far[name] - np.real(value)) / abs(away)
            if not slope <= STEEPEST_AT_ZERO * mean + 1e-12 * _largest(np.real(value)) / abs(away):
                raise ValueError(f"{parameter.name}: the slope of {name} is not finite at zero")
            if slope > 0.0:
                alive.add(parameter.name)
    return alive


def _largest(values: NDArray[Any]) -> float:
    return float(np.abs(values).max(initial=0.0))
