// A heat map of a report in a headless Chromium: its axes when it is zoomed.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

import { Browser } from "./browser.mjs";

test("a zoomed map has ticks for its cells, and a double-click restores it", async () => {
  const folder = mkdtempSync(join(tmpdir(), "sonoglide-map-")), browser = await Browser.start(process.env.CHROMIUM ?? "chromium");
  try {
    const over = ["--over", "excitation.velocity_ratio=0.01:1:20:log", "--over", "contact.dahl.mu=0.1:0.8:15", "--contour", "0.06"];
    execFileSync(process.env.SIM_HOST ?? "target/release/sim-host", ["sweep", "contact-kinematic", ...over, "--metric", "friction_on_n", "-o", join(folder, "map")]);
    const page = await browser.page(pathToFileURL(join(folder, "map", "report.html")).href);
    await page.until("document.readyState === 'complete'");
    const labels = () => page.value("[...document.querySelectorAll('.map svg > text, .map g text')].filter((one) => one.getAttribute('visibility') !== 'hidden').map((one) => one.textContent.trim())");
    const whole = await labels(), [x, y, width, height] = await page.value("(({ x, y, width, height }) => [x, y, width, height])(document.querySelector('.map image').getBoundingClientRect())");
    const mouse = (type, across, up, clickCount = 1) => page.send("Input.dispatchMouseEvent", { type, x: x + across * width, y: y + (1 - up) * height, button: "left", buttons: 1, clickCount });
    // The cells of 0.3 to 0.5 and of the uppermost decade.
    for (const [type, ...at] of [["mousePressed", 0.31, 0.51], ["mouseMoved", 0.59, 0.98], ["mouseReleased", 0.59, 0.98]]) await mouse(type, ...at);
    const zoomed = await labels();
    for (const label of ["0.30", "0.40", "0.50", "0.1", "0.2", "0.5"]) assert.ok(zoomed.includes(label), `${label}: ${zoomed}`);
    assert.ok(!zoomed.includes("0.7"), zoomed.join());
    await page.picture(join(resolve(process.env.SONOGLIDE_PAGE ?? "target/web"), "pictures", "map.png"));
    for (const type of ["mousePressed", "mouseReleased"]) await mouse(type, 0.5, 0.5, 2);
    assert.deepEqual([await labels(), page.complaints], [whole, []]);
    await page.close();
  } finally {
    await browser.stop();
    rmSync(folder, { recursive: true });
  }
});
