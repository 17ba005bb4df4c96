#!/usr/bin/env python3
"""Writes the drawings of the documentation as SVG, readable in light and dark mode and at phone width.

    python3 docs/pictures.py            # writes them next to this file
    python3 docs/pictures.py --check    # fails if a file differs, and names it
"""

import pathlib
import sys
from xml.sax.saxutils import escape

# Colours of a class: attribute, light, dark.
COLOURS = {
    "page": ("fill", "#ffffff", "#14181d"),
    "firmware": ("fill", "#dcebf8", "#173a57"),
    "electronics": ("fill", "#fdebd0", "#4d3511"),
    "machine": ("fill", "#e6e8ea", "#343b43"),
    "fault": ("fill", "#f9dcd9", "#562520"),
    "layer": ("fill", "#b9a6d3", "#6f5a92"),
    "metal": ("fill", "#aab2ba", "#737d87"),
    "ink": ("fill", "#15191e", "#eef1f4"),
    "soft": ("fill", "#454d55", "#c2c9d0"),
    "line": ("stroke", "#3a424a", "#c2c9d0"),
    "faint": ("stroke", "#9aa3ab", "#6a737c"),
}
STYLE = """text { font-family: Verdana, "DejaVu Sans", sans-serif; font-size: 17px }
.title { font-size: 20px; font-weight: bold }
.line, .faint { fill: none; stroke-width: 2 }
.dashed { stroke-dasharray: 6 5 }
.middle { text-anchor: middle }
.end { text-anchor: end }
"""


def rules(dark):
    """Returns the colours of all classes, one rule a line."""
    boxes = ".firmware, .electronics, .machine, .fault, .layer, .metal { stroke: %s; stroke-width: 1.5 }\n"
    lines = "".join(f".{name} {{ {key}: {(light, night)[dark]} }}\n" for name, (key, light, night) in COLOURS.items())
    return lines + boxes % COLOURS["line"][1 + dark]


