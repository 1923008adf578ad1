"""What runs in a process of its own, and is killed."""

import os
import signal
import time
import warnings
from collections.abc import Callable


def killed(run: Callable[[], object], after: float, begun: Callable[[], bool] = lambda: True) -> bool:
    """Fork, run there, and send SIGKILL so many seconds after it has begun; False if it was done before."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of forking where threads are about: none runs here
        child = os.fork()
    if child == 0:
        try:
            run()
        except BaseException:  # noqa: BLE001 (nothing may come back into the test's own process)
            os._exit(9)
        os._exit(0)
    while not begun() and os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        time.sleep(0.01)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)
