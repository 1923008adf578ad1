"""Normal equations of poles on the lines of an FRF: by partial fractions against a product of all columns.

    python benchmarks/pole_products.py

Forty poles and six residual terms on 500, 1000 and 3000 lines, with derivative columns, as in every step of a
search for poles. Both ways must agree to rounding, relative to the lengths of the columns. Prints the ratios, and
writes benchmarks/results/pole_products.json.
"""

import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from analysis.identification.lines import WeightedLines
from analysis.identification.pole_residue import COMPLEX_E_F_G

POLES, LINES, TIMES = 40, (500, 1000, 3000), 50


def made(lines: int, rng: np.random.Generator) -> tuple[WeightedLines, NDArray[np.complex128]]:
    """Lines with one FRF, and poles with damping ratios of 1 to 5 %."""
    w = 2 * np.pi * np.linspace(100.0, 1500.0, lines)
    weight = rng.uniform(0.5, 2.0, lines)
    h = rng.normal(size=lines) + 1j * rng.normal(size=lines)
    rows = np.concatenate([COMPLEX_E_F_G.columns(1j * w, 2500.0), h[None]]) * weight
    zeta = rng.uniform(0.01, 0.05, POLES)
    poles = 2 * np.pi * np.sort(rng.uniform(80.0, 1600.0, POLES)) * (-zeta + 1j * np.sqrt(1 - zeta**2))
    return WeightedLines.of(w, weight, rows), poles


def seconds(call: Callable[[], object]) -> float:
    """Shortest of many calls."""
    taken = []
    for _ in range(TIMES):
        started = time.perf_counter()
        call()
        taken.append(time.perf_counter() - started)
    return min(taken)


def main() -> None:
    """Measure, compare, print and write."""
    result = {}
    for count in LINES:
        lines, poles = made(count, np.random.default_rng(0))

        def plain(lines: WeightedLines = lines, poles: NDArray[np.complex128] = poles) -> NDArray[np.float64]:
            rows = lines.line_by_line(poles, COMPLEX_E_F_G.parameters, derivatives=True)
            return rows @ rows.T

        def ours(lines: WeightedLines = lines, poles: NDArray[np.complex128] = poles) -> NDArray[np.float64]:
            return lines.at(poles, derivatives=True).gram(COMPLEX_E_F_G.parameters)

        with threadpool_limits(1):
            cost = {"plain_s": seconds(plain), "ours_s": seconds(ours)}
        wanted = plain()
        length = np.sqrt(np.diagonal(wanted))
        apart = float(np.abs(np.tril(ours() - wanted) / length / length[:, None]).max())
        if apart > 1e-11:
            raise SystemExit(f"the two ways differ by {apart:.1g}")
        result[str(count)] = cost | {"ratio": cost["plain_s"] / cost["ours_s"], "largest_difference": apart}
        print(f"{count} lines: {1e3 * cost['ours_s']:.2f} ms, plainly {1e3 * cost['plain_s']:.2f} ms: ", end="")
        print(f"{result[str(count)]['ratio']:.1f} times faster, {apart:.1g} apart")
    target = Path(__file__).resolve().parent / "results" / "pole_products.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