class Picture:
    """One drawing: a title that screen readers read, its size, and its elements."""

    def __init__(self, title, width, height):
        self.title, self.width, self.height = title, width, height
        self.elements = []

    def add(self, element):
        self.elements.append(element)

    def text(self, x, y, text, classes="ink"):
        self.add(f'<text x="{x}" y="{y}" class="{classes}">{escape(text)}</text>')

    def rect(self, x, y, width, height, classes, radius=0):
        self.add(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{radius}" class="{classes}"/>')

    def box(self, x, y, width, height, classes, title, *lines):
        """Draws a rounded box with a title and lines of text, centred."""
        self.rect(x, y, width, height, classes, 8)
        middle = x + width / 2
        top = y + height / 2 - 12 * len(lines) + 7
        self.text(middle, top, title, "title ink middle")
        for number, line in enumerate(lines, 1):
            self.text(middle, top + 24 * number, line, "ink middle")

    def path(self, points, classes="line"):
        self.add(f'<path d="M{" L".join(f"{x} {y}" for x, y in points)}" class="{classes}"/>')

    def arrow(self, *points, classes="line", both=False):
        """Draws a line with a head at its last point, or at both ends."""
        self.path(points, classes)
        self.head(points[-2], points[-1])
        if both:
            self.head(points[1], points[0])

    def head(self, before, tip):
        (x0, y0), (x, y) = before, tip
        length = ((x - x0) ** 2 + (y - y0) ** 2) ** 0.5
        dx, dy = (x - x0) / length, (y - y0) / length
        corners = [(x, y), (x - 12 * dx - 6 * dy, y - 12 * dy + 6 * dx), (x - 12 * dx + 6 * dy, y - 12 * dy - 6 * dx)]
        self.add(f'<path d="M{" L".join(f"{a:g} {b:g}" for a, b in corners)} Z" class="soft"/>')

    def svg(self):
        size = f'viewBox="0 0 {self.width} {self.height}" width="{self.width}" height="{self.height}"'
        style = f"{STYLE}{rules(False)}@media (prefers-color-scheme: dark) {{\n{rules(True)}}}\n"
        page = f'<rect width="{self.width}" height="{self.height}" rx="12" class="page"/>'
        head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">\n<title>{escape(self.title)}</title>'
        return "\n".join([head, f"<style>\n{style}</style>", page, *self.elements, "</svg>\n"])


def signal_chain():
    """Draws the loop of controller, amplifier, stack and sense, and the contact."""
    p = Picture("Signal chain: controller, amplifier, stack with contact, sense, and back to the controller", 560, 468)
    p.box(16, 20, 236, 120, "firmware", "Controller", "finds the resonance,", "tracks it, switches", "bursts, stops on faults")
    p.box(328, 20, 216, 120, "electronics", "Amplifier", "DAC and power stage")
    p.box(16, 204, 236, 84, "electronics", "Sense", "voltage and current")
    p.rect(328, 204, 216, 246, "machine", 8)
    p.text(342, 234, "Stack", "title ink")
    # The stack lies on its side: its tip vibrates along the sliding, and its foot presses on the slider.
    for layer in range(8):
        p.rect(342 + 14 * layer, 250, 14, 50, "layer")
    p.rect(454, 250, 44, 50, "metal")
    p.rect(464, 300, 24, 24, "metal")
    p.arrow((440, 236), (512, 236), both=True)
    p.rect(342, 324, 188, 26, "metal")
    p.arrow((358, 337), (440, 337))
    p.text(342, 381, "Contact", "title ink")
    p.text(342, 407, "friction falls while")
    p.text(342, 431, "the tip vibrates")
    p.arrow((252, 80), (328, 80))
    p.text(290, 70, "drive", "soft middle")
    p.arrow((400, 140), (400, 204))
    p.text(412, 178, "20 to 40 kHz", "soft")
    p.arrow((328, 246), (252, 246))
    p.text(290, 236, "U, I", "soft middle")
    p.arrow((134, 204), (134, 140))
    legend = [("firmware", "firmware (same in simulator)"), ("electronics", "board"), ("machine", "your machine")]
    for row, (kind, line) in enumerate(legend):
        p.rect(16, 334 + 36 * row, 24, 24, kind, 4)
        p.text(50, 352 + 36 * row, line)
    return p


def wiring():
    """Draws the pins of the Nucleo and the parts at their other ends."""
    p = Picture("Wiring of the Nucleo-G474RE: pins, amplifier, stack, sense, emergency stop, computer", 584, 652)
    p.rect(16, 20, 194, 616, "firmware", 8)
    p.text(113, 52, "Nucleo-G474RE", "title ink middle")
    p.rect(316, 20, 252, 148, "electronics", 8)
    p.text(442, 52, "Amplifier, ±24 V", "title ink middle")
    p.rect(316, 284, 252, 118, "electronics", 8)
    p.text(442, 314, "Sense", "title ink middle")
    pins = [
        (80, "PA4 (A2)", "drive", "out", "input"),
        (114, "PA10 (D2)", "enable", "out", "enable, 10 kΩ to 0 V"),
        (148, "PA6 (D12)", "fault", "in", "fault output, low"),
        (346, "PA0 (A0)", "voltage", "in", "divider 1/12.5"),
        (380, "PA1 (A1), PA7 (D11)", "current", "in", "shunt 0.1 Ω, gain 4"),
        (464, "PC3 (CN7)", "3.3 V", "in", ""),
        (542, "PA9 (D8)", "", "out", ""),
        (606, "USB (ST-LINK)", "", "both", ""),
    ]
    for y, pin, signal, direction, part in pins:
        p.text(198, y + 6, pin, "ink end")
        ends = [(210, y), (316, y)]
        p.arrow(*(reversed(ends) if direction == "in" else ends), both=direction == "both")
        p.text(263, y - 6, signal, "soft middle")
        p.text(330, y + 6, part)
    p.box(316, 194, 252, 64, "machine", "Stack", "or dummy load")
    p.arrow((442, 168), (442, 194))
    p.arrow((442, 258), (442, 284))
    p.box(316, 418, 252, 92, "fault", "Emergency stop", "opens when pressed,", "2nd contact cuts ±24 V")
    p.box(316, 522, 252, 40, "machine", "Status LED to 0 V")
    p.box(316, 576, 252, 60, "machine", "Computer", "link, log, power")
    for row, line in enumerate(["1.65 V is zero at", "PA0, PA1, PA4, PA7"]):
        p.text(32, 264 + 24 * row, line, "soft")
    return p


def block_timing():
    """Draws which block is measured, computed and played at a time."""
    p = Picture("Timing of a block: measured in one block, computed in the next, played in the one after", 584, 424)
    left, width = 140, 106
    rows = [(64, "ADC", "measures", 0), (134, "Processor", "computes", 1), (204, "DAC", "plays", 2)]
    for column in range(5):
        x = left + width * column
        if column < 4:
            p.text(x + width / 2, 44, ["block k", "k + 1", "k + 2", "k + 3"][column], "title ink middle")
        p.path([(x, 56), (x, 264)], "faint dashed")
    for y, name, verb, first in rows:
        p.text(16, y + 32, name, "title ink")
        for column in range(max(0, first - 1), 4):
            x, number = left + width * column, column - first
            block = "k" if number == 0 else f"k + {number}" if number > 0 else "k − 1"
            shown = width if name != "Processor" else 92
            kind = ("firmware" if name == "Processor" else "electronics") if number == 0 else "machine"
            p.rect(x, y, shown, 52, kind, 4)
            p.text(x + shown / 2, y + 22, verb, "ink middle")
            p.text(x + shown / 2, y + 43, block, "ink middle")
    notes = [
        "At the end of block k an interrupt computes the answer.",
        "The answer plays in k + 2: a decision acts two blocks later.",
        "A fault does not wait: the block that plays is silenced.",
        "A block has 100 samples on the Nucleo and 32 in most",
        "scenes, at one sample per microsecond.",
    ]
    for row, line in enumerate(notes):
        p.text(16, 300 + 26 * row, line, "soft")
    return p


def modes():
    """Draws the state machine of the controller."""
    p = Picture("Modes of the controller: Idle, SelfTest, Clamped, Scan, Calibrate, Lock, Run, Fault", 584, 672)
    p.box(200, 20, 164, 48, "machine", "Idle")
    p.box(200, 128, 164, 72, "firmware", "SelfTest", "sensors, stack")
    p.box(16, 274, 164, 72, "firmware", "Clamped", "measures C0, Lm")
    p.box(200, 274, 164, 72, "firmware", "Scan", "finds resonances")
    p.box(384, 274, 164, 72, "firmware", "Calibrate", "trims the lanes")
    p.box(16, 420, 164, 72, "firmware", "Lock", "pulls in")
    p.box(200, 420, 164, 72, "firmware", "Run", "plays the bursts")
    p.box(384, 420, 164, 72, "fault", "Fault", "silent")
    p.arrow((282, 68), (282, 128))
    p.text(272, 104, "order", "soft end")
    p.arrow((200, 164), (98, 164), (98, 274))
    p.text(108, 236, "observer", "soft")
    p.arrow((282, 200), (282, 274))
    p.text(292, 232, "phase", "soft")
    p.text(292, 256, "loop", "soft")
    p.arrow((364, 164), (440, 164), (440, 274))
    p.text(430, 236, "order", "soft end")
    p.arrow((500, 274), (500, 52), (364, 52))
    p.text(490, 128, "done", "soft end")
    p.arrow((180, 310), (200, 310))
    p.arrow((98, 346), (98, 420))
    p.arrow((240, 346), (240, 384), (140, 384), (140, 420))
    p.arrow((180, 456), (200, 456))
    p.arrow((282, 492), (282, 520), (60, 520), (60, 492))
    p.text(171, 514, "lock lost", "soft middle")
    p.arrow((548, 456), (566, 456), (566, 34), (364, 34))
    p.text(556, 26, "fault cleared", "soft end")
    notes = [
        "An order to scan or to calibrate ends in Idle.",
        "With tracking off, SelfTest leads to Run.",
        "A lost lock tries Lock, SelfTest and Scan again.",
        "The order to stop leads to Idle, except from Fault.",
        "Faults, emergency stop and a lost host lead to Fault.",
    ]
    for row, line in enumerate(notes):
        p.text(16, 554 + 25 * row, line, "soft")
    return p


PICTURES = {"signal-chain": signal_chain, "wiring": wiring, "block-timing": block_timing, "modes": modes}


def main(arguments):
    if arguments not in ([], ["--check"]):
        sys.exit(__doc__)
    folder = pathlib.Path(__file__).resolve().parent
    differs = []
    for name, draw in PICTURES.items():
        path, svg = folder / f"{name}.svg", draw().svg()
        if not arguments:
            path.write_text(svg, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != svg:
            differs.append(path.name)
    if differs:
        sys.exit(f"docs/pictures.py writes another {', '.join(differs)}; run it without --check")


if __name__ == "__main__":
    main(sys.argv[1:])
