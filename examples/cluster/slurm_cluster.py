"""Jobs of Slurm as a Dask cluster, for as long as one command of Flexura runs on it; from a login node.

    pip install 'flexura[cluster,slurm]'
    python slurm_cluster.py 20 blind-trial --count 1000 --seed 7 --out /shared/trial

The first word is the number of jobs; each is one worker with one processor. A job that Slurm ends early is
replaced, and its campaign begun again elsewhere. dask-jobqueue has the same for PBS, SGE, LSF and HTCondor.
"""

import subprocess
import sys

from dask_jobqueue import SLURMCluster

MEMORY = "2GB"
"""Of a job: a campaign takes up to 1.6 GB while the model of a panel is built."""
LONGEST = "04:00:00"
"""Of a job: longer than a campaign and its models take, short enough to be let in soon."""


def main() -> int:
    """Ask for the jobs, wait for the first, run the command, end the jobs."""
    jobs, words = int(sys.argv[1]), sys.argv[2:]
    with SLURMCluster(cores=1, processes=1, memory=MEMORY, walltime=LONGEST) as cluster:
        cluster.adapt(minimum_jobs=jobs, maximum_jobs=jobs)  # a job that ends is replaced
        cluster.wait_for_workers(1)  # however long the queue is
        command = [sys.executable, "-m", "flexura", *words, "--cluster", cluster.scheduler_address]
        return subprocess.run(command, check=False).returncode  # noqa: S603 (what was typed)


if __name__ == "__main__":
    sys.exit(main())
