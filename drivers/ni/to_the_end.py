"""Doing what must be done, whatever is pressed meanwhile."""

import threading
from collections.abc import Callable


def to_the_end(action: Callable[[], None]) -> None:
    """Run `action` to its end even if Ctrl-C is pressed meanwhile, then let the Ctrl-C through.

    Signals interrupt the main thread only, so another thread does the work.
    """
    failed: list[BaseException] = []

    def guarded() -> None:
        try:
            action()
        except BaseException as error:  # noqa: BLE001  handed to the thread that waits
            failed.append(error)

    worker = threading.Thread(target=guarded, name="output to 0 V")
    worker.start()
    interrupted: KeyboardInterrupt | None = None
    while worker.is_alive():
        try:
            worker.join()
        except KeyboardInterrupt as pressed:
            interrupted = pressed
    if failed:
        raise failed[0]
    if interrupted is not None:
        raise interrupted
