"""A reduced plate at one set of constants: poles, transfers as sums over them, and their derivatives.

Losses couple the real modes of a plate weakly. Their vectors are corrected as in Ogita and Aishima, Iterative
refinement for symmetric eigenvalue decomposition (Japan Journal of Industrial and Applied Mathematics 35, 2018),
with transposes in place of adjoints: quadratic convergence, and matrix products only.

What acts at points: dashpots of supports, a damping matrix R R' of low rank, and anything of dynamic stiffness z
that is attached at a row R'.

Z = Z0 + R z R' is not diagonal in the modes of Z0. But its effect follows from the responses of Z0 to the columns
of R (Woodbury): Z**-1 b = Z0**-1 b - Z0**-1 R x, where x = (1 + z R' Z0**-1 R)**-1 z R' Z0**-1 b are the forces
of what acts; z = j w of a dashpot.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
import scipy.linalg
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix, issparse

from analysis.arrays import Complex, Real

FAR_POLES, NODES = 4.0, 16
"""For poles beyond FAR_POLES times the highest squared frequency, the interpolation error is 14**-NODES."""


@dataclass(frozen=True)
class PoleSums:
    """Terms 1/(pole - s) of r poles at s, the F squared angular frequencies.

    The sum over poles far above the lines is so smooth that a polynomial through a few points is exact to
    rounding; most poles of a reduced model are far.

    Attributes
    ----------
    far : (r,) bool ndarray
    near : (r - f, F) complex ndarray
        Terms of the other poles.
    beyond : (f, NODES) complex ndarray
        Terms of the far ones, at Chebyshev points.
    interpolation : (NODES, F) ndarray
        From these points to the lines.
    """

    far: NDArray[np.bool_]
    near: Complex
    beyond: Complex
    interpolation: Real

    @classmethod
    def of(cls, poles: Complex, frequency: ArrayLike) -> Self:
        """Prepare the sums of `poles` (r,), rad2/s2, at frequencies (F,), Hz."""
        s = (2 * np.pi * np.atleast_1d(np.asarray(frequency, float))) ** 2
        far = np.abs(poles) > FAR_POLES * s.max()
        if s.size < 4 * NODES:
            far = np.zeros(len(poles), dtype=bool)
        points, interpolation = _interpolation(s) if far.any() else (np.zeros(0), np.zeros((0, s.size)))
        return cls(far, 1.0 / (poles[~far, None] - s), 1.0 / (poles[far, None] - points), interpolation)

    def simple(self, weights: Complex) -> Complex:
        """Sum weights/(pole - s) over the poles, (..., r) -> (..., F)."""
        return self._summed(weights, self.near, self.beyond)

    def squared(self, weights: Complex) -> Complex:
        """Sum weights/(pole - s)**2 over the poles, (..., r) -> (..., F)."""
        return self._summed(weights, *self._squares)

    @cached_property
    def _squares(self) -> tuple[Complex, Complex]:
        return self.near**2, self.beyond**2

    def _summed(self, weights: Complex, near: Complex, beyond: Complex) -> Complex:
        total = weights[..., ~self.far] @ near
        if len(beyond):
            total += (weights[..., self.far] @ beyond) @ self.interpolation
        return np.asarray(total)


CONVERGED_CORRECTION = 1e-6
"""Largest correction whose square, the next one, is left out."""
COUPLING_ROUNDING = 1e-15
"""Largest coupling of real modes, over the largest element, that is taken for rounding."""
MOST_CORRECTIONS = 8
"""Number of corrections after which poles count as too close."""


@dataclass(frozen=True)
class ModalForm:
    """Eigenvalues and eigenvectors of a complex symmetric stiffness whose mass is the identity, and what acts.

    The right eigenvectors' inverse serves as left eigenvectors. It is their transpose except where eigenvalues
    coincide: there the normalisation x'x = 1 of complex symmetric eigenvectors may be impossible.

    Attributes
    ----------
    poles : (r,) ndarray
        Complex squared angular frequencies, rad2/s2, by ascending real part.
    shapes : (r, r) ndarray
        Right eigenvectors, one a column.
    inverse : (r, r) ndarray
        Left eigenvectors, one a row.
    columns : (r, q) ndarray
        R of what acts: of dashpots, whose product is the damping matrix, 1/s, and of what is attached; not
        included in the other attributes.
    attached : (a, F) complex ndarray or None
        Dynamic stiffness of the last a columns at the lines that are asked for, N/m; None where all are dashpots.
    """

    poles: Complex
    shapes: Complex
    inverse: Complex
    columns: Real = field(default_factory=lambda: np.zeros((0, 0)))
    attached: Complex | None = None

    @classmethod
    def of(cls, stiffness: Complex, dashpots: Real | None = None) -> Self:
        """Solve the eigenproblem of a complex (r, r) stiffness; the columns of `dashpots` (r, q) are stored."""
        columns = np.zeros((len(stiffness), 0)) if dashpots is None else dashpots
        found = symmetric_poles(stiffness)
        if found is not None:
            order = np.argsort(found[0].real)
            shapes = np.asfortranarray(found[1][:, order])
            return cls(found[0][order], shapes, shapes.T, columns)
        poles, shapes = np.linalg.eig(stiffness)  # scipy's version holds the interpreter lock; this one does not
        order = np.argsort(poles.real)
        shapes = np.asfortranarray(shapes[:, order])
        return cls(poles[order], shapes, scipy.linalg.inv(shapes, check_finite=False), columns)

    @property
    def count(self) -> int:
        """Number of columns q."""
        return int(self.columns.shape[1])

    def with_attached(self, rows: Real, stiffness: Complex) -> Self:
        """Return the form with attachments at `rows` (a, r) of the deflection, of dynamic `stiffness` (a, F)."""
        return replace(self, columns=np.hstack([self.columns, rows.T]), attached=stiffness)

    def acting(self, frequency: ArrayLike) -> Complex:
        """Dynamic stiffness of every column, (q, F)."""
        few = 0 if self.attached is None else len(self.attached)
        dashpots = of_dashpots(self.count - few, frequency)
        return dashpots if self.attached is None else np.vstack([dashpots, self.attached])

    def damped_poles(self) -> Complex:
        """Squared angular frequencies of free motion with the dashpots, rad2/s2, by ascending real part.

        Overdamped motions are left out. ValueError where something else is attached.
        """
        if self.attached is not None:
            raise ValueError("the poles with attachments are not those of dashpots")
        if not self.count:
            return self.poles
        damping = 1j * (self.inverse @ self.columns) @ (self.columns.T @ self.shapes)
        zero, one = np.zeros_like(damping), np.eye(len(damping))
        roots = np.linalg.eigvals(np.block([[zero, one], [np.diag(self.poles), damping]]))
        squares = roots[roots.real > np.abs(roots.imag)] ** 2
        return np.asarray(squares[np.argsort(squares.real)])

    def solve(self, force: Real, frequency: ArrayLike) -> Complex:
        """Coordinates Z**-1 b for every column b of `force` (r, N): (N, F, r)."""
        weights = (self.inverse @ self.with_columns(force)).T
        sums = PoleSums.of(self.poles, frequency)
        answers = sums.simple(weights[:, None] * self.shapes).swapaxes(1, 2)
        if not self.count:
            return np.asarray(answers)
        moved = np.einsum("rq,nfr->qnf", self.columns, answers)
        x = forces(moved[:, -self.count :], moved[:, : -self.count], self.acting(frequency))
        return np.asarray(answers[: -self.count] - np.einsum("qfr,qnf->nfr", answers[-self.count :], x))

    def compliance(self, left: Real, right: Real, frequency: ArrayLike, sums: PoleSums | None = None) -> Complex:
        """Return a' Z**-1 b for every column a of `left` and b of `right`.

        Parameters
        ----------
        left : (r, I) ndarray
        right : (r, J) ndarray
        frequency : (F,) array_like, Hz
        sums : PoleSums, optional
            Of `poles` at `frequency`, if known.

        Returns
        -------
        (I, J, F) complex ndarray
        """
        a, b = self.with_columns(left).T @ self.shapes, self.inverse @ self.with_columns(right)
        whole = (sums or PoleSums.of(self.poles, frequency)).simple(a[:, None] * b.T[None])
        return connected(whole, self.acting(frequency))

    def with_columns(self, ports: Real) -> Real:
        """Columns (r, N) with those of what acts after them, (r, N + q)."""
        return np.hstack([ports, self.columns]) if self.count else ports


def symmetric_poles(matrix: Complex) -> tuple[Complex, Complex] | None:
    """Eigenvalues (r,) of a complex symmetric (r, r) matrix, and eigenvectors whose transpose is their inverse.

    None if eigenvalues are closer than the coupling of their modes, so that corrections do not converge.
    """
    coupled, modes = _in_real_modes(0.5 * (matrix + matrix.T))
    own = np.arange(len(coupled))
    poles = coupled[own, own]
    with np.errstate(all="ignore"):  # coinciding poles are detected by the size of the correction
        first = coupled / _gaps(poles)
        first[own, own] = 0.0
        first *= 2.0 / (1.0 + np.sqrt(1.0 + 4.0 * first * first))  # each pair rotated by its own angle
        vectors = first + 0.5 * (first @ first)
        vectors[own, own] += 1.0
        for _ in range(MOST_CORRECTIONS):
            product, gram = vectors.T @ (coupled @ vectors), vectors.T @ vectors
            poles = product[own, own] / gram[own, own]
            product = 0.5 * (product + product.T)  # removes the asymmetry by rounding
            correction = (product - poles * gram) / _gaps(poles)
            correction[own, own] = 0.5 * (1.0 - gram[own, own])
            vectors += vectors @ correction
            largest = float(np.abs(correction).max())
            if largest < CONVERGED_CORRECTION:
                return poles, vectors if modes is None else modes @ vectors
            if not largest < 1.0:
                return None
    return None


def _in_real_modes(matrix: Complex) -> tuple[Complex, Real | None]:
    """Matrix (r, r) in the modes (r, r) of its real part; None for modes where that is diagonal already."""
    size = np.abs(matrix.real)
    largest = size.max(initial=0.0)
    np.fill_diagonal(size, 0.0)
    if size.max(initial=0.0) <= COUPLING_ROUNDING * largest:
        return matrix, None
    modes = np.linalg.eigh(matrix.real)[1]
    return modes.T @ matrix @ modes, modes


def _gaps(poles: Complex) -> Complex:
    """Pole of the column less that of the row, 1 on the diagonal."""
    gaps = poles - poles[:, None]
    np.fill_diagonal(gaps, 1.0)
    return np.asarray(gaps)


def _interpolation(s: Real) -> tuple[Real, Real]:
    """Chebyshev points (NODES,) between the ends of s (F,), and the matrix (NODES, F) from them to s."""
    low, high = s.min(), s.max()
    points = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    to_coefficients = chebvander(points, NODES - 1).T * (2.0 / NODES)
    to_coefficients[0] *= 0.5
    place = (2.0 * s - low - high) / (high - low)
    return 0.5 * (low + high + (high - low) * points), (chebvander(place, NODES - 1) @ to_coefficients).T


SAME_POLE = 1e-9
"""Relative distance below which two poles count as one double pole."""


@dataclass(frozen=True)
class ModalSlopes:
    """a' Z**-1 b of I columns a and J columns b at F lines, with derivatives by the stiffness.

    The derivative for a change K' of the stiffness is -a' Z**-1 K' Z**-1 b. In modal coordinates the product of
    two terms 1/((p - s)(q - s)) is the difference of the single terms over q - p, so that a sum over pairs of
    poles and frequencies becomes one over pairs of poles and one over frequencies.

    Attributes
    ----------
    form : ModalForm
    frequency : (F,) ndarray
        Hz.
    left : (I + q, r) complex ndarray
        The columns a in modal coordinates, those of what acts, q, after them.
    right : (r, J + q) complex ndarray
        The columns b likewise.
    sums : PoleSums
    apart : (r, r) complex ndarray
        1/(q - p) of all pairs of poles; 0 for a double pole.
    double : (r, r) bool ndarray
        Pairs that count as a double pole.
    whole : (I + q, J + q, F) complex ndarray
        a' Z**-1 b without what acts.
    """

    form: ModalForm
    frequency: Real
    left: Complex
    right: Complex
    sums: PoleSums
    apart: Complex
    double: NDArray[np.bool_]
    whole: Complex

    @classmethod
    def of(
        cls, form: ModalForm, left: Real, right: Real, frequency: ArrayLike, sums: PoleSums | None = None
    ) -> Self:
        """Prepare derivatives for the columns a and b.

        Parameters
        ----------
        left : (r, I) ndarray
            The columns a.
        right : (r, J) ndarray
            The columns b.
        frequency : (F,) array_like, Hz
        sums : PoleSums, optional
            Of the form's poles at `frequency`, where they are known.

        Returns
        -------
        ModalSlopes
        """
        lines = np.atleast_1d(np.asarray(frequency, float))
        a, b = form.with_columns(left).T @ form.shapes, form.inverse @ form.with_columns(right)
        sums = sums or PoleSums.of(form.poles, lines)
        gap = form.poles[None, :] - form.poles[:, None]
        double = np.abs(gap) <= SAME_POLE * np.abs(form.poles)[:, None]
        apart = np.where(double, 0.0, 1.0 / np.where(double, 1.0, gap))
        return cls(form, lines, a, b, sums, apart, double, sums.simple(a[:, None] * b.T[None]))

    @property
    def compliance(self) -> Complex:
        """Return a' Z**-1 b, (I, J, F)."""
        return connected(self.whole, self.form.acting(self.frequency))

    def connected(self, slopes: Complex) -> Complex:
        """Return derivatives of `compliance`, (D, I, J, F), from those of `whole`, (D, I + q, J + q, F)."""
        return connected_derivatives(self.whole, slopes, self.form.acting(self.frequency))

    def by_stiffness(self, changes: Real) -> Complex:
        """Differentiate `whole` for D derivatives of the stiffness: one sum over poles, in a tenth of the time.

        Parameters
        ----------
        changes : (D, r, r) ndarray

        Returns
        -------
        (D, I + q, J + q, F) complex ndarray
        """
        a, b, size = self.left, self.right, len(self.form.poles)
        # a real matrix times a complex one, by real products: half of what two complex ones take
        shapes = np.ascontiguousarray(self.form.shapes).view(float)
        moved = (np.reshape(changes, (-1, size)) @ shapes).view(complex).reshape(-1, size, size)
        modal = self.form.inverse @ moved
        split = modal * self.apart
        simple = (a @ split)[:, :, None] * b.T - a[:, None] * (split @ b).swapaxes(1, 2)[:, None]
        own = np.where(self.double, modal, 0.0) @ b
        return self.sums.simple(simple) - self.sums.squared(a[:, None] * own.swapaxes(1, 2)[:, None])

    def by_columns(self, left: Real, right: Real) -> Complex:
        """Differentiate `whole` for D derivatives of the columns a (D, r, I) and b (D, r, J).

        Returns
        -------
        (D, I + q, J + q, F) complex ndarray
        """
        a, b, count = self.left, self.right, self.form.count
        moved_a = np.pad(left.swapaxes(1, 2) @ self.form.shapes, ((0, 0), (0, count), (0, 0)))
        moved_b = np.pad((self.form.inverse @ right).swapaxes(1, 2), ((0, 0), (0, count), (0, 0)))
        return self.sums.simple(moved_a[:, :, None] * b.T + a[:, None] * moved_b[:, None])


