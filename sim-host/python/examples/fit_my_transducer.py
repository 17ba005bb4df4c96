"""Fit my transducer: the circuit of a measured impedance with standard deviations, and does the controller lock to it?

The measurement is synthetic: an impedance over 40 kHz with a noise of 0.1 %, in the format of an analyser. Replace the path by that of your own file.
"""

from pathlib import Path

import numpy as np

from sonoglide import MeasurementError, import_admittance

FS, Q, RM, C0 = 40.2e3, 180.0, 41.0, 3.1e-9
random = np.random.default_rng(3)
hz = np.linspace(39.4e3, 41.4e3, 401)
branch = RM * (1 + 1j * Q * (hz / FS - FS / hz))
z = 1 / (1 / branch + 2j * np.pi * hz * C0)
size = np.abs(z) * (1 + 1e-3 * random.standard_normal(hz.size))
angle = np.degrees(np.angle(z)) + np.degrees(1e-3) * random.standard_normal(hz.size)
path = Path("my-transducer.csv")
np.savetxt(path, np.column_stack([hz, size, angle]), delimiter=",", header="f [Hz],|Z| [ohm],theta [deg]", comments="")

found = import_admittance(path)
for name, number in found.circuit.items():
    print(f"{name:24} {number.value:12.6g} +- {number.sd:.2g}")
for name, truth in [("series_resonance_hz", FS), ("q", Q), ("rm_ohm", RM), ("c0_f", C0)]:
    number = found.circuit[name]
    assert number.sd is not None and abs(number.value - truth) < 4 * number.sd, name
print(f"residuals {np.sqrt(np.mean(np.abs(found.residual) ** 2) / 2):.2f} standard deviations of the noise; {len(found.modes)} resonance")
row = found.correlation.names.index("q")
print("correlation of q:", ", ".join(f"{name} {c:+.2f}" for name, c in zip(found.correlation.names, found.correlation.matrix[row])))

# The scene has the circuit as the truth, and its rounded values as the nominal values of the
# controller.
result = found.scene().run()
print(f"the controller finds {result['series_resonance_hz']:.1f} Hz and Q {result['q']:.1f}; fault code {result['fault_code']:.0f}")
assert result["fault_code"] == 0

try:
    import_admittance(path, columns="f [Hz], |Z| [furlong], theta [deg]")
except MeasurementError as error:
    print("refused:", error)
