"""The digital twin: transfer from one input to all outputs, with or without effects, and derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real
from analysis.local_laws import LocalLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects, Linearisation, Tangent
from simulation.reduction.certified_lines import certified_lines
from simulation.twin.derivatives import Derivatives
from simulation.twin.instrumented_plate import InstrumentedPlate, Plate, steady
from simulation.twin.local_solution import LocalSolution
from simulation.twin.moved_patches import MovedPatches
from simulation.twin.reading import SignalReading
from simulation.twin.vicinity import Vicinity


@dataclass(frozen=True)
class Twin(InstrumentedPlate[Plate]):
    """Transfer from the input named in a sweep's circumstances to K outputs, in their units.

    See `analysis.twin_model.TwinModel`, and `InstrumentedPlate` for the attributes.
    """

    def frf(
        self, laws: LocalLaws, frequency: ArrayLike, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        """Return the outputs per unit of the input.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; unless given, a steady temperature, the laws' reference, at 1 V.

        Returns
        -------
        (K, F) complex ndarray

        Raises
        ------
        ValueError
            Outside the box or the band, for an effect's value outside its certified range, and for an effect that
            follows the strain energy before `referred` was called.
        """
        lines = certified_lines(frequency, self.band)
        return self.uncertified_frf(laws, lines, effects, point)

    def uncertified_frf(
        self, laws: LocalLaws, frequency: ArrayLike, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        """Return the same as `frf`, also at frequencies outside the certified band.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            As in `frf`.

        Returns
        -------
        (K, F) complex ndarray

        Raises
        ------
        ValueError
            As `frf`, but lines outside the band are allowed.
        """
        lines = np.atleast_1d(np.asarray(frequency, float))
        here = point or steady(laws)
        if here.drifts or self.state(laws, lines, effects, here).departures.moves:
            return self._linearised(laws, lines, effects, here, ()).transfer
        state = self.state(laws, lines, effects, here)
        self.plate.require(state)
        return self._reading(self.solved(state, lines), here).response

    def linearise(
        self,
        laws: LocalLaws,
        frequency: ArrayLike,
        effects: Effects = NO_EFFECTS,
        point: SweepPoint | None = None,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer and its derivatives, see `analysis.twin_model.TwinModel`.

        If the temperature drifts while the sweep passes, the transfer at each frequency is that at the temperature
        then, to first order. A sweep of 2 s on a ramp of 1 K/min drifts by 0.03 K, which changes a resonance of
        polypropylene by 0.7 % of its peak; what the first order leaves is 2e-5 of it. The derivatives are those at
        the mean temperature. Likewise the transfer is linear in the moves of patches, see `Departures`; its
        derivatives contain them, but for those of effects that are off.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; unless given, a steady temperature, the laws' reference, at 1 V.
        tangents : sequence of Tangent
            Parameters of effects by which to differentiate.

        Raises
        ------
        ValueError
            Outside the box or the band, for an effect's value outside its certified range, and for an effect that
            follows the strain energy before `referred` was called.
        """
        lines = certified_lines(frequency, self.band)
        return self._linearised(laws, lines, effects, point or steady(laws), tangents)

    def _linearised(
        self, laws: LocalLaws, lines: Real, effects: Effects, here: SweepPoint, tangents: Sequence[Tangent]
    ) -> Linearisation:
        """Linearise at lines inside the certified band or outside."""
        on = [*effects, *(name for name, _, _ in tangents)]
        energy = self.settled_energy(here, laws, effects, on, lines)
        vicinity = Vicinity(self.states, here, laws, effects, lines, energy)
        state = vicinity.state(energy)
        self.plate.require(state)
        solved = self.solved(state, lines)
        scale = self.energy_scale(here) if self.states.follow_energy(on) else 1.0
        slopes = self.slopes(state, solved.basis)
        derivatives = Derivatives.of(slopes, solved, self._reading(solved, here), vicinity.state, energy, scale)
        found = vicinity.linearisation(derivatives, tangents)
        if state.departures.moves:
            along = slopes.by(vicinity.along_moves(energy))
            moved = MovedPatches.of(solved, slopes, along)
            there = Derivatives.of(
                moved, moved.solved, self._reading(moved.solved, here), vicinity.state, energy, scale
            )
            found = vicinity.along(found, derivatives, there, tangents)
        if not here.drifts:
            return found
        return replace(found, transfer=found.transfer + here.drift(lines) * found.by_temperature)

    def _reading(self, solved: LocalSolution, point: SweepPoint) -> SignalReading:
        return SignalReading.of(solved, solved.state, self.driven_at(point), self.plate.capacitance)
