"""One BLAS thread, as `flexura` itself runs, for matrices are small; Ctrl-C heard even in a shell's background.

Windows are drawn into memory; where this system lacks what Qt needs, pytest-qt stays out and their tests skip.
"""

import os
import signal
from collections.abc import Iterator
from importlib import import_module

import pytest

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

# a shell starts background jobs with SIGINT ignored, and children inherit that: tests of Ctrl-C would wait in vain
signal.signal(signal.SIGINT, signal.default_int_handler)

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("PYQTGRAPH_QT_LIB", "PySide6")
try:
    import_module("PySide6.QtSvg")
    pytest_plugins = ["pytestqt.plugin"]
except ImportError:
    pytest_plugins = []


@pytest.fixture(scope="session", autouse=True)
def _reduced_plates(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep reduced plates in a folder of this run: each is computed once for all tests and processes."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLEXURA_CACHE", str(folder / "reduced-plates"))
        yield
