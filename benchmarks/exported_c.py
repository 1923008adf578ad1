"""The exported C code's cost per sample, against the plain way of filtering.

Usage: python benchmarks/exported_c.py [--seconds S] [--results FILE]

Six filters of 512 taps at 44.1 kHz, networks of 10 nodes and a spline through 13 temperatures, float32 and int16,
compiled with gcc -O3. The plain way is the sum over the taps, sample by sample, through a circular buffer. Both
filter the same noise; their outputs are compared. Processor time is measured, in one thread.
"""

import argparse
import json
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from analysis.compensation.network import InputMap, NetworkBank
from analysis.focusing.fir import FirBank
from analysis.rendering.following import FollowingBank
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.exports.c_code import SAMPLES_AT_ONCE, Cost, write_c
from app.files.exports.shipment import Shipment
from app.files.provenance import provenance

RESULTS = Path(__file__).resolve().parent / "results" / "exported_c.json"
RATE = 44_100
MAIN = r"""
#define _POSIX_C_SOURCE 199309L
#include "flexura_filters.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#if FLEXURA_FIXED_POINT
typedef int64_t sum_type;
#else
typedef float sum_type;
#endif
static flexura_filters filters;
static flexura_tap taps[FLEXURA_ACTUATORS][FLEXURA_TAPS];
static flexura_sample ring[FLEXURA_TAPS];
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}
int main(int argc, char **argv)
{
    const int blocks = atoi(argv[argc - 1]);
    const int count = blocks * FLEXURA_BLOCK;
    flexura_sample *in = malloc(sizeof *in * (size_t)count), *out[FLEXURA_ACTUATORS], *plain[FLEXURA_ACTUATORS];
    double begun, ours, theirs, updates, error = 0.0, energy = 0.0;
    unsigned state = 1u;
    int n, i, m, place = 0;
    for (i = 0; i < count; i++) {
        state = 1664525u * state + 1013904223u;
#if FLEXURA_FIXED_POINT
        in[i] = (int16_t)((int)(state >> 16) - 32768);
#else
        in[i] = (float)(state >> 8) / 8388608.0f - 1.0f;
#endif
    }
    for (n = 0; n < FLEXURA_ACTUATORS; n++) {
        out[n] = malloc(sizeof **out * (size_t)count);
        plain[n] = malloc(sizeof **out * (size_t)count);
    }
    flexura_start(&filters, 31.0f);
    begun = now();
    flexura_process(&filters, in, out, (size_t)count);
    ours = now() - begun;
    flexura_taps(31.0f, taps);
    begun = now();
    for (i = 0; i < count; i++) {
        ring[place] = in[i];
        for (n = 0; n < FLEXURA_ACTUATORS; n++) {
            sum_type sum = 0;
            for (m = 0; m < FLEXURA_TAPS; m++)
                sum += (sum_type)taps[n][m] * ring[(place - m + FLEXURA_TAPS) % FLEXURA_TAPS];
#if FLEXURA_FIXED_POINT
            const int64_t half = sum < 0 ? -FLEXURA_DIVISOR / 2 : FLEXURA_DIVISOR / 2;
            plain[n][i] = (int16_t)((sum + half) / FLEXURA_DIVISOR);
#else
            plain[n][i] = sum;
#endif
        }
        place = (place + 1) % FLEXURA_TAPS;
    }
    theirs = now() - begun;
    begun = now();
    for (i = 0; i < 1000; i++)
        flexura_taps(0.06f * (float)i, taps);
    updates = (now() - begun) / 1000.0;
    for (n = 0; n < FLEXURA_ACTUATORS; n++)
        for (i = 0; i < count; i++) {
            error += pow((double)out[n][i] - (double)plain[n][i], 2.0);
            energy += pow((double)plain[n][i], 2.0);
        }
    printf("{\"sample_ns\": %.9g, \"plain_sample_ns\": %.9g, \"update_ns\": %.9g, "
           "\"relative_energy\": %.3g}", ours / count, theirs / count, updates, error / energy);
    return 0;
}
"""


def shipments() -> dict[str, Shipment]:
    """Networks and a spline as large as those of the section-2 panel; their values do not matter for the time."""
    rng = np.random.default_rng(0)
    knots = np.arange(0.0, 61.0, 5.0)
    decay = np.exp(-np.arange(512) / 150.0)
    fine = np.linspace(0.0, 60.0, 241)
    networks = NetworkBank(
        InputMap.of(fine, np.sqrt(1.0 + fine)),
        *rng.standard_normal((2, 6, 10)),
        rng.standard_normal((6, 11, 512)) * decay,
    )
    filters = FirBank(rng.standard_normal((13, 6, 512)) * decay, knots, float(RATE), 256)
    panel = read_panel(SECTION_2)
    names = tuple(patch.id for patch in panel.patch)
    banks = {
        "network": FollowingBank.of_networks(networks, float(RATE), 256),
        "cubic-spline": FollowingBank.of_filters(filters),
    }
    return {name: Shipment(bank, name, names, panel, provenance({})) for name, bank in banks.items()}


def case(shipment: Shipment, number: str, blocks: int) -> dict[str, Any]:
    """Compile and time one export."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_c(shipment, folder, number == "int16")
        (folder / "main.c").write_text(MAIN)
        command = ["gcc", "-std=c99", "-O3", "-Wall", "-Wextra", "-Werror", "-o", "program"]
        subprocess.run([*command, "main.c", "flexura_filters.c", "-lm"], cwd=folder, check=True)
        done = subprocess.run([folder / "program", str(blocks)], capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    cost = Cost.of(shipment.filters, number == "int16", SAMPLES_AT_ONCE)
    return found | {
        "method": shipment.method,
        "number": number,
        "ratio": found["plain_sample_ns"] / found["sample_ns"],
        "share_of_a_core": found["sample_ns"] * 1e-9 * RATE,
        "multiply_adds_per_ns": cost.sample_operations / found["sample_ns"],
        "constant_bytes": cost.constant_bytes,
        "state_bytes": cost.state_bytes,
    }


def main() -> None:
    """Run the cases, print them, write JSON; exit 1 where results differ or the plain way is quicker."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0, help="of audio")
    parser.add_argument("--results", type=Path, default=RESULTS)
    options = parser.parse_args()
    blocks = max(1, round(options.seconds * RATE / SAMPLES_AT_ONCE))
    cases = [case(sent, number, blocks) for sent in shipments().values() for number in ("float32", "int16")]
    for found in cases:
        print(
            f"{found['method']}, {found['number']}: {found['sample_ns']:.0f} ns a sample of six channels, "
            f"{100 * found['share_of_a_core']:.2f} % of a core; plain {found['plain_sample_ns']:.0f} ns, "
            f"ratio {found['ratio']:.1f}; update {found['update_ns'] / 1e3:.1f} us; "
            f"{found['constant_bytes'] / 1e3:.0f} kB constant, {found['state_bytes'] / 1e3:.0f} kB RAM; "
            f"outputs differ by {found['relative_energy']:.1e} of energy"
        )
    good = all(found["relative_energy"] < 1e-10 and found["ratio"] > 1.0 for found in cases)
    options.results.parent.mkdir(parents=True, exist_ok=True)
    record = {"machine": platform.platform(), "cases": cases, "good": good}
    options.results.write_text(json.dumps(record, indent=1) + "\n")
    print(f"{'as wanted' if good else 'FALLS SHORT'}: {options.results}")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
