"""Reduced matrices of a plate in one state, summed from the operators."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from analysis.arrays import Numbers, Real
from simulation.reduction.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE, EffectOperators, monomials
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import MOVES, Departures, PlateState

COMPLEX_STEP = 1e-30
"""Complex step of a parameter for derivatives: far below rounding of the real part."""


@dataclass(frozen=True)
class Coefficients:
    """Factors of the stacks of `EffectOperators`; complex for a state with a complex step.

    Attributes
    ----------
    bending, bending_loss, membrane, membrane_loss : (4, terms) ndarray
        Pa.
    shear, shear_loss : (S, terms) ndarray
        Pa.
    mass, rotary : (terms,) ndarray
    patch : (1 + 2 terms,) ndarray
    coupling : (1 + terms,) ndarray
    offset : (monomials,) ndarray
    patch_alone, patch_thicker, patch_mass : (P,) ndarray
        Of each patch, to be added to all of them.
    patch_modulus : (P,) ndarray
        Factor on the stiffness of each patch that moves.
    columns : (P,) ndarray
        Factor on the coupling of each patch.
    moves : (P, 4) ndarray
        Of each patch along x, along y, and of its sides, m: `composed` leaves them out.
    momentum : float
    patch_loss : (1 + 2 terms,) ndarray
        Loss factor times `patch`.
    """

    bending: Numbers
    bending_loss: Numbers
    membrane: Numbers
    membrane_loss: Numbers
    shear: Numbers
    shear_loss: Numbers
    mass: Numbers
    rotary: Numbers
    patch: Numbers
    coupling: Numbers
    offset: Numbers
    patch_alone: Numbers
    patch_modulus: Numbers
    patch_thicker: Numbers
    patch_mass: Numbers
    columns: Numbers
    moves: Numbers
    momentum: Any
    patch_loss: Numbers

    @classmethod
    def of(cls, state: PlateState, ops: EffectOperators) -> Self:
        """Project the fields of `state`, given at the points of `field_basis`, and its departures."""
        fine, coarse = field_basis(BENDING_DEGREE), field_basis(MEMBRANE_DEGREE)
        nu = state.laws.poisson_ratio(state.temperature)
        c1 = state.modulus * state.laws.youngs_modulus(state.temperature) / (1.0 - nu**2)
        loss = state.laws.loss_factor(state.temperature)
        lossy = [loss * one for one in (state.loss_x, state.loss_y, state.loss_cross, state.loss_shear)]
        shear = 0.5 * c1 * (1.0 - nu)
        moduli = [
            c1 * state.modulus_x,
            c1 * state.modulus_y,
            c1 * nu * np.sqrt(state.modulus_x * state.modulus_y),
            shear * state.in_plane_shear,
        ]
        away = state.departures
        moduli = [m * share for m, share in zip(moduli, away.in_plane, strict=True)]
        across = [
            shear * state.transverse_shear * share for share in (away.shear_x, away.shear_y)[: len(ops.shear)]
        ]
        lossy = [part * share for part, share in zip(lossy, away.lost, strict=True)]
        h = state.thickness * away.thickness
        tau, area = h - 1.0, away.stretch_x * away.stretch_y
        # the plate was weighed: what it has more in volume, it has less in density
        density = state.density * away.mass / (away.thickness * area)
        moduli = [m * stretched for m, stretched in zip(moduli, _stretched(away, ops.angle), strict=True)]
        one, patches = np.ones(1), np.ones(ops.coupling.shape[-1])
        terms, few = ops.bending.shape[1], ops.membrane.shape[1]
        thicker = patches * (away.patch_thickness - 1.0)
        reach = ops.offset_range or 1.0
        layers = [one, fine.coefficients(tau)[:terms], fine.coefficients(tau**2)[:terms]]
        held = state.bond * np.concatenate(layers)
        return cls(
            bending=np.array([fine.coefficients(m * h**3)[:terms] for m in moduli]),
            bending_loss=np.array(
                [fine.coefficients(m * part * h**3)[:terms] for m, part in zip(moduli, lossy, strict=True)]
            ),
            membrane=np.array([coarse.coefficients(m * h)[:few] for m in moduli]),
            membrane_loss=np.array(
                [coarse.coefficients(m * part * h)[:few] for m, part in zip(moduli, lossy, strict=True)]
            ),
            shear=np.array([coarse.coefficients(g * h)[:few] for g in across]),
            shear_loss=np.array([coarse.coefficients(g * lossy[-1] * h)[:few] for g in across]),
            mass=coarse.coefficients(density * area * h)[:few],
            rotary=coarse.coefficients(density * h**3)[:few],
            patch=held,
            coupling=state.bond * np.concatenate([one, fine.coefficients(tau)[:terms]]),
            offset=monomials(state.offset_x / reach, state.offset_y / reach),
            patch_alone=patches * (away.patch_modulus / area - 1.0 - state.debonded * state.bond),
            patch_modulus=patches * away.patch_modulus,
            patch_thicker=thicker,
            patch_mass=thicker + patches * (area - 1.0),
            columns=patches * away.strain_constant * away.patch_modulus * (1.0 - state.debonded),
            momentum=away.momentum * np.mean(density * h**3 * nu / (60.0 * (1.0 - nu))),
            moves=np.array([patches * getattr(away, name) for name in MOVES]).T,
            patch_loss=state.patch_loss * held,
        )


def _stretched(away: Departures, angle: float) -> Sequence[Any]:
    """Factors on the energies of Q11, Q22, Q12 and Q66 of a plate with other lengths.

    In axes turned against the plate's the energies mix; there the mean of both stretches is taken.
    """
    x, y = away.stretch_x, away.stretch_y
    if angle:
        return [1.0 / (x * y)] * 4
    return [y / x**3, x / y**3, 1.0 / (x * y), 1.0 / (x * y)]


@dataclass(frozen=True)
class Composite:
    """Reduced matrices of one state, or their derivative by a parameter.

    Attributes
    ----------
    plate, plate_loss : (r, r) ndarray
        Real part of the plate's stiffness, and imaginary part, before any factor over frequency.
    fixed : (r, r) ndarray
        Stiffness of the patches.
    mass : (r, r) ndarray
    coupling : (r, P) ndarray
    """

    plate: Real
    plate_loss: Real
    fixed: Real
    mass: Real
    coupling: Real


def proportion(a: Real, b: Real) -> float | None:
    """Return c if a = c b, as for a loss proportional to a stiffness, which saves a product; else None."""
    place = np.unravel_index(np.argmax(np.abs(b)), b.shape)
    c = float(a[place] / b[place]) if b[place] else 0.0
    return c if np.abs(a - c * b).max() <= 1e-13 * abs(float(a[place])) else None


def composed(ops: EffectOperators, c: Coefficients) -> Composite:
    """Sum the stacks with real coefficients."""
    whole = _plain(ops, c)
    fixed = ops.patch_own + whole.fixed
    mass = ops.patch_mass + whole.mass
    if c.momentum:
        mass = mass + c.momentum * ops.momentum
    for factors, stack in ((c.patch_alone, ops.patch_alone), (c.patch_thicker, ops.patch_thicker)):
        if factors.any():
            fixed = fixed + _summed(factors, stack)
    if c.patch_mass.any():
        mass = mass + _summed(c.patch_mass, ops.patch_mass_alone)
    if not c.offset.any():
        return replace(whole, fixed=fixed, mass=mass)
    moved = OffsetPart.of(ops, c, c.offset).on(ops.zone)
    return Composite(
        whole.plate + moved.plate, whole.plate_loss + moved.plate_loss, fixed, mass + moved.mass, whole.coupling
    )


def _plain(ops: EffectOperators, c: Coefficients) -> Composite:
    """Sum the stacks with the sensor at its declared place."""
    return Composite(
        plate=_summed(c.bending, ops.bending) + _summed(c.membrane, ops.membrane) + _summed(c.shear, ops.shear),
        plate_loss=_summed(c.bending_loss, ops.bending)
        + _summed(c.membrane_loss, ops.membrane)
        + _summed(c.shear_loss, ops.shear)
        + _summed(c.patch_loss, ops.patch_membrane),
        fixed=_summed(c.patch, ops.patch_membrane),
        mass=_summed(c.mass, ops.mass) + _summed(c.rotary, ops.rotary),
        coupling=coupling_of(ops, c) * c.columns,
    )


def coupling_of(ops: EffectOperators, c: Coefficients) -> Numbers:
    """Coupling of all patches, (r, P), before the factor of each."""
    found = np.tensordot(c.coupling, ops.coupling, 1)
    return found + c.patch_thicker * ops.thicker_coupling.T if c.patch_thicker.any() else found


SAME = 1e-12
"""Relative difference of equal moves: a complex step and its division round."""


class PatchMoves:
    """What moves of patches change in the matrices of a plate at one state, in some coordinates.

    Operators are summed over the motions around a patch, then transformed to these coordinates: each sum once,
    when it is first needed.

    Parameters
    ----------
    zones : (P, q, m) ndarray
        Motions around each patch, of the m coordinates wanted.
    value : Coefficients
        Of the state; its moduli act in the middle of the plate.
    """

    def __init__(self, ops: EffectOperators, zones: Real, value: Coefficients) -> None:
        self._ops, self._zones, self._value = ops, zones, value
        self._single: dict[tuple[int, int], tuple[Real, Real, Real, Real]] = {}
        self._own: dict[int, tuple[Real, Real, Real, Real]] = {}

    def by(self, moves: Real) -> Composite:
        """Differentiate by moves (P, 4), at the moduli of the state."""
        found, value = self._nothing(), self._value
        parts = (found.plate, found.plate_loss, found.fixed, found.mass)
        for k in np.flatnonzero(moves.any(axis=1)).tolist():
            if np.allclose(moves[k], value.moves[k], rtol=SAME, atol=0.0):
                self._follow(found, k, value)
                found.mass[...] += self._own_moves(k)[3]
                continue
            for way in np.flatnonzero(moves[k]).tolist():
                for whole, part in zip(parts, self._move(k, way), strict=True):
                    whole += moves[k, way] * part
            found.coupling[:, k] = value.columns[k] * self._coupling(k, moves[k])
        return found

    def following(self, d: Coefficients | None) -> Composite:
        """Differentiate what the state's own moves change, where its moduli and couplings change by `d`.

        No mass follows them; None for `d` is no change.
        """
        found = self._nothing()
        if d is not None:
            for k in np.flatnonzero(self._value.moves.any(axis=1)).tolist():
                self._follow(found, k, d)
        return found

    def _follow(self, found: Composite, k: int, c: Coefficients) -> None:
        """Add what the own moves of patch k change, but for the mass."""
        fixed, in_plane, shear, _ = self._own_moves(k)
        found.fixed[...] += c.patch_modulus[k] * fixed
        for whole, moduli in zip((found.plate, found.plate_loss), _in_the_middle(c), strict=True):
            if moduli.any():
                whole += np.tensordot(moduli[:-1], in_plane, 1) + moduli[-1] * shear
        found.coupling[:, k] = c.columns[k] * self._coupling(k, self._value.moves[k])

    def _nothing(self) -> Composite:
        count, _, m = self._zones.shape
        plate, plate_loss, fixed, mass = (np.zeros((m, m)) for _ in range(4))
        return Composite(plate, plate_loss, fixed, mass, np.zeros((m, count)))

    def _coupling(self, k: int, moves: Real) -> Real:
        return np.asarray(self._zones[k].T @ (moves @ self._ops.moved_coupling[k]))

    def _move(self, k: int, way: int) -> tuple[Real, Real, Real, Real]:
        """Differentiate plate, plate loss, patches and mass by one move of patch k, at the state's moduli."""
        if (k, way) not in self._single:
            ops, (moduli, lossy) = self._ops, _in_the_middle(self._value)
            same = proportion(lossy, moduli)

            def plate(of: Real) -> Real:
                return self._carried(
                    k, np.tensordot(of[:-1], ops.moved_plane[k, way], 1) + of[-1] * ops.moved_shear[k, way]
                )

            whole = plate(moduli)
            self._single[k, way] = (
                whole,
                plate(lossy) if same is None else same * whole,
                self._value.patch_modulus[k] * self._carried(k, ops.moved_fixed[k, way]),
                self._carried(k, ops.moved_mass[k, way]),
            )
        return self._single[k, way]

    def _own_moves(self, k: int) -> tuple[Real, Real, Real, Real]:
        """Sum over the state's moves of patch k: of patches, in-plane moduli, transverse shear, and mass."""
        if k not in self._own:
            ops, moves = self._ops, self._value.moves[k]
            stacks = (ops.moved_fixed[k], ops.moved_plane[k], ops.moved_shear[k], ops.moved_mass[k])
            fixed, in_plane, shear, mass = (self._carried(k, np.tensordot(moves, one, 1)) for one in stacks)
            self._own[k] = fixed, in_plane, shear, mass
        return self._own[k]

    def _carried(self, k: int, operators: Real) -> Real:
        """Transform operators (..., q, q) around patch k."""
        return np.asarray(self._zones[k].T @ operators @ self._zones[k])


