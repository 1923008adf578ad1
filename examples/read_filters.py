"""Filters for a temperature out of compensation.h5, with h5py and numpy alone: to be copied to where they run.

    python examples/read_filters.py plate-run/compensation.h5 21.5 filters.csv

Writes one row per tap and one column per actuator, in volts per unit of audio signal.
"""

import json
import sys

import h5py
import numpy as np


def main() -> None:
    """Read the networks, ask them for the filters at one temperature, write them as text."""
    if len(sys.argv) != 4:
        sys.exit(f"usage: {sys.argv[0]} COMPENSATION.h5 TEMPERATURE FILTERS.csv")
    with h5py.File(sys.argv[1]) as file:
        networks = file["compensation/trained/networks"]
        known, value = networks["input/temperature"][:], networks["input/value"][:]
        slope, bias, output = (networks[name][:] for name in ("slope", "bias", "output"))
        panel = json.loads(file.attrs["panel"])
        rate, delay = (file["compensation/filters"].attrs[name] for name in ("sample_rate", "delay"))
    temperature = float(sys.argv[2])
    if not known[0] <= temperature <= known[-1]:
        print(f"{temperature:g} °C is beyond {known[0]:g} to {known[-1]:g} °C: the end's filters", file=sys.stderr)
    hidden = np.tanh(np.interp(temperature, known, value) * slope + bias)  # (N, H): actuators, nodes
    taps = np.einsum("nh,nhm->mn", hidden, output[:, :-1]) + output[:, -1].T  # (M, N)
    names = ",".join(patch["id"] for patch in panel["patch"])
    np.savetxt(sys.argv[3], taps, delimiter=",", header=names, comments="")
    print(f"{taps.shape[1]} filters of {taps.shape[0]} taps at {rate:g} Hz, modelling delay {delay} samples")


if __name__ == "__main__":
    main()
