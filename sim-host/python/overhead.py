"""What Python adds to the run of a kinematic scene, which itself takes well below a millisecond: `sim-host/python/check` runs this.

    scene.run()                       less the run in compiled code (`Result.run_s`)
    scene.run() and its metrics       less the same: with the summary made, read, and one metric looked up

Medians of wall times. The first must stay within the target.
"""

import statistics
import time

import sonoglide

RUNS = 500
TARGET_MS = 1.0


def added_ms(scene: sonoglide.Scene, read: bool) -> float:
    added = []
    for _ in range(RUNS):
        began = time.perf_counter()
        result = scene.run()
        if read:
            result["friction_ratio"]
        added.append(1e3 * (time.perf_counter() - began - result.run_s))
    return statistics.median(added)


scene = sonoglide.Scene.load("contact-kinematic")
run_ms = 1e3 * statistics.median(scene.run().run_s for _ in range(RUNS))
alone, with_metrics = added_ms(scene, read=False), added_ms(scene, read=True)
print(f"contact-kinematic: run {run_ms:.3f} ms; Python adds {alone:.3f} ms, with a metric read {with_metrics:.3f} ms")
assert alone <= TARGET_MS, f"Python adds {alone:.3f} ms to a run: more than {TARGET_MS} ms"
