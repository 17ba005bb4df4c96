#!/usr/bin/env python3
"""Numbers of docs/board.md and docs/evidence/board.md: from the bill of materials, by calculation and by ngspice.

    python3 docs/front-end/check.py          Python 3.9 or later, ngspice 39; half a minute

It fails where the netlists and the bill differ, where the circuit is not that of the firmware's config.rs, and where a limit of docs/board.md is not kept.
"""

import csv
import itertools
import math
import os
import random
import re
import subprocess
import tempfile
from cmath import phase

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = os.path.join(HERE, "../../firmware/boards/nucleo-g474re/src/config.rs")
UNITS = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3, "meg": 1e6}
CODE = 3.3 / 4096
VMID = 1.65
RAIL = 24.0
# Data sheets: see the table of sources in docs/evidence/board.md.
OPA_OFFSET, OPA_NOISE = 0.2e-3, 4.5e-9
LM_OFFSET, LM_BIAS_OFFSET, LM_QUIESCENT = 10e-3, 0.2e-6, 0.05


def number(text):
    value, unit = re.fullmatch(r"(-?[\d.]+(?:e-?\d+)?)(meg|[pnumk]?)", text).groups()
    return float(value) * UNITS.get(unit, 1.0)


def bill():
    values = {}
    with open(os.path.join(HERE, "bom.csv"), encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            for reference in line["Reference"].split(","):
                values[reference] = (line["Value"], line["Tolerance"])
    return values


def require(condition, what):
    if not condition:
        raise SystemExit(f"FAILED: {what}")


def heading(text):
    print(f"\n== {text}")


BILL = bill()
R = {name: number(value) for name, (value, _) in BILL.items() if re.fullmatch(r"[RCL]\d+", name) and name != "L201"}
TOLERANCE = {name: float(text.split()[0]) / 100 for name, (_, text) in BILL.items() if text.endswith(" %")}


class Netlist:
    def __init__(self, name):
        with open(os.path.join(HERE, name), encoding="utf-8") as file:
            self.text = file.read()
        for reference, value in re.findall(r"\b([RCL]\d{3})=(\S+)", self.text):
            require(number(value) == R[reference], f"{name}: {reference} is {value}, in the bill {BILL[reference][0]}")

    def run(self, replace=(), **parameters):
        text = self.text
        for name, value in parameters.items():
            text, count = re.subn(rf"(\.param.*?\b{name}=)\S+", rf"\g<1>{value}", text, count=1)
            require(count == 1, f"a parameter {name}")
        for old, new in replace:
            require(old in text, old)
            text = text.replace(old, new)
        with tempfile.NamedTemporaryFile("w", suffix=".cir", delete=False) as file:
            file.write(text)
        try:
            out = subprocess.run(["ngspice", "-b", file.name], capture_output=True, text=True, check=False).stdout
        finally:
            os.unlink(file.name)
        found = {}
        for line in out.splitlines():
            if line.startswith("RESULT"):
                words = line.split()[1:]
                key = words[0] if words[0] != "sense" else words[0] + words[1]
                found[key] = [float(word) for word in words[2 if words[0] == "sense" else 1:]]
            if "THD" in line:
                found["thd"] = float(re.search(r"THD: ([\d.e+-]+)", line)[1])
        return found


def corners(names, function):
    """Smallest and largest value with every resistor at either end of its tolerance."""
    values = []
    for signs in itertools.product((-1, 1), repeat=len(names)):
        r = dict(R)
        for name, sign in zip(names, signs):
            r[name] *= 1 + sign * TOLERANCE[name]
        values.append(function(r))
    return min(values), max(values)


def difference(r, inp, ref, inn, fb, plus, minus, middle):
    """Output of a difference amplifier with an ideal op-amp."""
    node = (plus * r[ref] + middle * r[inp]) / (r[inp] + r[ref])
    return node + (node - minus) * r[fb] / r[inn]


VOLTAGE = ("R202", "R204", "R203", "R205")
CURRENT = ("R207", "R209", "R208", "R210")
# Of the power amplifier the "reference" of the upper input is ground, and VMID is the lower input.
DRIVE = ("R104", "R105", "R106", "R107")


def scales():
    heading("scale factors, from the bill of materials")
    with open(CONFIG, encoding="utf-8") as file:
        text = file.read()
    constant = {name: float(value) for name, value in re.findall(r"const (\w+): f32 = ([\d.]+);", text)}
    drive = lambda r: difference(r, *DRIVE, 1.0, 0.0, 0.0)
    volt = lambda r: difference(r, *VOLTAGE, 1.0, 0.0, 0.0)
    ampere = lambda r: difference(r, *CURRENT, r["R201"], 0.0, 0.0)
    for name, function, resistors, expected in (
        ("drive, V/V", drive, DRIVE, constant["AMPLIFIER"]),
        ("voltage, V/V", volt, VOLTAGE, 1 / constant["DIVIDER"]),
        ("current, V/A", ampere, CURRENT + ("R201",), constant["TRANSIMPEDANCE"]),
        ("current without the shunt, V/V", lambda r: difference(r, *CURRENT, 1.0, 0.0, 0.0), CURRENT, 4.0),
    ):
        nominal = function(R)
        low, high = corners(resistors, function)
        require(abs(nominal / expected - 1) < 1e-9, f"{name}: {nominal}, not {expected}")
        print(f"{name:32} {nominal:8.4f}   worst case {100 * (low / nominal - 1):+.2f} … {100 * (high / nominal - 1):+.2f} %")
    print(f"a code: drive {1e3 * CODE * constant['AMPLIFIER']:.3f} mV, voltage {1e3 * CODE / 2 * constant['DIVIDER']:.3f} mV, "
          f"current {1e3 * CODE / 2 / constant['TRANSIMPEDANCE']:.4f} mA")
    common = corners(VOLTAGE, lambda r: difference(r, *VOLTAGE, 1.0, 1.0, 0.0))
    print(f"voltage channel, common mode: {1e6 * max(map(abs, common)):.0f} uV/V; 0.3 V at the shunt is {1e3 * 0.3 * 12.5 * max(map(abs, common)):.1f} mV at the stack")


def rest():
    heading("offset at rest, worst case, codes of 12 bits")
    middle = TOLERANCE["R215"] * VMID + OPA_OFFSET
    for name, chain, gain in (("voltage", VOLTAGE, 1 + R["R205"] / R["R203"] + 2 * R["R205"] / R["R206"]), ("current", CURRENT, 1 + R["R210"] / R["R208"])):
        mismatch = max(abs(v - VMID) for v in corners(chain, lambda r: difference(r, *chain, 0.0, 0.0, VMID)))
        parts = (middle, mismatch, gain * OPA_OFFSET, OPA_OFFSET)
        codes = sum(parts) / CODE
        print(f"{name}: 1.65 V {middle / CODE:.1f}, resistors {mismatch / CODE:.1f}, op-amps {(gain + 1) * OPA_OFFSET / CODE:.1f}; in all {codes:.1f} codes of 200; noise gain {gain:.2f}")
        require(codes < 200, "the allowance of docs/board.md at rest")
    gain = R["R107"] / R["R106"]
    source = R["R104"] * R["R105"] / (R["R104"] + R["R105"])
    mismatch = max(map(abs, corners(DRIVE, lambda r: difference(r, *DRIVE, VMID, VMID, 0.0))))
    parts = (gain * (middle + OPA_OFFSET), mismatch, (1 + gain) * LM_OFFSET, (1 + gain) * LM_BIAS_OFFSET * source)
    print("drive, at the stack: 1.65 V and buffer %.0f mV, resistors %.0f mV, LM3886 offset %.0f mV, its bias %.0f mV; in all %.0f mV" % (*(1e3 * p for p in parts), 1e3 * sum(parts)))


def noise():
    heading("noise at the pins, rms, without the ADC's own")
    kt = 4 * 1.380649e-23 * 300
    band = math.pi / 2 / (2 * math.pi * R["R211"] * R["C201"])
    for name, chain, gain in (("voltage", VOLTAGE, 1 + R["R205"] / R["R203"] + 2 * R["R205"] / R["R206"]), ("current", CURRENT, 1 + R["R210"] / R["R208"])):
        inp, ref, inn, fb = (R[n] for n in chain)
        thermal = kt * (fb + fb * fb / inn) * 2
        if name == "voltage":
            thermal += kt / R["R206"] * (2 * fb) ** 2
        density = math.sqrt((gain * OPA_NOISE) ** 2 + thermal + OPA_NOISE**2 + kt * R["R211"])
        rms = density * math.sqrt(band)
        unit, scale = ("mV", 12.5e3) if name == "voltage" else ("mA", 2.5e3)
        print(f"{name}: {1e9 * density:.0f} nV/rtHz, {1e6 * rms:.0f} uV in {band / 1e3:.0f} kHz = {rms / CODE:.3f} codes = {rms * scale:.2f} {unit}")


def sense(netlist):
    heading("sense channels, ngspice: error of the gains, delays, skew (delay of V less delay of I)")
    cases = [
        ("nominal: shunt of 2 nH, stray 0.1 pF, 50 MHz", {}),
        ("shunt without inductance", {"esl": "1f"}),
        ("shunt of 5 nH", {"esl": "5n"}),
        ("op-amps of 25 MHz", {"gbw": "25meg"}),
        ("op-amp of I 20 % slower than that of V", {"ratio": 0.8}),
        ("without R206 (noise gain of V 1.08)", {"R206": "1e9"}),
        ("multiplexer of 75 ohm before both filters", {"R211": "1.675k", "R213": "1.675k"}),
        ("multiplexer of 75 and 85 ohm", {"R211": "1.675k", "R213": "1.685k"}),
    ]
    for name, parameters in cases:
        result = netlist.run(**parameters)
        line = []
        for f in ("20k", "40k", "100k"):
            gain_v, gain_i, delay_v, delay_i, skew = result["sense" + f]
            line.append(f"{f}: {100 * (gain_v * 12.5 - 1):+.2f}, {100 * (gain_i / 0.4 - 1):+.2f} %, {delay_v:.0f}, {delay_i:.0f}, {skew:+.1f} ns")
        print(f"{name}\n    " + "\n    ".join(line))
    print(f"corner (-3 dB): {netlist.run()['corner'][0] / 1e3:.0f} kHz")
    stage = [("ac dec 200 1k 10meg", "ac dec 200 1k 200meg"), ("let g = abs(v(vadc)", "let g = abs(v(v1)"), ("meas ac corner when g=0.70711 fall=1", "meas ac corner max g")]
    for name, parameters in (("with R206", {}), ("without R206", {"R206": "1e9"})):
        print(f"largest gain of U2A {name}: {20 * math.log10(netlist.run(stage, **parameters)['corner'][0]):+.1f} dB")
    print("trip: from a step of the current to the threshold of 3.5 A at the pin: " + ", ".join(f"{ampere} A {trip_us(ampere):.2f} us" for ampere in (4, 7, 11.5)))
    heading("sense channels, 300 boards drawn at random at 40 kHz (ngspice; uniform within the tolerances; shunt 0.5 to 5 nH, op-amps 35 to 65 MHz)")
    draw = random.Random(20)
    names = sorted(set(re.findall(r"\b([RC]2\d\d)=", netlist.text)) - {"R206"})
    runs = []
    for _ in range(300):
        parameters = {name: repr(R[name] * (1 + TOLERANCE[name] * draw.uniform(-1, 1))) for name in names}
        parameters.update(esl=repr(draw.uniform(0.5e-9, 5e-9)), gbw=repr(draw.uniform(35e6, 65e6)), ratio=repr(draw.uniform(0.95, 1.05)), stray=repr(draw.uniform(0.03e-12, 0.2e-12)))
        gain_v, gain_i, *_, skew = netlist.run(**parameters)["sense40k"]
        runs.append((100 * (gain_v * 12.5 - 1), 100 * (gain_i / 0.4 - 1), skew))
    for name, unit, values in zip(("gain of V", "gain of I", "skew"), ("%", "%", "ns"), zip(*runs)):
        mean = sum(values) / len(values)
        deviation = math.sqrt(sum((v - mean) ** 2 for v in values) / len(values))
        print(f"{name}: mean {mean:+.2f}, standard deviation {deviation:.2f}, {min(values):+.2f} … {max(values):+.2f} {unit}")
    require(max(abs(r[2]) for r in runs) < 200, "a skew of 200 ns, which the controller bears")


def trip_us(ampere):
    """Time after a step from 0 at which the two low-passes of the current channel are at 3.5 A."""
    slow, fast = R["R213"] * R["C203"], R["R214"] * R["C204"]
    rises = lambda t: 1 - (slow * math.exp(-t / slow) - fast * math.exp(-t / fast)) / (slow - fast)
    return next(n / 100 for n in range(1000) if rises(n * 1e-8) * ampere >= 3.5)


def drive(netlist):
    heading("drive path, ngspice, LM3886 of 8 MHz, 1 ohm: gain and phase at the stack, -3 dB, largest gain, remaining image of the DAC at 960 kHz")
    for load in ("1n", "3.6n", "30n", "100n", "300n", "1u"):
        g = netlist.run(cload=load)["gain"]
        held = math.sin(0.96 * math.pi) / (0.96 * math.pi) / (math.sin(0.04 * math.pi) / (0.04 * math.pi))
        print(f"{load:>5}F: 20 kHz {g[0]:.2f}, {g[1]:.1f}°; 40 kHz {g[2]:.2f}, {g[3]:.1f}°; 100 kHz {g[4]:.2f}, {g[5]:.1f}°; "
              f"-3 dB {g[6] / 1e3:.0f} kHz; largest {20 * math.log10(g[7] / 10):+.1f} dB; image {100 * held * g[8] / g[2]:.3f} %")
    heading("loop of the LM3886, ngspice: crossover, kHz, and phase margin, degrees")
    loads = ("1p", "1n", "10n", "30n", "100n", "300n", "1u")
    print("GBW, Ro".ljust(18) + "".join(f"{load:>12}F" for load in loads))
    least = {}
    for width in ("2meg", "8meg", "16meg"):
        for output in ("0.3", "1", "4"):
            row = []
            for load in loads:
                crossover, margin = netlist.run(gbw=width, ro=output, cload=load)["loop"]
                row.append(f"{crossover / 1e3:6.0f}, {margin:3.0f}°")
                if load != "1u":
                    least[output] = min(least.get(output, 180), margin)
            print(f"{width:>6}Hz, {output:>3} ohm  " + "".join(f"{cell:>13}" for cell in row))
    print("least to 300 nF: " + ", ".join(f"{margin:.0f}° with {output} ohm" for output, margin in least.items()))
    without = netlist.run(L101="1f", R113="1m")["loop"]
    print(f"without L101 and R113, 300 nF: crossover {without[0] / 1e3:.0f} kHz, margin {without[1]:.0f}°")
    heading("full drive, 1.65 V peak at the DAC, ngspice: peak at the stack and of the current, distortion")
    for load in ("3.6n", "300n"):
        for hz in (20, 40, 100):
            for what, width, slew in (("least of the data sheet, 2 MHz, 8 V/us", "2meg", 8), ("usual, 8 MHz, 19 V/us", "8meg", 19)):
                r = netlist.run([("sin(0 1.65 40k)", f"sin(0 1.65 {hz}k)"), ("fourier 40k", f"fourier {hz}k")], gbw=width, slew=slew, cload=load)
                print(f"{load:>5}F, {hz:3} kHz, {what:38}: {r['full'][0]:.1f} V, {r['full'][1]:.2f} A, {r['thd']:.2f} %")


def loads():
    heading("load: largest voltage (14.5 V of DAC1; 3 A), dissipation of the LM3886, junction at 40 °C (1 + 0.5 + 0.8 K/W)")
    for name, hz, c, rm in (
        ("experiment-1 stack, as it is driven (3 V)", 40e3, 300e-9, 3.08),
        ("experiment-1 stack, at its resonance", 40e3, 300e-9, 3.08),
        ("the same, off resonance (300 nF)", 40e3, 300e-9, None),
        ("the same, 100 nF", 40e3, 100e-9, None),
        ("300 nF at 20 kHz", 20e3, 300e-9, None),
        ("300 nF at 100 kHz", 100e3, 300e-9, None),
        ("Langevin of 7.1 ohm, 4.4 nF", 40e3, 4.422e-9, 7.115),
        ("Langevin of 17 to 25 ohm, 4 nF", 40e3, 3.4e-9, 17.2),
    ):
        y = complex(0 if rm is None else 1 / rm, 2 * math.pi * hz * c)
        volt = 3.0 if "3 V" in name else min(14.5, 3.0 / abs(y))
        ampere = volt * abs(y)
        supply = 2 * RAIL * ampere / math.pi
        real = volt * ampere * math.cos(phase(y)) / 2
        heat = supply - real + 2 * RAIL * LM_QUIESCENT
        print(f"{name:44} {volt:5.1f} V, {ampere:5.2f} A, load {real:5.1f} W, LM3886 {heat:5.1f} W, {40 + 2.3 * heat:4.0f} °C, shunt {ampere**2 / 2 * R['R201']:.2f} W")
    heat = 2 * RAIL * 3.0 / math.pi + 2 * RAIL * LM_QUIESCENT
    print(f"worst: 3 A peak into a pure capacitance: {heat:.0f} W, {40 + 2.3 * heat:.0f} °C")
    print(f"the heat sink is then at {40 + 0.8 * heat:.0f} °C; at 65 °C, where 85 °C as the limit begins to derate, the junction is at {65 + 1.5 * heat:.0f} °C")
    omega = 2 * math.pi * 40e3
    print(f"capacitance with 3 A at 14.5 V: {3e9 / 14.5 / omega:.0f} nF at 40 kHz, {6e9 / 14.5 / omega:.0f} nF at 20 kHz")
    for name, band, slew in (("OPA549", 0.9e6, 9), ("LM3886", 8e6, 19)):
        loop = 1 / complex(1, 40e3 * 11 / band)
        print(f"{name}: gain of 10 at 40 kHz {10 * abs(loop):.2f}, {math.degrees(phase(loop)):.0f}°; slew rate for {1e3 * slew / (2 * math.pi * 16.5):.0f} kHz at 16.5 V")
    print(f"slew: {2 * math.pi * 40e3 * 16.5 / 1e6:.2f} V/us at 40 kHz and 16.5 V; 8 V/us are {8e6 / 2 / math.pi / 16.5 / 1e3:.0f} kHz at 16.5 V")


def details():
    heading("details")
    tau = R["R114"] * 300e-9
    print(f"bleeder: 300 nF at 16.5 V hold {0.5e6 * 300e-9 * 16.5**2:.0f} uJ; {1e3 * tau:.1f} ms, below 1 V after {1e3 * tau * math.log(16.5):.1f} ms; {1e3 * 16.5**2 / 2 / R['R114']:.0f} mW at full drive")
    f0 = 1 / (2 * math.pi * R["R102"] * math.sqrt(R["C101"] * R["C102"]))
    print(f"filter of the DAC: {f0 / 1e3:.1f} kHz, Q {math.sqrt(R['C101'] / R['C102']) / 2:.3f}; low-pass of the channels: {1 / (2e3 * math.pi * R['R211'] * R['C201']):.1f} kHz")
    print(f"ADC: {R['R212']:.0f} ohm, {1 / (2e3 * math.pi * R['R212'] * R['C202']):.0f} kHz")
    require(R["R212"] < 240, "the source of the ADC")
    print(f"mute: {1e3 * (RAIL - 2.6 - 0.1) / R['R108']:.2f} mA at 24 V, {1e3 * (18 - 2.6 - 0.1) / R['R108']:.2f} mA at 18 V, of 0.5 mA; base of Q2 {1e6 * ((3.0 - 0.65) / R['R110'] - 0.65 / R['R111']):.0f} uA")
    plus = VMID * (R["R301"] + R["R302"]) / R["R302"]
    minus = VMID - (3.3 - VMID) * R["R303"] / R["R304"]
    print(f"fault: supplies below {plus:.1f} V and above {minus:.1f} V")
    print(f"a sense input at 25 V with the Nucleo off: {25e3 / R['R202']:.2f} mA at most; a short of the stack to 24 V through an open shunt, 1 V at D103: {1e3 / R['R207']:.1f} mA")
    print(f"emergency stop: {3.3 * R['R308'] / (R['R307'] + R['R308']):.2f} V, {1e6 * R['R309'] * R['C301']:.0f} us; heat sink: thermistor at 25 °C {1e3 * 1.65**2 / 1e4:.2f} mW")


if __name__ == "__main__":
    netlists = Netlist("sense.cir"), Netlist("drive.cir")
    scales()
    rest()
    noise()
    sense(netlists[0])
    drive(netlists[1])
    loads()
    details()
