"""Material of a twin fitted to natural frequencies and damping over temperature, without any FRF.

The unknowns are log E and nu at every temperature and the declared quantities q, each with its tolerance as prior;
nu has the range of the material as prior. With measured frequencies f and those of the twin F,

    sum ((log f - log F(E, nu, q)) / sigma)^2 + prior

is minimised by Gauss-Newton steps. Measured modes are paired with the twin's by their frequencies, or by their
numbers where these are given. The loss factor follows from the ratio of measured to computed modal loss factors,
which scatter from mode to mode by more than measurements do: supports, joints and air damp each in their own way.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from analysis.arrays import Complex, Mask, Real, Whole
from analysis.effect_card import EffectCard
from analysis.estimates import DeclaredQuantity
from analysis.material import LocalLaws, Material, MaterialBox
from analysis.recordings.frf_campaign import ModesAtTemperature
from analysis.scatter import scatter_of
from analysis.twin_model import Effects
from analysis.updated import Updated

Poles = Callable[[LocalLaws, Effects], Complex]
"""Poles of the twin, rad/s, upper half plane, by ascending magnitude."""

RATIO_OF_STARTS = 1.5
"""Of neighbouring moduli at which the twin's modes are computed for the search: frequencies in between follow from
the root of the ratio, within the share of the band beyond its edges for which modes are computed."""
RATIOS_TRIED = 3
SHIFT = 0.004
"""Step of the search in the logarithm of frequencies: the frequencies of a right pairing agree to some tenths of a
per cent."""
ALIKE = 0.01
"""Differences in the logarithm of frequencies that count as much as one mode that the list leaves out."""
AMBIGUOUS = 4.0
"""Difference of the search's scores below which two moduli explain a list of modes equally well."""
APART = 0.05
"""Of log E, from which on two solutions are different ones."""
NEIGHBOUR = 0.6
"""Largest change of log E from one temperature to the next."""
STEPS = 8
FARTHEST = 0.02
"""Difference in log frequency beyond which a measured mode is not that of the twin, as for modes of FRFs."""
LEAST_SIGMA = 1e-5
"""Of a frequency, relative: that of thermal drift in any laboratory."""
HELD = 0.7
"""Share of its prior's standard deviation from which on nu is not told by the modes."""
SCATTER = (0.01, 1.0)
"""Least and largest scatter of modal loss factors about the material's."""
FEWEST_DOF = 3
"""Degrees of freedom needed to take the error of frequencies from their scatter."""


@dataclass(frozen=True)
class FittedModes:
    """A twin fitted to modes.

    Attributes
    ----------
    updated : Updated
        One row per temperature; the misfit is the rms difference of frequencies, relative.
    pairs : tuple of (J,) int ndarray
        Which of the twin's modes each measured one is, by temperature.
    computed : tuple of (J, 2) ndarray
        Frequency, Hz, and loss factor of these.
    held : tuple of str
        What the modes do not tell, for people.
    scatter : float
        Of modal loss factors about the twin's, as a logarithm; NaN without damping.
    """

    updated: Updated
    pairs: tuple[Whole, ...]
    computed: tuple[Real, ...]
    held: tuple[str, ...]
    scatter: float


def read_modes(poles: Complex) -> Real:
    """Frequency, Hz, and loss factor (J, 2) of hysteretic poles (J,), by ascending frequency."""
    k = -(poles**2)
    found = np.column_stack([np.sqrt(np.maximum(k.real, 0.0)) / (2.0 * np.pi), k.imag / k.real])
    return found[np.argsort(found[:, 0], kind="stable")]


def fit_modes(
    measured: Sequence[ModesAtTemperature], poles: Poles, box: MaterialBox, cards: Mapping[str, EffectCard]
) -> FittedModes:
    """Fit E, nu and eta of a twin to modes.

    Parameters
    ----------
    poles : callable
        Of the twin.
    box : MaterialBox
        Where it is certified.
    cards : mapping of str to EffectCard
        Its declared quantities with tolerances.

    Raises
    ------
    ValueError
        Where the modes fit several moduli equally well, or the scatter of few modes tells no standard deviation.
    """
    found = _Search(poles, box).starts(measured)
    problem = _Problem(measured, poles, box, cards)
    return problem.solved(found)


