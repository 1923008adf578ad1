"""Tracking of a recorded campaign from its cold and from its warm end: agreement, identity, error.

    python benchmarks/tracking.py CAMPAIGN TRUTH.npz [--twin-error 0.003] [--bound]

TRUTH.npz holds `poles` (T, J), rad/s, and `relative_height` (T, J), each mode's peak over the largest in band, as
`tests/analysis/identification/data/pp-plate-nominal.npz` does. Large modes make more than a tenth of that peak.
Both ends are searched, whichever one begins at, so that both ways have to agree.
`--bound` says of every mode that changed its track, and of those within its half width, what the sweeps have
for it (`tracking_bound.py`): where that is less than BIC asks, a search by BIC cannot tell how many stand there.
`--twin-error` also fits with a twin whose frequencies are off by so much, each by a draw of its own.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits
from tracking_bound import worth

from analysis.identification.over_temperature.expected_modes import ExpectedModes
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.over_temperature.tracking import track
from analysis.recordings.frf import Frf, campaign_frf
from app.files.campaigns.loading import load_campaign

TRUTH_ERROR = (3e-4, 1e-3)
"""Of truth's frequencies and loss factors: another finite-element solver's, at temperatures known to 0.02 K."""

MARGIN = 0.05, 0.015
"""Shares of the band's lower and upper edge within which no mode is asked for."""


def readings(tracked: TrackedModes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequency and loss factor (2, T, N) of every track, and their standard deviations."""
    read = tracked.reading()
    return (
        np.stack([read.frequency_hz, read.loss_factor]),
        np.stack([read.sigma_frequency_hz, read.sigma_loss_factor]),
    )


def against(
    tracked: TrackedModes, poles: NDArray[np.complex128], large: NDArray[np.bool_]
) -> tuple[str, list[tuple[int, int]]]:
    """Say how the large modes were found, and at which sweeps which modes changed their track.

    A mode has changed its track where the one it had does not hold it within its 95 % interval any longer. The
    nearest track alone tells nothing where two stand closer than either is known.
    """
    true = np.stack([np.sqrt((-(poles**2)).real) / (2.0 * np.pi), (poles**2).imag / (poles**2).real])
    found, spread = readings(tracked)
    own, kept = np.full(large.shape, -1), {}
    error, standard, changes = [], [], []
    for t, j in np.argwhere(large):
        away = np.abs(found[0, t] / true[0, t, j] - 1.0)
        n = int(np.nanargmin(away))
        if away[n] <= 0.5 * true[1, t, j]:
            own[t, j] = n
            error.append(found[:, t, n] / true[:, t, j] - 1.0)
            standard.append(error[-1] / np.hypot(spread[:, t, n] / true[:, t, j], TRUTH_ERROR))
            before = kept.setdefault(j, n)
            if before != n and not away[before] < 1.96 * np.hypot(
                spread[0, t, before] / true[0, t, j], TRUTH_ERROR[0]
            ):
                kept[j] = n
                changes.append((int(t), int(j)))
    nearest = sum(int((np.diff(row[row >= 0]) != 0).sum()) for row in own.T)
    covered = 100 * np.mean(np.abs(standard) < 1.96, axis=0)
    middle = 100 * np.median(np.abs(error), axis=0)
    told = (
        f"{(own >= 0).sum()} of {large.sum()} large modes, {len(changes)} identity changes "
        f"({nearest} by the nearest track), median error {middle[0]:.3f} % of f, {middle[1]:.2f} % of eta, "
        f"95 % intervals hold {covered[0]:.0f} % and {covered[1]:.0f} %"
    )
    return told, changes


def agreement(one: TrackedModes, other: TrackedModes) -> tuple[int, int, int]:
    """Poles of the first, those the second has within two deviations, those within a tenth of the half width."""
    (a, sigma), (b, _) = readings(one), readings(other)
    count = close = near = 0
    for t, n in np.argwhere(np.isfinite(a[0])):
        away = np.abs(b[0, t] - a[0, t, n])
        if not np.isfinite(away).any():
            count += 1
            continue
        m = int(np.nanargmin(away))
        count += 1
        close += bool(away[m] < 2.0 * sigma[0, t, n] and abs(b[1, t, m] - a[1, t, n]) < 2.0 * sigma[1, t, n])
        near += bool(away[m] < 0.05 * a[1, t, n] * a[0, t, n])
    return count, close, near


def bound(frf: Frf, poles: NDArray[np.complex128], changes: list[tuple[int, int]]) -> None:
    """Print what the sweeps have for the modes that changed their track and for their neighbours."""
    near = set()
    for t, j in changes:
        print(
            f"mode {j} changes its track at {frf.temperature[t]:.1f} °C, {abs(poles[t, j]) / (2 * np.pi):.1f} Hz"
        )
        near |= set(np.flatnonzero(np.abs(poles[t] - poles[t, j]) < -poles[t, j].real).tolist())
    for j, one in worth(frf, poles, sorted(near)).items():
        print(f"leaving out mode {j} costs {one.rise:.0f}; BIC asks {one.price:.0f}")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("campaign", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--twin-error", type=float, help="also with a twin, relative error of its frequencies")
    parser.add_argument("--bound", action="store_true", help="what the sweeps have for modes that changed track")
    options = parser.parse_args()
    frf = campaign_frf(load_campaign(options.campaign), mains=50.0)
    data = np.load(options.truth)
    poles = data["poles"].astype(complex)
    place, (low, high) = np.abs(poles) / (2.0 * np.pi), frf.frequency[[0, -1]]
    large = (data["relative_height"] > 0.1) & (place > low * (1 + MARGIN[0])) & (place < high * (1 - MARGIN[1]))
    order = np.argsort(frf.temperature)
    ways: dict[str, dict[str, object]] = {
        "cold end": {"start": int(order[0])},
        "warm end": {"start": int(order[-1])},
    }
    if options.twin_error:
        off = np.exp(options.twin_error * np.random.default_rng(0).normal(size=poles.shape[1]))
        ways["twin"] = {"expected": ExpectedModes(poles.real + 1j * off * poles.imag)}
    done, changes = {}, set()
    with threadpool_limits(1):
        for way, how in ways.items():
            started = time.process_time()
            done[way] = track(frf, **how)  # type: ignore[arg-type]
            seconds = time.process_time() - started
            told, changed = against(done[way], poles, large)
            changes |= set(changed)
            print(f"{way}: {told}; {seconds:.1f} s", flush=True)
        if options.bound:
            bound(frf, poles, sorted(changes))
    for one, other in (("cold end", "warm end"), ("warm end", "cold end")):
        count, close, near = agreement(done[one], done[other])
        print(
            f"of {count} poles from the {one}, {100 * close / count:.1f} % lie within two deviations of one from "
            f"the {other}, {100 * near / count:.1f} % within a tenth of a half width"
        )


if __name__ == "__main__":
    main()
