"""A Dask cluster on this machine, for as long as one command of Flexura runs on it.

    python local_cluster.py 4 blind-trial --count 200 --seed 7
    python local_cluster.py 4 run campaigns --until focus

The first word is the number of workers. `flexura ... --workers 4` does the same without Dask, and starts sooner; a
cluster on one machine is for trying what will run on many.
"""

import subprocess
import sys

from distributed import LocalCluster

MEMORY = "2GB"
"""Of a worker: a campaign takes up to 1.6 GB while the model of a panel is built."""


def main() -> int:
    """Start the workers, run the command, end the workers."""
    workers, words = int(sys.argv[1]), sys.argv[2:]
    with LocalCluster(
        n_workers=workers, threads_per_worker=1, memory_limit=MEMORY, dashboard_address=":0"
    ) as cluster:
        command = [sys.executable, "-m", "flexura", *words, "--cluster", cluster.scheduler_address]
        return subprocess.run(command, check=False).returncode  # noqa: S603 (what was typed)


if __name__ == "__main__":  # workers are processes that read this file, too
    sys.exit(main())