def _in_the_middle(c: Coefficients) -> tuple[Real, Real]:
    """Moduli in the middle of the plate, those of transverse shear last, and the same with losses: (5,) each.

    The operators of moves know transverse shear by both planes but for departures.
    """
    found = ((c.bending, c.shear), (c.bending_loss, c.shear_loss))
    plain, lossy = (np.append(moduli[:, 0], across[:, 0].mean()) for moduli, across in found)
    return plain, lossy


@dataclass(frozen=True)
class OffsetPart:
    """Changes of a plate's matrices where a patch is moved, over the motions around it or coordinates.

    Attributes
    ----------
    plate, plate_loss, mass : (q, q) or (r, r) ndarray
        As in `Composite`; patches and coupling do not change.
    """

    plate: Real
    plate_loss: Real
    mass: Real

    @classmethod
    def of(cls, ops: EffectOperators, c: Coefficients, place: Real) -> Self:
        """Sum the changes with moduli, thickness and inertia around the sensor, over the q motions there.

        Parameters
        ----------
        c : Coefficients
            Of the state, or their derivative; real.
        place : (monomials,) ndarray
            Monomials of the offset, or their derivative.

        Returns
        -------
        OffsetPart
        """
        energies = ops.offset_energies(place)

        def summed(name: str, coefficients: Numbers) -> Real:
            stack = energies[name]
            coefficients = coefficients.mean(axis=0) if name == "shear" else coefficients
            return _summed(coefficients @ ops.zone_fit[: stack.shape[-3], : coefficients.shape[-1]].T, stack)

        return cls(
            summed("bending", c.bending) + summed("membrane", c.membrane) + summed("shear", c.shear),
            summed("bending", c.bending_loss)
            + summed("membrane", c.membrane_loss)
            + summed("shear", c.shear_loss),
            summed("mass", c.mass),
        )

    def on(self, zone: Real) -> Self:
        """Return the part over coordinates whose motions around the sensor are `zone` (q, r)."""
        plate, plate_loss, mass = (zone.T @ one @ zone for one in (self.plate, self.plate_loss, self.mass))
        return type(self)(plate, plate_loss, mass)


def _summed(coefficients: Numbers, stack: Real) -> Real:
    """Sum of coefficients times matrices, vanishing ones skipped, (r, r)."""
    flat = np.ravel(coefficients)
    matrices = stack.reshape(-1, *stack.shape[-2:])
    used = np.flatnonzero(flat)
    return np.asarray(np.tensordot(flat[used], matrices[used], 1))