class _Search:
    """Moduli and Poisson's ratios from which frequencies are right within their pairing."""

    def __init__(self, poles: Poles, box: MaterialBox) -> None:
        low, high = np.log(box.youngs_modulus)
        count = max(int(np.ceil((high - low) / np.log(RATIO_OF_STARTS))), 1)
        loss = float(np.sqrt(np.prod(box.loss_factor)))
        inside = np.linspace(*box.poisson_ratio, RATIOS_TRIED + 2)[1:-1]
        self.range = low, high
        self.spectra: list[tuple[float, float, Real]] = []
        for middle in low + (high - low) * (np.arange(count) + 0.5) / count:
            for ratio in inside:
                law = LocalLaws.of_material(float(np.exp(middle)), float(ratio), loss)
                self.spectra.append((float(middle), float(ratio), read_modes(poles(law, {}))[:, 0]))

    def starts(self, measured: Sequence[ModesAtTemperature]) -> Real:
        """Return log E and nu (T, 2), from the temperature with the most modes to its neighbours."""
        order = np.argsort([one.temperature for one in measured], kind="stable")
        first = max(order, key=lambda t: len(measured[t].frequency))
        found = np.zeros((len(measured), 2))
        found[first] = self._best(measured[first], None)
        place = int(np.flatnonzero(order == first)[0])
        for way in (order[place:], order[place::-1]):
            for before, here in pairwise(way):
                found[here] = self._best(measured[here], float(found[before, 0]))
        return found

    def _best(self, modes: ModesAtTemperature, near: float | None) -> tuple[float, float]:
        scored = []
        half = 0.5 * np.log(RATIO_OF_STARTS)
        for middle, ratio, computed in self.spectra:
            for log_e in np.arange(middle - half, middle + half, 2.0 * SHIFT):
                inside = self.range[0] <= log_e <= self.range[1]
                if inside and (near is None or abs(log_e - near) < NEIGHBOUR):
                    scored.append(self._scored(modes, computed, float(log_e), middle, ratio))
        if not scored:
            raise ValueError(f"no modulus of the material's range explains the modes at {modes.temperature:g} °C")
        score, log_e, ratio = min(scored)
        rivals = [one for one in scored if abs(one[1] - log_e) > APART and one[0] < score + AMBIGUOUS]
        if rivals and near is None:
            other = min(rivals)
            raise ValueError(
                f"the {len(modes.frequency)} modes at {modes.temperature:g} °C fit E = {np.exp(log_e) / 1e9:.3g} "
                f"and {np.exp(other[1]) / 1e9:.3g} GPa equally well; give their numbers (mode, 1 for the "
                "lowest elastic one), more modes, or plate.material"
            )
        return log_e, ratio

    @staticmethod
    def _scored(
        modes: ModesAtTemperature, computed: Real, log_e: float, middle: float, ratio: float
    ) -> tuple[float, float, float]:
        """Score, log E and nu: differences of paired frequencies, and modes that the list leaves out."""
        shifted = computed * np.exp(0.5 * (log_e - middle))
        place = paired(modes, shifted)
        if place is None:
            return np.inf, log_e, ratio
        away = np.log(modes.frequency / shifted[place])
        own = float(np.mean(away))
        spread = float(np.mean((away - own) ** 2))
        left_out = int(np.ptp(place)) + 1 - len(place) if not modes.number.any() else 0
        score = len(away) * np.log(spread + (ALIKE / 4.0) ** 2) + left_out + (own / ALIKE) ** 2
        return score, log_e + 2.0 * own, ratio


def paired(modes: ModesAtTemperature, computed: Real) -> Whole | None:
    """Return which computed mode (Hz, ascending) each measured one is; None where there are too few of them."""
    count = len(modes.frequency)
    if modes.number.all():
        return None if modes.number.max() > len(computed) else modes.number - 1
    if len(computed) < count:
        return None
    away = np.log(modes.frequency[:, None] / computed[None, :]) ** 2
    for row in np.flatnonzero(modes.number):
        if modes.number[row] > len(computed):
            return None
        away[row] = np.where(np.arange(len(computed)) == modes.number[row] - 1, 0.0, 1e6)
    place = np.asarray(linear_sum_assignment(away)[1], dtype=int)
    return (
        place if modes.number.any() else np.sort(place)
    )  # in order: of equal sums of squares the one without swaps


