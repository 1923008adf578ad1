"""The state of campaigns in the text form of Prometheus, version 0.0.4."""

from collections.abc import Callable, Sequence
from typing import get_args

from app.watch.status import CampaignStatus, Standing

FORM = "text/plain; version=0.0.4; charset=utf-8"
Value = Callable[[CampaignStatus], float | None]
GAUGES: tuple[tuple[str, str, Value], ...] = (
    ("air_celsius", "Temperature of the air in the oven.", lambda one: one.air),
    ("plate_celsius", "Temperature of the plate.", lambda one: one.plate),
    ("set_point_celsius", "Set-point that follows from the commands sent.", lambda one: one.set_point),
    ("limit_coldest_celsius", "Temperature below which the campaign stops.", lambda one: one.coldest),
    ("limit_hottest_celsius", "Temperature above which the campaign stops.", lambda one: one.hottest),
    ("sweeps_finished", "Sweeps that were kept.", lambda one: one.finished),
    ("sweeps_given_up", "Sweeps that were given up.", lambda one: one.missing),
    ("sweeps_asked", "Sweeps of the whole campaign.", lambda one: one.total),
    ("sweeps_doubted", "Finished sweeps whose temperature is in doubt.", lambda one: one.doubted),
    ("left_seconds", "Estimate of the time to the end.", lambda one: one.seconds_left),
    ("silent_seconds", "Time since anything was written.", lambda one: one.silent_for),
    ("patience_seconds", "Time without a sign that is no reason to worry.", lambda one: one.patience),
    ("channels_clipping", "Channels of the last repeat that clipped.", lambda one: len(one.clipping)),
    ("not_at_rest", "1: something could not be verified to be at rest.", lambda one: float(bool(one.unsafe))),
)


def metrics(statuses: Sequence[CampaignStatus], delivered: int, failed: int) -> str:
    """Return the page that Prometheus reads.

    Parameters
    ----------
    delivered, failed : int
        Messages told, and those that could not be.

    Returns
    -------
    str
        What is not known has no line.
    """
    lines = []
    for name, text, value in GAUGES:
        lines += _head(f"flexura_{name}", text, "gauge")
        for one in statuses:
            found = value(one)
            if found is not None:
                lines.append(f'flexura_{name}{{campaign="{_label(one.name)}"}} {float(found)!r}')
    lines += _head("flexura_state", "1 for the state that the campaign is in.", "gauge")
    for one in statuses:
        for state in get_args(Standing):
            labels = f'campaign="{_label(one.name)}",state="{state}"'
            lines.append(f"flexura_state{{{labels}}} {int(one.state == state)}")
    lines += _head("flexura_messages_total", "Messages, by what became of them.", "counter")
    for became, count in (("told", delivered), ("failed", failed)):
        lines.append(f'flexura_messages_total{{became="{became}"}} {count}')
    return "\n".join(lines) + "\n"


def _head(name: str, text: str, kind: str) -> list[str]:
    return [f"# HELP {name} {text}", f"# TYPE {name} {kind}"]


def _label(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
