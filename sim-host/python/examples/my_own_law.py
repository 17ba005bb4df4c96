"""A friction law as a function: here LuGre's, which the package has, to compare both.

    z' = v - |v| z / G(v),  G = Fc (1 + rise exp(-(v / vs)^2)) / k,  F = k z + s1 z'
"""

import math

from sonoglide import Law, Scene

MU, NORMAL_N, K_N_PER_M, RISE, VS_M_PER_S, S1 = 0.3, 20.0, 2e6, 0.3, 0.02, 1.0


def rates(v, z, sign, fc):
    """Returns the rates of the states, per second, and the friction, N."""
    rate = v - K_N_PER_M * sign * v * z[0] / (fc * (1 + RISE * math.exp(-((v / VS_M_PER_S) ** 2))))
    return [rate], K_N_PER_M * z[0] + S1 * rate


contact = {
    "grid": False,
    "excitation.sliding_m_per_s": 0.06,
    "rig.kinematic.vibration_m_per_s": 0.2,
    "contact.lugre.mu": MU,
    "contact.lugre.static_mu": MU * (1 + RISE),
    "contact.lugre.normal_n": NORMAL_N,
    "contact.lugre.stiffness_n_per_m": K_N_PER_M,
    "contact.lugre.stribeck_m_per_s": VS_M_PER_S,
    "contact.lugre.sigma1": S1,
}
scene = Scene.load("contact-kinematic", contact)
own, native = scene.run(law=Law(rates, start=[0.0])), scene.run()
print(f"own law {own['friction_ratio']:.9f}, built-in law {native['friction_ratio']:.9f}")
assert abs(own["friction_ratio"] - native["friction_ratio"]) < own["error_estimate"] + native["error_estimate"]
