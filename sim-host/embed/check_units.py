"""Exports units, and checks them with FMPy: the description, the hash and the friction of the run, the refusals, the speed."""

import ctypes
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

program, scratch = sys.argv[1], Path(sys.argv[2])


def sim_host(*arguments):
    return subprocess.run([program, *arguments], cwd=scratch, capture_output=True, text=True, check=False)


def export(scene, name, *arguments):
    done = sim_host("export", "fmu", scene, "-o", name, *arguments)
    assert done.returncode == 0, done.stderr
    problems = validate_fmu(str(scratch / name))
    assert not problems, problems
    return str(scratch / name)


def run(scene, *arguments):
    began = time.perf_counter()
    done = sim_host("run", scene, *arguments, "--format", "json", "-q", "--no-report")
    assert done.returncode in (0, 4), done.stderr
    return json.loads(done.stdout), time.perf_counter() - began


BURSTS = ["--set", "controller.burst.on_s=[0.4]", "--set", "controller.burst.off_s=[0.6]"]
for scene, duration_s, further in [("experiment-1", 1.0, BURSTS), ("friction-ratio", 1.0, []), ("lock", 0.5, [])]:
    changes = ["--set", f"duration_s={duration_s}", "--set", "grid=false", "--set", "expect=[]", *further]
    path = export(scene, f"{scene}.fmu", *changes)
    summary, took_s = run(scene, *changes)
    began = time.perf_counter()
    result = simulate_fmu(path, stop_time=duration_s, step_size=1e-3, output_interval=1e-3, fmi_type="CoSimulation")
    unit_s = time.perf_counter() - began
    played = f"{result['drive_hash'][-1]:016x}"
    assert played == summary["drive_hash"], (scene, played, summary["drive_hash"])
    print(f"{scene}: {len(result)} rows, drive hash {played}, {unit_s:.2f} s with FMPy, {took_s:.2f} s as a run")

# Inputs: the load changes the friction, the drive lowers it.
path = export("experiment-1", "load.fmu", "--set", "controller.burst.off_s=[9]", "--set", "duration_s=10")
signals = np.array(
    [(0.0, 0, 5.0), (0.3, 1, 5.0), (0.6, 2, 5.0), (0.6, 2, 10.0)],
    dtype=[("time", float), ("gate", np.int32), ("load_n", float)],
)
result = simulate_fmu(path, stop_time=0.9, step_size=1e-3, output_interval=1e-3, input=signals)
before, on, after = (result["friction_n"][int(at) - 20 : int(at)].mean() for at in (290, 590, 890))
print(f"friction {before:.3f} N, ON {on:.3f} N, twice the load {after:.3f} N")
assert on < 0.7 * before and after > 1.5 * before

# The controller alone, in a loop with the plant of the C library: the codes of the run.
path = export("lock", "controller.fmu", "--controller", "--set", "duration_s=0.5")
description = read_model_description(path)
variables = {variable.name: variable for variable in description.modelVariables}
samples = int(variables["v_code"].dimensions[0].start)
step_s = float(description.coSimulation.fixedInternalStepSize)
folder = extract(path)
slave = FMU3Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName="controller")
slave.instantiate()
slave.enterInitializationMode()
slave.exitInitializationMode()
(library,) = Path(folder).glob("binaries/*/*")
c = ctypes.CDLL(str(library))
c.sonoglide_plant_new.restype = ctypes.c_void_p
plant = ctypes.c_void_p(c.sonoglide_plant_new(b"lock", None, 0))
Block = ctypes.c_uint16 * samples
silence = slave.getUInt16([variables["codes"].valueReference], nValues=samples)
queue = [Block(*silence) for _ in range(2)]
v, i = Block(), Block()
blocks = round(0.5 / step_s)
for block in range(blocks):
    assert c.sonoglide_plant_step(plant, queue[block % 2], 0, v, i, None) == 0
    slave.setUInt16([variables[name].valueReference for name in ("v_code", "i_code")], [*v, *i])
    slave.doStep(block * step_s, step_s)
    queue[block % 2] = Block(*slave.getUInt16([variables["codes"].valueReference], nValues=samples))


class Truth(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double) for name in ("friction_n", "tip_velocity_m_per_s", "series_resonance_hz", "power_w")] + [("drive_hash", ctypes.c_uint64)]


truth = Truth()
assert c.sonoglide_plant_truth(plant, ctypes.byref(truth)) == 0
(frequency_hz,) = slave.getFloat64([variables["frequency_hz"].valueReference])
print(f"controller alone: {frequency_hz:.1f} Hz, resonance {truth.series_resonance_hz:.1f} Hz, drive hash {truth.drive_hash:016x}")
summary, _ = run("lock", "--set", "duration_s=0.5", "--set", "expect=[]")
assert f"{truth.drive_hash:016x}" == summary["drive_hash"], summary["drive_hash"]
try:
    slave.doStep(blocks * step_s, 2 * step_s)
    raise SystemExit("another step was accepted")
except Exception as refused:
    print(f"another step: {str(refused).splitlines()[0]}")
slave.terminate()
slave.freeInstance()

refused = sim_host("export", "fmu", "contact", "-o", "contact.fmu")
assert refused.returncode == 3 and "has no [controller]" in refused.stderr, refused
