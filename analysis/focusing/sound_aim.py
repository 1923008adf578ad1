"""Filters chosen by what is heard: the quadratic forms of a design with a sound wanted, in place of a field alone.

The target is to move with its shape φ and the rest is to stay at rest, as in STIF; but how far the target moves at
a line follows from the sound wanted there. With R the filters, h the pressure of each actuator's field at a
listener (or, for the aim ``volume``, its net volume displacement), p* the one wanted and g(f) the movement of the
target:

    J = w_field [∫_T |U - gφ|² + κ ∫_rest |U|² + λ |R|²] / ∫ |g U₀|²
        + w_sound mean_l |hR - p*|²/|p*|² + w_quiet mean_q (|hR|² + ε² Σ_n |h_n R_n|²)/|p*|² + w_power W_rest / W*

U₀ is the field of STIF's filters, and g the factor by which they reach p* (least squares over the listeners). For
one listener both terms are then smallest together: the sound is flat and no contrast is lost, at the price of
drive where the field radiates little. With g = 1 instead, as STIF has it, the two terms contradict each other.
"""

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from analysis.arrays import Complex, Mask, Real
from analysis.focusing.energy import EnergyForms, FieldSpace, Grid
from analysis.focusing.panel import AimedAt, Panel
from analysis.radiation.radiator import Radiator, SourceNodes

RESPONSE_TOLERANCE = 0.01
"""Relative error of each actuator's response, independent of the others', for which quiet zones are designed and
stated. Without one, as many actuators as quiet listeners make them hear nothing, at any price in drive; 1 % is
what the laws of a material leave open at best."""
LARGEST_BOOST = 2.0
"""Of a line's movement over the median of the band. Where STIF's field hardly radiates, as in a notch of its net
volume, more of it would take most of the drive: on the section-2 panel at 60 °C, 10 in place of 2 costs 5 dB of
level and gains no contrast. There the sound is made by another field, and contrast is lost on these lines."""


