"""One BLAS thread, as `flexura` itself runs, for matrices are small; Ctrl-C heard even in a shell's background."""

import os
import signal

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

# a shell starts background jobs with SIGINT ignored, and children inherit that: tests of Ctrl-C would wait in vain
signal.signal(signal.SIGINT, signal.default_int_handler)
