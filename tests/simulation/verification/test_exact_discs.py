"""Exact discs and annuli against printed values, thin plates, and an independent Ritz solution."""

from itertools import product

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq
from scipy.special import iv, ivp, jv, jvp

from tests.simulation.verification.exact_plates import ExactDisc

PRINTED = {
    ExactDisc(0.01, 0.3, "free"): "9.0018 38.4164 | 20.4613 | 5.3545 35.214 | 12.4237 | 21.7983",
    ExactDisc(0.1, 0.3, "free"): "8.8688 36.0592 | 19.7165 | 5.2782 33.05 | 12.0667 48.2623 | 20.8089",
    ExactDisc(0.2, 0.3, "free"): "8.508 31.1562 | 17.9939 44.5225 | 5.1156 28.7085 | 11.3209 40.0346 | 18.8351",
    ExactDisc(0.01, 0.3, "clamped"): "10.213 39.7335 | 21.2487 | 34.8467",
    ExactDisc(0.1, 0.3, "clamped"): "9.9439 36.5111 | 20.188 | 32.2314 | 45.8222",
    ExactDisc(0.2, 0.3, "clamped"): "9.2499 30.283 | 17.789 42.4957 | 27.0543 | 36.8558 | 47.0452",
    ExactDisc(0.1, 0.3, "soft"): "4.8942 28.2536 | 13.5137 44.7242 | 24.3242 | 36.9869",
    ExactDisc(0.1, 0.3, "hard"): "4.8942 28.2536 | 13.5656 44.7645 | 24.5121 | 37.3762",
    ExactDisc(0.01, 0.3, "free", 0.3, "free"): (
        "8.3522 50.3099 | 18.2113 58.5508 | 4.8986 32.9111 | 12.2481 50.9077 | 21.7455"
    ),
    ExactDisc(0.01, 0.3, "free", 0.3, "clamped"): (
        "6.6589 42.5582 | 6.5487 44.5601 | 7.9463 50.836 | 13.255 | 22.034"
    ),
    ExactDisc(0.1, 0.3, "free", 0.3, "free"): (
        "8.2274 46.6523 | 17.0269 52.5403 | 4.7961 30.782 | 11.876 46.5448 | 20.7509"
    ),
    ExactDisc(0.1, 0.3, "free", 0.3, "clamped"): (
        "6.5178 37.9354 | 6.3173 39.5861 | 7.5538 44.8731 | 12.6929 | 20.9575"
    ),
}
"""w a^2 sqrt(rho h / D) to four decimals, computed elsewhere; columns are n = 0, 1, 2 ..."""


@pytest.mark.parametrize("disc", PRINTED, ids=str)
def test_printed_values_are_met_to_their_last_digit(disc):
    for n, column in enumerate(PRINTED[disc].split("|")):
        wanted = np.array(column.split(), float)
        assert disc.frequencies(n, wanted[-1] + 0.01) == pytest.approx(wanted, abs=0.51e-4)


def thin_clamped(n, x):
    return jv(n, x) * ivp(n, x) - iv(n, x) * jvp(n, x)


def thin_simple(n, x, nu):
    return 2 * x / (1 - nu) - jv(n + 1, x) / jv(n, x) - iv(n + 1, x) / iv(n, x)


def thin_free(n, x, nu):
    """Kirchhoff's edge: no bending moment, no effective shear force (Leissa 1969, equation 2.8)."""

    def fraction(f, df, sign):
        moment = x**2 * f * sign + (1 - nu) * (x * df - n**2 * f)
        force = x**3 * df * sign + (1 - nu) * n**2 * (x * df - f)
        return moment, force

    (a, b), (c, d) = fraction(jv(n, x), jvp(n, x), 1.0), fraction(iv(n, x), ivp(n, x), -1.0)
    return a * d - b * c


THIN = {
    "clamped": lambda n, x: thin_clamped(n, x),
    "soft": lambda n, x: thin_simple(n, x, 0.3) * jv(n, x) * iv(n, x),
    "free": lambda n, x: thin_free(n, x, 0.3),
}


@pytest.mark.parametrize(("support", "n"), list(product(THIN, range(5))))
def test_thin_discs_approach_kirchhoffs(support, n):
    grid = np.linspace(1.5 if n < 2 else 0.8, 9.0, 600)
    value = THIN[support](n, grid)
    where = np.flatnonzero(value[:-1] * value[1:] < 0)
    thin = np.array([brentq(lambda x: THIN[support](n, x), grid[k], grid[k + 1]) for k in where]) ** 2
    assert thin.size
    errors = [
        np.abs(ExactDisc(h, 0.3, support).frequencies(n, 1.001 * thin[-1])[: thin.size] / thin - 1).max()
        for h in (0.004, 0.002, 0.001)
    ]
    assert errors[2] < 2e-3
    assert errors[0] > 1.7 * errors[1] > 1.7 * 1.7 * errors[2]


def test_leissas_thin_values():
    """A. W. Leissa, Vibration of plates (1969): clamped disc, and free disc of nu = 0.33."""
    clamped = [ExactDisc(0.001, 0.3, "clamped").frequencies(n, 41.0)[0] for n in range(3)]
    assert clamped == pytest.approx([10.216, 21.26, 34.88], rel=3e-4)
    free = [ExactDisc(0.001, 0.33, "free").frequencies(n, 25.0)[0] for n in (2, 0, 3, 1)]
    assert free == pytest.approx([5.253, 9.084, 12.23, 20.52], rel=2e-3)