class _Problem:
    """The joint fit of all temperatures."""

    def __init__(
        self,
        measured: Sequence[ModesAtTemperature],
        poles: Poles,
        box: MaterialBox,
        cards: Mapping[str, EffectCard],
    ) -> None:
        self.measured, self.poles, self.box = measured, poles, box
        low, high = box.poisson_ratio
        self.ratio, self.ratio_sigma = 0.5 * (low + high), 0.25 * (high - low)
        self.loss = np.full(len(measured), float(np.sqrt(np.prod(box.loss_factor))))
        self.names = [(name, p.name) for name, card in cards.items() for p in card.parameters]
        self.parameters = [p for card in cards.values() for p in card.parameters]
        self.cards = cards

    def spectrum(self, t: int, x: Real, values: Effects) -> Real:
        """Modes (M, 2) of the twin at a temperature, with log E and nu (2,) and values of declared quantities."""
        e = float(np.clip(np.exp(x[0]), *self.box.youngs_modulus))
        nu = float(np.clip(x[1], *self.box.poisson_ratio))
        eta = float(np.clip(self.loss[t], *self.box.loss_factor))
        law = LocalLaws.of_material(e, nu, eta, reference=self.measured[t].temperature)
        return read_modes(self.poles(law, values))

    def values(self, q: Real) -> dict[str, dict[str, float]]:
        found: dict[str, dict[str, float]] = {}
        for (name, parameter), value in zip(self.names, q, strict=True):
            found.setdefault(name, {})[parameter] = float(value)
        return found

    def solved(self, x: Real) -> FittedModes:
        """Fit, starting from log E and nu (T, 2)."""
        count = len(self.measured)
        middle = max(range(count), key=lambda t: len(self.measured[t].frequency))
        known = self._moving(middle, x[middle])
        self.names = [self.names[k] for k in known]
        self.parameters = [self.parameters[k] for k in known]
        tolerance = np.array([p.sigma for p in self.parameters])
        q, slopes, by_q = np.zeros(len(tolerance)), self._slopes(x), self._by_declared(middle, x[middle])
        for _ in range(STEPS):
            spectra = [self.spectrum(t, x[t], self.values(q)) for t in range(count)]
            pairs = [self._paired(t, spectra[t][:, 0]) for t in range(count)]
            self.loss = self._losses(spectra, pairs)[0]
            residuals = [
                np.log(one.frequency / spectrum[place, 0])
                for one, spectrum, place in zip(self.measured, spectra, pairs, strict=True)
            ]
            sigma, dof = self._sigma(residuals)
            system = _System(residuals, sigma, slopes, by_q, pairs, tolerance, self.ratio_sigma)
            step, q_step = system.step(x[:, 1] - self.ratio, q)
            x, q = x + step, q + q_step
            x[:, 1] = np.clip(x[:, 1], *self.box.poisson_ratio)
            if np.abs(step).max() < 1e-6:
                break
        return self._found(x, q, system, spectra, pairs, residuals, dof)

    def _paired(self, t: int, computed: Real) -> Whole:
        place = paired(self.measured[t], computed)
        if place is None:
            raise ValueError(
                f"the twin has {len(computed)} modes up to {computed.max():.0f} Hz, fewer than the list at "
                f"{self.measured[t].temperature:g} °C names; correct its numbers or the declaration"
            )
        return place

    def _moving(self, t: int, x: Real) -> list[int]:
        """Return which declared quantities move any mode."""
        base = self.spectrum(t, x, {})[:, 0]
        moving = []
        for k, ((name, parameter), p) in enumerate(zip(self.names, self.parameters, strict=True)):
            values = {name: {q.name: p.sigma if q.name == parameter else 0.0 for q in self.cards[name].parameters}}
            moved = self.spectrum(t, x, values)[:, 0]
            if len(moved) != len(base) or np.abs(moved / base - 1.0).max() > LEAST_SIGMA:
                moving.append(k)
        return moving

    def _by_declared(self, t: int, x: Real) -> Real:
        """Slopes (P, M) of the log frequencies of the twin's modes by the declared quantities."""
        base = self.spectrum(t, x, {})[:, 0]
        rows = []
        for k, p in enumerate(self.parameters):
            moved = self.spectrum(t, x, self.values(p.sigma * (np.arange(len(self.parameters)) == k)))[:, 0]
            both = min(len(moved), len(base))
            row = np.zeros(len(base))
            row[:both] = np.log(moved[:both] / base[:both]) / p.sigma
            rows.append(row)
        return np.array(rows).reshape(len(self.parameters), len(base))

    def _slopes(self, x: Real) -> list[Real]:
        """Slopes (M, 2) of the log frequencies by log E and nu, at every temperature."""
        made = []
        for t in range(len(self.measured)):
            base = self.spectrum(t, x[t], {})[:, 0]
            columns = []
            for by in (np.array([0.01, 0.0]), np.array([0.0, -0.01 if x[t, 1] > self.ratio else 0.01])):
                moved = self.spectrum(t, x[t] + by, {})[:, 0]
                both = min(len(moved), len(base))
                column = np.full(len(base), 0.5 if by[0] else 0.0)
                column[:both] = np.log(moved[:both] / base[:both]) / by.sum()
                columns.append(column)
            made.append(np.column_stack(columns))
        return made

    def _sigma(self, residuals: Sequence[Real]) -> tuple[list[Real], int]:
        """Relative standard deviations of all frequencies, where they are not stated by the scatter of all."""
        stated = [one.sigma / one.frequency for one in self.measured]
        every, known = np.concatenate(residuals), np.concatenate(stated)
        unknown = ~np.isfinite(known)
        dof = len(every) - 2 * len(self.measured)
        if unknown.any():
            if dof < FEWEST_DOF:
                raise ValueError(
                    f"{len(every)} frequencies at {len(self.measured)} temperatures do not tell how exact they "
                    "are; give sigma_frequency, Hz, or more modes"
                )
            scatter = float(np.sqrt((every[unknown] ** 2).sum() / unknown.sum() * len(every) / dof))
            stated = [np.where(np.isfinite(one), one, max(scatter, LEAST_SIGMA)) for one in stated]
        return [np.maximum(one, LEAST_SIGMA) for one in stated], dof

    def _losses(self, spectra: Sequence[Real], pairs: Sequence[Whole]) -> tuple[Real, Real, float]:
        """Loss factors of the material (T,), their relative standard deviations, and the scatter of modes."""
        ratios, variances = [], []
        for one, spectrum, place in zip(self.measured, spectra, pairs, strict=True):
            told = np.isfinite(one.loss_factor)
            ratios.append(np.log(one.loss_factor[told] / spectrum[place[told], 1]))
            own = one.sigma_loss_factor[told] / one.loss_factor[told]
            variances.append(np.nan_to_num(own) ** 2)
        means = [float(row.mean()) if len(row) else 0.0 for row in ratios]
        several = [  # about a mean of their own they scatter less than about the true value
            (row - mean) * np.sqrt(len(row) / (len(row) - 1.0))
            for row, mean in zip(ratios, means, strict=True)
            if len(row) > 1
        ]
        low, high = self.box.loss_factor
        if not any(len(row) for row in ratios):
            return self.loss, np.full(len(self.loss), 0.25 * np.log(high / low)), float("nan")
        of_several = [v for v, row in zip(variances, ratios, strict=True) if len(row) > 1]
        empty = np.zeros(0)
        scatter = scatter_of(np.concatenate([*several, empty]), np.concatenate([*of_several, empty]), SCATTER)
        loss, sigma = self.loss.copy(), np.full(len(self.loss), 0.25 * np.log(high / low))
        dof = sum(len(row) - 1 for row in several)
        small = dof / (dof - 2.0) if dof > 2 else 1.0  # Student's variance over Gauss's: d is an estimate
        for t, (row, variance) in enumerate(zip(ratios, variances, strict=True)):
            if len(row):
                weight = 1.0 / (variance + scatter**2)
                loss[t] *= np.exp((weight * row).sum() / weight.sum())
                sigma[t] = np.sqrt(small / weight.sum())
        return np.clip(loss, *self.box.loss_factor), sigma, scatter

    def _found(
        self,
        x: Real,
        q: Real,
        system: "_System",
        spectra: Sequence[Real],
        pairs: Sequence[Whole],
        residuals: Sequence[Real],
        dof: int,
    ) -> FittedModes:
        loss, sigma_loss, scatter = self._losses(spectra, pairs)
        own, common, sigma_q = system.deviations()
        chi2 = np.array([float(((r / s) ** 2).mean()) for r, s in zip(residuals, system.sigma, strict=True)])
        own *= float(np.sqrt(max(sum(chi2 * [len(r) for r in residuals]) / max(dof, 1), 1.0)))
        count = len(x)
        sigma = np.column_stack([np.sqrt(own[:, k] ** 2 + (common[:, k] ** 2).sum(axis=1)) for k in range(2)])
        material = Material(np.exp(x[:, 0]), x[:, 1].copy(), loss)
        shared = np.concatenate([np.pad(common, ((0, 0), (0, 1), (0, 0))), np.zeros((count, 3, 1))], axis=2)
        misfit = np.array([float(np.sqrt((r**2).mean())) for r in residuals])
        near = np.array([np.abs(r).max() < FARTHEST for r in residuals])
        inside = self.box.inside(np.column_stack([material.youngs_modulus, material.poisson_ratio, loss]))
        updated = Updated(
            temperature=np.array([one.temperature for one in self.measured]),
            material=material,
            sigma=material.sigma(np.column_stack([sigma, sigma_loss])),
            correlation=np.tile(np.eye(4), (count, 1, 1)),
            gain=1.0,
            sigma_gain=0.0,
            misfit_start=misfit,
            misfit=misfit,
            noise_floor=np.array([float(np.sqrt((s**2).mean())) for s in system.sigma]),
            chi2_per_dof=chi2,
            settled=near & inside,
            declared=tuple(
                DeclaredQuantity(
                    name, parameter, p.unit, self.cards[name].summary, p.sigma, float(value), float(spread)
                )
                for (name, parameter), p, value, spread in zip(
                    self.names, self.parameters, q, sigma_q, strict=True
                )
            ),
            common=shared,
        )
        computed = tuple(spectrum[place] for spectrum, place in zip(spectra, pairs, strict=True))
        return FittedModes(
            updated, tuple(pairs), computed, (*self._held(sigma, scatter), *self._at_walls(material)), scatter
        )

    def _at_walls(self, material: Material) -> list[str]:
        """Say which constants lie at an end of the material's range, where no estimate is one."""
        said = []
        for name, scale, unit in (
            ("youngs_modulus", 1e9, " GPa"),
            ("poisson_ratio", 1.0, ""),
            ("loss_factor", 1.0, ""),
        ):
            low, high = getattr(self.box, name)
            values = getattr(material, name)
            if ((values <= low * (1.0 + 1e-6)) | (values >= high * (1.0 - 1e-6))).any():
                said.append(
                    f"{name} comes to an end of the material's range, {low / scale:g} to {high / scale:g}{unit}; "
                    "widen it in plate.material, or correct the declaration"
                )
        return said

    def _held(self, sigma: Real, scatter: float) -> tuple[str, ...]:
        said = []
        if (sigma[:, 1] > HELD * self.ratio_sigma).any():
            said.append(
                f"these modes hardly tell nu: it is held near {self.ratio:.3f} ± {self.ratio_sigma:.3f}, the "
                "middle of the material's range (plate.material)"
            )
        if not np.isfinite(scatter):
            said.append("no damping is given: eta is the middle of the material's range, and no estimate")
        return tuple(said)


