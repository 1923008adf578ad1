"""FRFs of a campaign as other programs take them: nodes, directions and quantities of universal files.

The outputs are nodes 1, 2, ... in the order of the declaration, the inputs the nodes after them. Direction 3 is
along z, out of the top face; what a patch does or reads has none, 0. Mains lines, never fitted, are in it too.
"""

from analysis.channel import Channel
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from analysis.frf import Frf


def campaign_frfs(experiment: Experiment, frf: Frf) -> list[MeasuredTransfer]:
    """Return every sweep's FRFs, sweep by sweep, with names that distinguish them."""
    inputs, outputs = experiment.inputs, experiment.outputs
    return [
        MeasuredTransfer(
            name=f"{label} {temperature:.2f} C {direction} {level:g} {source.unit}",
            response=f"{node}:{_direction(output)}",
            reference=f"{len(outputs) + 1 + which}:{_direction(source)}",
            quantity=output.quantity,
            frequency=frf.frequency,
            h=h,
            reference_quantity=source.quantity,
            units=(output.unit, source.unit),
        )
        for sweep, temperature, direction, level, which in zip(
            frf.h, frf.temperature, frf.direction, frf.level, frf.driven_by, strict=True
        )
        for source in (inputs[which],)
        for node, (output, label, h) in enumerate(
            zip(outputs, experiment.labels(source), sweep, strict=True), start=1
        )
    ]


def _direction(channel: Channel) -> str:
    return "+0" if channel.footprint is None else f"{3 * round(channel.footprint.along):+d}"