def ritz(disc, n, terms=24):
    """Frequencies of an annulus by polynomials of r: none of Bessel's functions, no search."""
    b, nu, waves = disc.hole, disc.poisson_ratio, disc.waves
    nodes, weights = legendre.leggauss(2 * terms)
    r = 0.5 * (1 + b) + 0.5 * (1 - b) * nodes
    weights = 0.5 * (1 - b) * weights * r
    slope = legendre.legder(np.eye(terms)) * 2 / (1 - b)
    f, d = legendre.legvander(nodes, terms - 1), legendre.legval(nodes, slope).T
    o = np.zeros_like(f)
    column = r[:, None]
    strains = [
        (1.0, np.hstack([o, d, o])),
        (1.0, np.hstack([o, f / column, n * f / column])),
        (0.5 * (1 - nu), np.hstack([o, -n * f / column, d - f / column])),
        (waves.shear, np.hstack([d, f, o])),
        (waves.shear, np.hstack([-n * f / column, o, f])),
    ]
    k = sum(c * (e.T * weights) @ e for c, e in strains)
    cross = (strains[0][1].T * weights) @ strains[1][1]
    k = k + nu * (cross + cross.T)
    mass = (f.T * weights) @ f
    m = np.kron(np.diag([1.0, waves.rotary, waves.rotary]), mass)
    held = {"free": (), "soft": (0,), "hard": (0, 2), "clamped": (0, 1, 2)}
    rows = [
        np.kron(np.eye(3)[field], legendre.legvander(np.array([end]), terms - 1)[0])
        for end, edge in ((-1.0, disc.inner), (1.0, disc.outer))
        for field in held[edge]
    ]
    free = null_space(np.array(rows)) if rows else np.eye(3 * terms)
    squares = eigh(free.T @ k @ free, free.T @ m @ free, eigvals_only=True)
    return np.sqrt(np.abs(squares))


@pytest.mark.parametrize(("inner", "outer"), list(product(("free", "clamped", "soft", "hard"), repeat=2)))
def test_no_root_of_an_annulus_is_missed(inner, outer):
    """Every frequency to well above the cut-off, where more waves travel."""
    disc = ExactDisc(0.25, 0.3, outer, 0.4, inner)
    highest = 1.6 * disc.waves.cut_off
    for n in range(4):
        independent = ritz(disc, n)
        independent = independent[(independent > 0.02) & (independent < highest)]
        independent = independent[np.abs(independent / disc.waves.cut_off - 1) > 1e-6]  # theta = r lies there
        assert independent.size >= 7
        assert disc.frequencies(n, highest) == pytest.approx(independent, rel=1e-6)


@pytest.mark.parametrize("outer", ["free", "clamped", "soft", "hard"])
@pytest.mark.parametrize("thickness", [0.001, 0.05, pytest.param(0.3, marks=pytest.mark.slow)])
def test_no_root_of_a_disc_is_missed(outer, thickness):
    """Each is a change of sign of the determinant on a scan twenty times finer than the search's."""
    disc = ExactDisc(thickness, 0.3, outer)
    grid = np.linspace(0.2, 13.0, 12_800) ** 2
    grid = grid[np.abs(grid / disc.waves.cut_off - 1) > 1e-6]
    for n in range(6):
        value = disc.determinant(n, grid)
        changes = (value[:-1] * value[1:] < 0) & ~(
            (grid[:-1] < disc.waves.cut_off) & (grid[1:] > disc.waves.cut_off)
        )
        found = disc.frequencies(n, grid[-1])
        assert found.size == changes.sum()
        assert found == pytest.approx(0.5 * (grid[:-1] + grid[1:])[changes], rel=0.01)


def test_every_mode_of_a_disc_is_listed_in_order():
    values, diameters = ExactDisc(0.1, 0.3, "free").all_frequencies(21.0)
    assert values == pytest.approx(
        [5.2782, 5.2782, 8.8688, 12.0667, 12.0667, 19.7165, 19.7165, 20.8089, 20.8089], abs=1e-4
    )
    assert diameters.tolist() == [2, 2, 0, 3, 3, 1, 1, 4, 4]


def test_the_lowest_frequencies_are_the_first_of_all():
    disc = ExactDisc(0.1, 0.3, "clamped")
    assert disc.lowest(9) == pytest.approx(disc.all_frequencies(60.0)[0][:9])


def test_low_modes_are_listed_where_those_of_fewer_diameters_lie_higher():
    values, diameters = ExactDisc(0.1, 0.3, "free").all_frequencies(6.0)
    assert (values.size, set(diameters)) == (2, {2})


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: ExactDisc(0.0, 0.3, "free"), "thickness is 0"),
        (lambda: ExactDisc(0.1, 0.5, "free"), "ratio is 0.5"),
        (lambda: ExactDisc(0.1, 0.3, "glued"), "support is 'glued'"),
        (lambda: ExactDisc(0.1, 0.3, "free", 1.0), "hole is 1"),
        (lambda: ExactDisc(0.1, 0.3, "free").frequencies(-1, 5.0), "diameters is -1"),
    ],
)
def test_what_is_no_disc_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
