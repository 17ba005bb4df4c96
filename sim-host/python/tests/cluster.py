"""Runs a sweep with one thread, and the same on a Dask cluster of two worker processes, one of which is killed midway. The argument is the folder of both."""

import os
import signal
import sys
import threading
import time
from pathlib import Path

from distributed import Client, LocalCluster

from sonoglide import Scene, _dask

OVER = {"stack.bvd.q": "30:100:24", "controller.drive.amplitude_v": [2.0, 3.0]}
METRICS = ["lock_time_20hz_ms", "frequency_bias_hz"]


def main(folder: Path) -> None:
    scene = Scene.load("lock")
    scene.sweep(OVER, metrics=METRICS, jobs=1, output=folder / "one")
    _dask.TASK_S = 0.2
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster, Client(cluster) as client:

        def kill() -> None:
            parts = folder / "cluster"
            while len(list(parts.glob("part-*"))) < 2:
                time.sleep(0.002)
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
            print("a worker was killed", flush=True)

        killer = threading.Thread(target=kill)
        killer.start()
        scene.sweep(OVER, metrics=METRICS, client=client, output=folder / "cluster")
        killer.join()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
