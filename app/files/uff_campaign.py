"""FRFs of a campaign as other programs take them: nodes, directions and quantities of universal files.

The outputs are nodes 1, 2, ... in the order of the declaration, the inputs the nodes after them. Direction 3 is
along z, out of the top face; what a patch does or reads has none, 0. Mains lines, never fitted, are in it too.
"""

import numpy as np

from analysis.channel import Channel
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from analysis.frf import Frf

RANGE_MARGIN = 1.0
"""K that a temperature asked for may lie beyond those measured: readings differ from the temperatures declared."""


def campaign_frfs(experiment: Experiment, frf: Frf, sweep: int | None = None) -> list[MeasuredTransfer]:
    """Return a sweep's FRFs, or every sweep's, sweep by sweep, with names that distinguish them.

    Parameters
    ----------
    sweep : int, optional
        The only one, from 0.
    """
    inputs, outputs = experiment.inputs, experiment.outputs
    return [
        MeasuredTransfer(
            name=f"{label} {sweep_name(frf, number)}",
            response=f"{node}:{direction_of(output)}",
            reference=f"{len(outputs) + 1 + which}:{direction_of(source)}",
            quantity=output.quantity,
            frequency=frf.frequency,
            h=h,
            reference_quantity=source.quantity,
            units=(output.unit, source.unit),
        )
        for number, which in enumerate(frf.driven_by)
        if sweep in (None, number)
        for source in (inputs[which],)
        for node, (output, label, h) in enumerate(
            zip(outputs, experiment.labels(source), frf.h[number], strict=True), start=1
        )
    ]


def campaign_points(experiment: Experiment) -> dict[int, tuple[float, float, float]]:
    """Return where forces act and motions are read, m, by node; a patch is no point and has none."""
    channels = enumerate((*experiment.outputs, *experiment.inputs), start=1)
    return {node: (*one.footprint.point, 0.0) for node, one in channels if one.footprint is not None}


def sweep_name(frf: Frf, sweep: int) -> str:
    """Say which sweep it is: ``20.01 C up 0.3 V``."""
    level = f"{frf.level[sweep]:g} {frf.level_unit(sweep)}"
    return f"{frf.temperature[sweep]:.2f} C {frf.direction[sweep]} {level}"


def nearest_sweep(frf: Frf, temperature: float) -> int:
    """Return the sweep nearest to a temperature in degrees Celsius, the first of several.

    Raises ValueError where the campaign was not measured there.
    """
    low, high = float(frf.temperature.min()), float(frf.temperature.max())
    if not low - RANGE_MARGIN <= temperature <= high + RANGE_MARGIN:
        raise ValueError(f"--temperature {temperature:g} °C; the sweeps are from {low:.2f} to {high:.2f} °C")
    return int(np.argmin(np.abs(frf.temperature - temperature)))


def direction_of(channel: Channel) -> str:
    """Return the direction of a channel: ``+3`` out of the top face, ``+0`` of a patch."""
    return "+0" if channel.footprint is None else f"{3 * round(channel.footprint.along):+d}"