class _System:
    """Normal equations of the frequencies, linear in the steps of log E, nu and the declared quantities."""

    def __init__(
        self,
        residuals: Sequence[Real],
        sigma: Sequence[Real],
        slopes: Sequence[Real],
        by_q: Real,
        pairs: Sequence[Whole],
        tolerance: Real,
        ratio_sigma: float,
    ) -> None:
        self.sigma, self.count, self.declared = sigma, len(residuals), len(tolerance)
        size = 2 * self.count + self.declared
        self.matrix, self.moment = np.zeros((size, size)), np.zeros(size)
        rows: Mask
        for t, (r, s, place) in enumerate(zip(residuals, sigma, pairs, strict=True)):
            design = np.zeros((len(r), size))
            design[:, 2 * t : 2 * t + 2] = slopes[t][np.minimum(place, len(slopes[t]) - 1)]
            rows = place < by_q.shape[1]
            design[rows, 2 * self.count :] = by_q[:, place[rows]].T
            weighted = design / s[:, None] ** 2
            self.matrix += weighted.T @ design
            self.moment += weighted.T @ r
        self.prior = np.concatenate([np.tile([0.0, ratio_sigma**-2], self.count), tolerance**-2.0])

    def step(self, ratio_away: Real, q: Real) -> tuple[Real, Real]:
        """Return the steps (T, 2) and (P,) from where nu is `ratio_away` (T,) from its prior's middle."""
        here = np.concatenate([np.column_stack([0.0 * ratio_away, ratio_away]).ravel(), q])
        found = np.linalg.solve(self.matrix + np.diag(self.prior), self.moment - self.prior * here)
        return found[: 2 * self.count].reshape(-1, 2), found[2 * self.count :]

    def deviations(self) -> tuple[Real, Real, Real]:
        """Own deviations (T, 2), what one deviation of each declared quantity moves (T, 2, P), and these (P,)."""
        size = 2 * self.count
        whole = np.linalg.inv(self.matrix + np.diag(self.prior))
        inner = np.linalg.inv(self.matrix[:size, :size] + np.diag(self.prior[:size]))
        sigma_q = np.sqrt(np.diag(whole)[size:])
        carried = -(inner @ self.matrix[:size, size:]) * sigma_q
        return np.sqrt(np.diag(inner)).reshape(-1, 2), carried.reshape(self.count, 2, self.declared), sigma_q
