"""Garbage collected in the thread of the windows alone.

Python collects wherever memory happens to be asked for. In a thread that computes, that would take windows apart
which belong to another, and Qt does not survive it.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from PySide6.QtCore import QTimer

LOOK_INTERVAL = 200
"""Milliseconds between two looks."""


@contextmanager
def collected_here() -> Iterator[None]:
    """Collect from this thread's event loop, and from nowhere else, within the block."""
    timer = QTimer()
    timer.timeout.connect(collect)
    gc.disable()
    timer.start(LOOK_INTERVAL)
    try:
        yield
    finally:
        timer.stop()
        gc.enable()


def collect() -> None:
    """Collect the oldest generation that is due, as Python would."""
    for generation in (2, 1, 0):
        if gc.get_count()[generation] > gc.get_threshold()[generation]:
            gc.collect(generation)
            return