@dataclass(frozen=True)
class SoundAim:
    """What a panel's field makes at its listeners, and the sound wanted there, at F lines.

    Attributes
    ----------
    panel : Panel
    radiator : Radiator
    kernel : (L, F, K) ndarray
        Pressure, Pa, per displacement of every point; for the aim ``volume`` volume displacement, m3, L = 1.
    wanted : (L, F) ndarray
        What is wanted of it per unit of audio signal.
    loud : (L,) ndarray of bool
        Listeners of the zone that is played to; the others are to hear nothing.
    sources : SourceNodes
        For the power radiated.
    """

    panel: Panel
    radiator: Radiator
    kernel: Complex
    wanted: Complex
    loud: Mask
    sources: SourceNodes
    _seen: dict[int, tuple[FieldSpace, Complex]] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(cls, panel: Panel, grid: Grid, aim: AimedAt | None = None) -> "SoundAim":
        """Prepare what does not depend on temperature.

        Parameters
        ----------
        grid : Grid
            Of the panel, or the measured points.
        aim : str, optional
            In place of the panel's; for ``field`` the sound at listeners is prepared, to be judged.

        Raises
        ------
        ValueError
            For a grid too coarse for the wavelength of sound or of the plate.
        """
        aim, lines, sound = aim or panel.filters.aim, panel.filters.frequency, panel.sound
        radiator = Radiator(grid.points, grid.area, sound.air, sound.mounting)
        radiator.require_fine(panel.filters.band[1], panel.shortest_wave(panel.filters.band[1]))
        moved = grid.target * panel.target.displacement
        if aim == "volume":
            kernel = np.broadcast_to(grid.area + 0j, (1, len(lines), len(grid.area)))
            loud = np.ones(1, dtype=bool)
        else:
            kernel = radiator.pressure(np.array([one.position for one in panel.listeners]), lines)
            loud = panel.loud
        wanted = np.asarray((kernel @ moved) * sound.wanted(lines), dtype=complex)
        return cls(panel, radiator, kernel, wanted, loud, radiator.sources(panel.filters.edges[1]))

    @classmethod
    def designing(cls, panel: Panel, grid: Grid, method: str) -> "SoundAim | None":
        """Prepare the design of the panel's filters by its aim, or return None for that of the field.

        Parameters
        ----------
        method : str
            By which filters are designed.

        Raises
        ------
        ValueError
            For another method than STIF, and as `of`.
        """
        if panel.filters.aim == "field":
            return None
        if method != "stif":
            raise ValueError(
                f"aim {panel.filters.aim!r} is for the method stif; {method} has no choice of its field"
            )
        return cls.of(panel, grid)

    @classmethod
    def judging(cls, panel: Panel, grid: Grid) -> "SoundAim | None":
        """Prepare the sound at the listeners, whatever the aim is; None where neither is declared."""
        if panel.filters.aim == "field" and not panel.sound.listener:
            return None
        return cls.of(panel, grid, "listeners")

    @property
    def band(self) -> Mask:
        """Lines of full gain among the F."""
        return self.panel.filters.in_band(self.panel.filters.frequency)

    @property
    def reference(self) -> Real:
        """Root mean square (F,) of what is wanted at the listeners that are played to."""
        return np.asarray(np.sqrt(np.mean(np.abs(self.wanted[self.loud]) ** 2, axis=0)))

    def transfers(self, space: FieldSpace, amplitude: Complex, lines: Mask | slice = slice(None)) -> Complex:
        """Compute what each actuator makes at each listener.

        Parameters
        ----------
        amplitude : (N, F, r) ndarray
        lines : (F',) ndarray of bool or slice, optional
            Which lines of the panel's are those F of the amplitudes.

        Returns
        -------
        (L, F, N) complex ndarray
            Pa, or m3 of net volume, per V or N.
        """
        if id(space) not in self._seen:  # a few spaces, each used at many temperatures
            self._seen[id(space)] = space, np.asarray(self.kernel @ space.deflection, dtype=complex)
        seen = self._seen[id(space)][1][:, lines]
        found: Complex = (amplitude.transpose(1, 0, 2) @ seen.transpose(1, 2, 0)).transpose(2, 0, 1)
        return found

    def relative(self, space: FieldSpace, amplitude: Complex, filters: Complex, lines: Mask) -> Complex:
        """Compute the sound of filters over that wanted; over `reference` where quiet is wanted.

        Parameters
        ----------
        amplitude : (N, F, r) ndarray
        filters : (F, N) ndarray
        lines : (F',) ndarray of bool
            Which lines of the panel's are those F of the amplitudes.

        Returns
        -------
        (L, F) complex ndarray
        """
        heard = np.einsum("lfn,fn->lf", self.transfers(space, amplitude, lines), filters)
        below = np.where(self.loud[:, None], self.wanted[:, lines], self.reference[lines])
        return np.asarray(heard / below)

    def forms(
        self,
        space: FieldSpace,
        amplitude: Complex,
        forms: EnergyForms,
        evenness: float = 1.0,
        outside_weight: float | None = None,
    ) -> "SoundForms":
        """Forms of the design at one temperature.

        Parameters
        ----------
        amplitude : (N, F, r) ndarray
        forms : EnergyForms
            Of the field, of one temperature.
        evenness : float
            1 for the sound wanted; less lets it follow the field's own: g to this power of its size.
        outside_weight : float, optional
            κ in place of the panel's.
        """
        sound, settings = self.panel.sound, self.panel.filters
        heard = self.transfers(space, amplitude)
        weighed = forms.weighted(settings.kappa if outside_weight is None else outside_weight)
        damped, target = weighed.damped(settings.tolerance)[0], weighed.aim[0]
        alone = np.linalg.solve(damped, target[..., None])[..., 0]
        move = self._movement(np.einsum("lfn,fn->lf", heard, alone))
        typical = float(np.median(np.abs(move[self.band])))
        uneven = (np.maximum(np.abs(move), np.finfo(float).tiny) / typical) ** (evenness - 1.0)
        move = move * uneven
        moved = np.abs(move) ** 2 * np.einsum("fn,fnm,fm->f", alone.conj(), forms.plate[0], alone).real
        share = sound.field_weight / np.maximum(moved, np.finfo(float).tiny)
        normal, right = share[:, None, None] * damped, (share * move)[:, None] * target
        below = self.reference * uneven
        for chosen, weight in ((self.loud, sound.sound_weight), (~self.loud, sound.quiet_weight)):
            if not chosen.any() or weight == 0.0:
                continue
            share = weight / np.count_nonzero(chosen) / below**2
            part = heard[chosen]
            normal = normal + share[:, None, None] * np.einsum("lfn,lfm->fnm", part.conj(), part)
            if not self.loud[chosen].any():
                spread = RESPONSE_TOLERANCE**2 * share[:, None] * np.sum(np.abs(part) ** 2, axis=0)
                normal = normal + spread[:, :, None] * np.eye(spread.shape[1])
            wanted = self.wanted[chosen] * self.loud[chosen, None] * uneven
            right = right + share[:, None] * np.einsum("lfn,lf->fn", part.conj(), wanted)
        if sound.power_weight > 0.0:
            normal = normal + sound.power_weight * self._power_outside(space, amplitude)
        return SoundForms(normal[None], normal[None], right[None])

    def _movement(self, alone: Complex) -> Complex:
        """Movement g (F,) of the target for which what STIF alone makes, (L, F), is nearest to what is wanted."""
        made, wanted = alone[self.loud], self.wanted[self.loud]
        squared = np.sum(np.abs(made) ** 2, axis=0)
        found = np.sum(made.conj() * wanted, axis=0) / np.maximum(squared, np.finfo(float).tiny)
        most = LARGEST_BOOST * np.median(np.abs(found[self.band]))
        size = np.maximum(np.abs(found), np.finfo(float).tiny)
        limited: Complex = found * np.minimum(1.0, most / size)
        return limited

    def _power_outside(self, space: FieldSpace, amplitude: Complex) -> Complex:
        """Power (F, N, N) radiated by the field outside the target, as if the target rested, over that wanted."""
        lines, sound = self.panel.filters.frequency, self.panel.sound
        outside = self.sources.lumped * (1.0 - space.grid.target) @ space.deflection
        whole = self.sources.lumped @ (space.grid.target * self.panel.target.displacement)
        found = []
        for f, level in enumerate(sound.wanted(lines)):
            resistance = self.sources.resistance(float(lines[f]))
            strength = outside @ amplitude[:, f].T
            wanted = level**2 * float(whole @ resistance @ whole)
            found.append(strength.conj().T @ (resistance @ strength) / wanted)
        return np.array(found)


class SoundForms(EnergyForms):
    """Normal matrix of J as `plate` and `target`, its right-hand side as `aim`: for design, not for judging.

    It is weighted and regularised already.
    """

    def weighted(self, kappa: float) -> Self:
        """Return these forms themselves."""
        return self

    def damped(self, tolerance: float) -> Complex:
        """Return `plate` itself."""
        return self.plate
