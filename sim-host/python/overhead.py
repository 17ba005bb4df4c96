"""Overhead of Python in the run of a kinematic scene, which itself takes well below a millisecond. Run by `sim-host/python/check`.

    scene.run()                       minus the run in compiled code (`Result.run_s`)
    scene.run() and its metrics       minus the same: the summary is made and read, and one metric is looked up

Medians of wall times. The lowest decile of the first must be within the target, as other work on the machine disturbs some runs but not all.
"""

import statistics
import time

import sonoglide

RUNS = 500
TARGET_MS = 1.0


def added_ms(scene: sonoglide.Scene, read: bool) -> list[float]:
    added = []
    for _ in range(RUNS):
        began = time.perf_counter()
        result = scene.run()
        if read:
            result["friction_ratio"]
        added.append(1e3 * (time.perf_counter() - began - result.run_s))
    return added


scene = sonoglide.Scene.load("contact-kinematic")
run_ms = 1e3 * statistics.median(scene.run().run_s for _ in range(RUNS))
alone, with_metrics = added_ms(scene, read=False), added_ms(scene, read=True)
medians = [statistics.median(added) for added in (alone, with_metrics)]
print(f"contact-kinematic: run {run_ms:.3f} ms; Python adds {medians[0]:.3f} ms, with a metric read {medians[1]:.3f} ms")
undisturbed = statistics.quantiles(alone, n=10)[0]
assert undisturbed <= TARGET_MS, f"Python adds {undisturbed:.3f} ms to a run: more than {TARGET_MS} ms"
