"""Design of filters at 241 temperatures, against the dense least squares; focus and compensate on a warm basis.

    python benchmarks/filters.py [LAWS.h5 | RUN]

The plain way is the normal matrix of all taps (N × M unknowns), made of its Toeplitz blocks, and Cholesky. Both
must give the same field. The last solves are also tried as one batch of torch. Without laws of a run, constants
after the paper's are used.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor, cho_solve, toeplitz

from analysis.compensation.rivals import direct_filters
from analysis.focusing.design import OUT_OF_BAND_WEIGHT, FieldFit, FieldProblem
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import taper
from analysis.focusing.methods import invert
from analysis.focusing.panel import Filters
from analysis.focusing.panel_model import responses
from analysis.focusing.performance import contrast
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.updating.laws import fit_laws
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.results.laws_file import load_laws
from app.stages.panel.inputs import workers
from app.twins.panel_twin import panel_twin

ROOT = Path(__file__).resolve().parents[1]


def paper_laws() -> MaterialLaws:
    """Return laws through the constants of the paper's section 4.4."""
    t = np.arange(0.0, 61.0, 10.0)
    e = np.exp(np.interp(t, [0.0, 20.0, 60.0], np.log([3.25e9, 2.26e9, 1.0e9])))
    nu = np.interp(t, [0.0, 20.0, 60.0], [0.34, 0.37, 0.45])
    eta = np.interp(t, [0.0, 20.0, 60.0], [0.055, 0.082, 0.055])
    return fit_laws(t, Material(e, nu, eta), MaterialSigma(0.01 * e, 0.01 * nu, 0.02 * eta))


def dense(weight: np.ndarray, filters: np.ndarray, settings: Filters, delay: int) -> np.ndarray:
    """Taps (N, M) by the normal equations of all of them."""
    lines, count, rate, actuators = settings.frequency, settings.taps, settings.sample_rate, weight.shape[1]
    gain, spacing = taper(lines, settings), lines[1] - lines[0]
    lag = np.arange(count) / rate
    turn = np.exp(2j * np.pi * np.outer(lag, lines))
    beyond = toeplitz(turn.real @ (1.0 - gain))
    foot, head = settings.edges
    beyond += 0.5 * rate / spacing * np.eye(count)
    for edge, sign in ((head, -1.0), (foot, 1.0)):
        beyond += sign * edge / spacing * toeplitz(np.sinc(2.0 * edge * lag))
    small = OUT_OF_BAND_WEIGHT * np.median(np.linalg.eigvalsh(weight[gain == 1.0])[:, -1])
    normal = np.empty((actuators, count, actuators, count))
    for n in range(actuators):
        for m in range(actuators):
            column = turn @ (gain * weight[:, n, m])
            row = turn.conj() @ (gain * weight[:, n, m])
            normal[n, :, m] = toeplitz(column.real, row.real)
        normal[n, :, n] += small * beyond
    wanted = (weight @ filters[..., None])[..., 0] * (gain * np.exp(-2j * np.pi * lines * delay / rate))[:, None]
    right = (turn @ wanted).real.T.ravel()
    factor = cho_factor(normal.reshape(len(right), -1), overwrite_a=True, check_finite=False)
    return np.asarray(cho_solve(factor, right).reshape(actuators, count))


def torch_ratio(problem: FieldProblem, count: int) -> float:
    """Time of `count` solves one by one (SciPy) over that of one batch (torch), processor seconds."""
    import torch

    size = len(problem.right)
    normal = np.repeat(problem.normal.reshape(1, size, size), count, axis=0)
    started = time.process_time()
    single = np.array([cho_solve(cho_factor(one, lower=True), problem.right) for one in normal])
    alone = time.process_time() - started
    matrices, right = torch.as_tensor(normal), torch.as_tensor(problem.right)[None, :, None]
    started = time.process_time()
    factors = torch.linalg.cholesky(matrices)
    batch = torch.cholesky_solve(right.expand(count, -1, -1), factors)[..., 0].numpy()
    together = time.process_time() - started
    assert np.allclose(single, batch, rtol=1e-6, atol=1e-9 * np.abs(single).max())  # noqa: S101
    return alone / together


def main() -> None:
    """Time both ways, compare their fields, time the verbs, print, write JSON."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("laws", nargs="?", type=Path)
    given = words.parse_args().laws
    laws_file = None if given is None else given if given.is_file() else given / "laws.h5"
    panel = read_panel(SECTION_2)
    laws = panel.plate.grown(paper_laws() if laws_file is None else load_laws(laws_file))
    model = panel_twin(panel, laws, lambda _stage, _share: None)
    settings, lines = panel.filters, panel.filters.frequency
    temperature = np.linspace(0.0, 60.0, 241)
    started, processor = time.perf_counter(), time.process_time()
    direct_filters(model, panel, laws, temperature, workers=workers())
    whole, processor = time.perf_counter() - started, time.process_time() - processor

    (_, amplitude), *_ = responses(model, laws, np.array([60.0]), lines)
    forms: EnergyForms = model.space.forms([amplitude], panel.target.displacement)
    weight = forms.weighted(settings.kappa).plate[0]
    largest = np.linalg.eigvalsh(weight)[:, -1]
    weight = weight + (settings.tolerance**2 * largest)[:, None, None] * np.eye(weight.shape[-1])
    wanted = invert(forms.weighted(settings.kappa), settings.tolerance).filters[0]
    fit = FieldFit.of(settings)
    started = time.process_time()
    for _ in range(10):
        taps = fit.problem(weight, largest, wanted, settings.middle).solve(np.zeros(weight.shape[-1]))
    fast = (time.process_time() - started) / 10
    started = time.process_time()
    plain = dense(weight, wanted, settings, settings.middle)
    slow = time.process_time() - started
    band = settings.in_band(lines)
    spectrum = np.exp(-2j * np.pi * np.outer(lines[band], np.arange(settings.taps)) / settings.sample_rate)
    one, other = (contrast(forms.at(slice(None), band), (spectrum @ h.T)[None]) for h in (taps, plain))
    assert np.abs(one - other).max() < 1e-4, "the two ways give different fields"  # noqa: S101

    ratio = torch_ratio(fit.problem(weight, largest, wanted, settings.middle), 24)
    result = {
        "torch_batch_ratio": ratio,
        "design_241_seconds": whole,
        "design_241_processor_seconds": processor,
        "solve_seconds": fast,
        "dense_solve_seconds": slow,
        "ratio": slow / fast,
        "contrast_difference": float(np.abs(one - other).max()),
    }
    if laws_file is not None:
        with tempfile.TemporaryDirectory() as folder:
            for verb in ("focus", "compensate"):
                started = time.perf_counter()
                command = [sys.executable, "-m", "flexura", verb, str(laws_file), "--out", folder, "--quiet"]
                subprocess.run(command, check=False, env=dict(os.environ))
                result[f"{verb}_seconds"] = time.perf_counter() - started
    for name, value in result.items():
        print(f"{name:<32} {value:.4g}")
    (ROOT / "benchmarks" / "results").mkdir(exist_ok=True)
    (ROOT / "benchmarks" / "results" / "filters.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
