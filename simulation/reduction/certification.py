"""Error of a reduced model, measured against the full one outside the training set."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from analysis.arrays import Complex, Real
from analysis.material import MaterialBox
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.resonance_lines import root_mean_square
from simulation.shell.shell_model import ShellModel

Constants = tuple[float, float, float]

WORKERS = 2
"""Materials solved at a time."""
DRAWN = 3
"""Number of random materials in the box at each attempt."""
HALTON = (2, 3, 5)
"""Bases of Halton's sequence along E, nu and eta."""


def held_out(box: MaterialBox, attempt: int) -> list[Constants]:
    """(E, nu, eta) between the training materials, three of them random, new ones at each attempt.

    The first attempt also uses the box's softest and stiffest materials at the smallest damping, where resonances
    are most numerous and sharpest.
    """
    (e0, e1), (n0, n1), (h0, h1) = box.youngs_modulus, box.poisson_ratio, box.loss_factor
    sides = [(e0, n0 + 0.37 * (n1 - n0), h0), (e1, n0 + 0.45 * (n1 - n0), h0)] if attempt == 0 else []
    cube = _scattered(DRAWN, np.random.default_rng(attempt))
    within = [(e0 * (e1 / e0) ** a, n0 + b * (n1 - n0), h0 + c * (h1 - h0)) for a, b, c in cube]
    return [(float(e), float(n), float(h)) for e, n, h in sides + within]


def _scattered(count: int, rng: np.random.Generator) -> Real:
    """Points (count, 3) of the unit cube, far from each other: Halton's sequence, shifted at random.

    Written here, because importing SciPy's takes a second.
    """
    digits = 8
    found = np.empty((count, len(HALTON)))
    for axis, base in enumerate(HALTON):
        places = np.arange(1, count + 1)[:, None] // base ** np.arange(digits) % base
        found[:, axis] = (places / float(base) ** np.arange(1, digits + 1)).sum(axis=1)
    return np.asarray((found + rng.random(len(HALTON))) % 1.0)


def measured_error(
    model: ShellModel, small: ReducedModel, candidate: ReducedModel, lines: Real, attempt: int
) -> tuple[float, Complex]:
    """Measure the error of `small` at the held-out materials.

    The full model is solved for each material at the frequency, of the even `lines` and those on narrow
    resonances, where `small` differs most from the `candidate` it was selected from; for a random material also at
    a random frequency in the band or, where resonances are narrow, on their flanks. Errors are those of
    `ReducedModel.error`.

    Parameters
    ----------
    model : ShellModel
        The full model, of n unknowns.
    small : ReducedModel
    candidate : ReducedModel
    lines : (F,) ndarray, Hz
        Evenly spaced over the band.
    attempt : int
        Number of the attempt, which is the seed of random materials and frequencies.

    Returns
    -------
    error : float
    seen : (n, S) complex ndarray
        The full model's responses there: minus the displacements per volt.
    """
    rng = np.random.default_rng(100 + attempt)
    materials = held_out(small.box, attempt)
    generators = [np.random.default_rng(seed) for seed in rng.integers(2**32, size=len(materials))]

    def at(place: int) -> tuple[float, Complex]:
        material, rng, also_drawn = materials[place], generators[place], place >= len(materials) - DRAWN
        *moduli, loss = material
        modes, of_candidate = small.damped_modes(*moduli), candidate.damped_modes(*moduli)
        places = modes.lines(loss, lines)
        form, ports = small.modal_form(*material), small.coupling
        rms = root_mean_square(form.compliance(ports, ports, places), places)[..., None]
        departure = np.abs(modes.transfers(places, loss) - of_candidate.transfers(places, loss)) / rms
        flanks = np.setdiff1d(places, lines)
        drawn = rng.choice(flanks) if flanks.size else rng.uniform(*small.band)
        chosen = np.array([places[departure.max(axis=(0, 1)).argmax()], drawn][: 2 if also_drawn else 1])
        full = model.responses(*material, chosen)
        transfer = np.einsum("ni,nkf->ikf", model.coupling, full)
        wrong = np.abs(form.compliance(ports, ports, chosen) - transfer) / rms
        worst = max(float(wrong.max()), _field_error(model, small, material, chosen, full, places))
        return worst, full.reshape(model.size, -1)

    with ThreadPoolExecutor(WORKERS) as executor:
        found = list(executor.map(at, reversed(range(len(materials)))))  # the random ones first: they take longest
    return max(worst for worst, _ in found), np.hstack([seen for _, seen in found])


def _field_error(
    model: ShellModel, small: ReducedModel, material: Constants, chosen: Real, full: Complex, lines: Real
) -> float:
    """Largest rms over the points of the deflection's error, over its rms over points, inputs and band."""
    if not len(small.points):
        return 0.0
    field = -(model.deflection(small.points) @ full.reshape(model.size, -1)).reshape(-1, *full.shape[1:])
    reduced = np.einsum("kr,nfr->knf", small.deflection, small.amplitudes(*material, chosen))
    over_band = np.einsum("kr,nfr->knf", small.deflection, small.amplitudes(*material, lines), optimize=True)
    wrong = np.sqrt(np.mean(np.abs(field - reduced) ** 2, axis=0))
    return float(wrong.max() / np.sqrt(np.mean(root_mean_square(over_band, lines) ** 2)))