LEAST_POWER = 1e-7
"""Smallest dissipated power of a column, as a share of the largest."""
MOST_COLUMNS = 12
"""Largest number of columns of dashpots at points, each of which is a load of the plate without dashpots."""


def columns(damping: csr_matrix | Real, answers: Real) -> Real:
    """R (n, q) with R R' x = C x for every x among the answers (n, k), C (n, n) symmetric (Nystroem).

    Directions that dissipate less than `LEAST_POWER` of the power of the strongest are left out; all responses
    have equal weight, whether to a volt or to a newton.
    """
    if not (damping.nnz if issparse(damping) else damping.any()):
        return np.zeros((len(answers), 0))
    answers = answers / np.linalg.norm(answers, axis=0)
    forces = damping @ answers
    power, directions = np.linalg.eigh(answers.T @ forces)
    kept = power > LEAST_POWER * power.max()
    return np.asarray(forces @ (directions[:, kept] / np.sqrt(power[kept])))


def few_columns(damping: csr_matrix) -> Real | None:
    """Return R (n, q) with R R' = C where q is at most `MOST_COLUMNS`; None for more, as along an edge."""
    held = np.flatnonzero(np.diff(damping.indptr))
    power, directions = np.linalg.eigh(damping[held][:, held].toarray())
    kept = power > LEAST_POWER * power.max(initial=0.0)
    if kept.sum() > MOST_COLUMNS:
        return None
    found = np.zeros((damping.shape[0], int(kept.sum())))
    found[held] = directions[:, kept] * np.sqrt(power[kept])
    return found


def of_dashpots(count: int, frequency: ArrayLike) -> Complex:
    """Dynamic stiffness j w of columns of dashpots, (count, F)."""
    omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequency, float))
    return np.asarray(np.broadcast_to(1j * omega, (count, omega.size)))


def forces(between: Complex, moved: Complex, acting: Complex) -> Complex:
    """Return the forces of what acts.

    Parameters
    ----------
    between : (q, q, F) complex ndarray
        R' Z0**-1 R.
    moved : (q, J, F) complex ndarray
        R' Z0**-1 b of J loads.
    acting : (q, F) complex ndarray
        Dynamic stiffness z.

    Returns
    -------
    (q, J, F) complex ndarray
    """
    z = acting[:, None]
    if len(between) == 1:
        return np.asarray(z * moved / (1.0 + z * between))
    system = np.moveaxis(z * between, -1, 0) + np.eye(len(between))
    return np.asarray(np.moveaxis(np.linalg.solve(system, np.moveaxis(z * moved, -1, 0)), 0, -1))


def connected(compliance: Complex, acting: Complex) -> Complex:
    """Add what acts to the compliance of a plate without it.

    Parameters
    ----------
    compliance : (I + q, J + q, F) ndarray
        Without what acts; the last q rows and columns are its own.
    acting : (q, F) complex ndarray
        Dynamic stiffness.

    Returns
    -------
    (I, J, F) complex ndarray
    """
    count = len(acting)
    if not count:
        return compliance
    x = forces(compliance[-count:, -count:], compliance[-count:, :-count], acting)
    return np.asarray(compliance[:-count, :-count] - np.einsum("iqf,qjf->ijf", compliance[:-count, -count:], x))


def connected_derivatives(compliance: Complex, slopes: Complex, acting: Complex) -> Complex:
    """Differentiate `connected` by D parameters on which what acts does not depend.

    Parameters
    ----------
    compliance : (I + q, J + q, F) ndarray
        Without what acts; the last q rows and columns are its own.
    slopes : (D, I + q, J + q, F) ndarray
        Derivatives of `compliance`.
    acting : (q, F) complex ndarray
        Dynamic stiffness.

    Returns
    -------
    (D, I, J, F) complex ndarray
    """
    count = len(acting)
    if not count:
        return slopes
    between = compliance[-count:, -count:]
    right = -forces(between, compliance[-count:, :-count], acting)
    left = -forces(between.swapaxes(0, 1), compliance[:-count, -count:].swapaxes(0, 1), acting)
    change = slopes[:, :-count, :-count] + np.einsum("diqf,qjf->dijf", slopes[:, :-count, -count:], right)
    over = slopes[:, -count:, :-count] + np.einsum("dpqf,qjf->dpjf", slopes[:, -count:, -count:], right)
    return np.asarray(change + np.einsum("pif,dpjf->dijf", left, over))
