// The page in a headless Chromium. `sim-host/web/check` packs it and runs this.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFile, mkdir } from "node:fs/promises";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";

import { Browser } from "./browser.mjs";

const folder = resolve(process.env.SONOGLIDE_PAGE ?? "target/web");
const file = join(folder, "sonoglide.html");
const address = pathToFileURL(file).href;
const done = "document.body.dataset.state === 'done'";
const state = (name) => `document.body.dataset.${name}`;

let browser;
before(async () => {
  await mkdir(join(folder, "pictures"), { recursive: true });
  browser = await Browser.start(process.env.CHROMIUM ?? "chromium");
});
after(() => browser.stop());

/** Opens a page; afterwards there must be no errors and no network requests. */
async function opened(options, look, fragment = "") {
  const page = await browser.page(address + fragment, options);
  try {
    await look(page);
    assert.deepEqual(page.complaints, []);
    assert.deepEqual(page.requests, []);
  } finally {
    await page.close();
  }
}

const choose = (page, scene) => page.value(`(() => { document.body.dataset.state = ''; const s = document.getElementById('scene'); s.value = '${scene}'; s.dispatchEvent(new Event('change')); })()`);
const press = (page, id) => page.value(`(() => { document.body.dataset.state = ''; document.getElementById('${id}').click(); })()`);
const text = (page, id) => page.value(`document.getElementById('${id}').textContent`);

/** Opens the curve of a slider, and waits for its points. */
const curveOf = (key, rest = "") => `document.getElementById('curve-${key}${rest}')`;
const waitForCurve = (page, key, name = "done") => page.until(`${curveOf(key)}.dataset.state === '${name}'`);
async function openCurve(page, key) {
  await page.until(done);
  await page.value(`${curveOf(key, "-open")}.click()`);
  await waitForCurve(page, key);
}
/** Opens the curve of Coulomb friction, whose ratio is 2/pi asin(key) up to 1. */
async function openKinematic(page) {
  await page.until(done);
  await page.value("document.getElementById('toml').value = 'base = \"contact-kinematic\"\\n[contact.dahl]\\nstiffness_n_per_m = 1e12'");
  await press(page, "apply");
  await openCurve(page, "excitation.velocity_ratio");
  return "excitation.velocity_ratio";
}
/** Enters a value into a field of a curve. */
async function enter(page, key, field, value) {
  await page.value(`(() => { const box = ${curveOf(key, field)}; box.value = '${value}'; box.dispatchEvent(new Event('change')); })()`);
  await waitForCurve(page, key);
}
/** Moves a slider to one of its 400 steps. */
const slide = (page, key, step) => page.value(`(() => { document.body.dataset.state = ''; const s = document.getElementById('slider-${key}'); s.value = ${step}; s.dispatchEvent(new Event('input')); })()`);

test("the page is at most 1.66 MB gzipped", async () => {
  const packed = gzipSync(await readFile(file), { level: 9 }).length;
  console.log(`${packed} bytes gzipped`);
  assert.ok(packed <= 1.66e6, `${packed} bytes`);
});

test("the first result is shown within two seconds, and friction falls", () => opened({}, async (page) => {
  await page.until(done);
  const wall = Number(await page.value(state("wall")));
  const since = await page.value("performance.now()");
  console.log(`first run ${wall.toFixed(2)} s, shown ${(since / 1e3).toFixed(2)} s after the page was requested`);
  assert.ok(wall < 2, `${wall} s`);
  assert.match(await text(page, "headline"), /friction reduction6\d\.\d+ %/);
  assert.equal(await text(page, "hash-verdict"), "Equal to the host's, bit for bit.");
}));

test("every scene with a controller plays the host's codes, bit for bit", { timeout: 900000 }, () => opened({}, async (page) => {
  await page.until(done);
  const hosts = JSON.parse(await text(page, "hosts"));
  const names = Object.keys(hosts);
  assert.ok(names.length >= 30, names.join());
  const different = [];
  let total = 0;
  for (const name of names) {
    await choose(page, name);
    await page.until(`${done} || ${state("state")} === 'error'`, 300000);
    const hash = await page.value(state("hash"));
    if (hash !== hosts[name].opened) different.push(`${name}: ${hash} and ${hosts[name].opened}`);
    total += Number(await page.value(state("wall")));
  }
  assert.deepEqual(different, []);
  console.log(`${names.length} scenes equal, ${total.toFixed(1)} s of runs`);
}));

test("contact scenes are solved", () => opened({}, async (page) => {
  await page.until(done);
  for (const name of ["contact", "contact-kinematic", "contact-normal"]) {
    await choose(page, name);
    await page.until(done);
    assert.equal(await page.value("document.getElementById('same').hidden"), true);
    assert.ok(await page.value("document.querySelectorAll('#figures figure').length") > 0);
  }
}));

test("the switch and a fault change only the part after the chosen time", () => opened({}, async (page) => {
  await page.until(done);
  const at = (part) => page.value(`(() => { const t = document.getElementById('time'); t.value = ${part * 1000}; t.dispatchEvent(new Event('input')); })()`);
  // A result rests in its ON window, where a fault has an effect at the first click.
  assert.equal(await text(page, "switch"), "Switch OFF here");
  const friction = () => page.value("[...document.querySelectorAll('#now tbody tr')].find((row) => row.cells[0].textContent === 'friction').cells[3].textContent");
  await at(0.3);
  const before = await friction();
  await at(0.7);
  assert.equal(await text(page, "switch"), "Switch OFF here");
  await press(page, "switch");
  await page.until(done);
  assert.match(await text(page, "changes"), /ON at 0\.4 s, OFF at 0\.49 s/);
  await at(0.95);
  assert.equal(await text(page, "switch"), "Switch ON here");
  await at(0.3);
  assert.equal(await friction(), before);
  await at(0.65);
  await page.value("document.getElementById('fault').value = [...document.getElementById('fault').options].find((option) => option.text === 'short').value");
  await press(page, "break");
  await page.until(done);
  assert.match(await text(page, "event-list"), /fault \d+:/);
  assert.match(await page.value("document.getElementById('command').value"), /--set 'fault\.0=\{at_s=0\.455, kind="short"\}'/);
}));

test("a slider changes its key, and undoing it restores the first result", () => opened({}, async (page) => {
  await page.until(done);
  const first = await page.value(state("hash"));
  await page.value("(() => { document.body.dataset.state = ''; const s = document.getElementById('slider-rig.slider.load_n'); s.value = 200; s.dispatchEvent(new Event('input')); })()");
  await page.until(done);
  assert.notEqual(await page.value(state("hash")), first);
  assert.match(await page.value("document.getElementById('command').value"), /--set rig\.slider\.load_n=10/);
  await page.value("(() => { document.body.dataset.state = ''; const s = document.getElementById('slider-controller.burst.off_s'); s.value = 150; s.dispatchEvent(new Event('input')); })()");
  await page.until(done);
  assert.match(await page.value("document.getElementById('command').value"), /--set 'controller\.burst\.off_s=\[\d+\.\d+\]'/);
  await press(page, "reset");
  await page.until(done);
  assert.equal(await page.value(state("hash")), first);
}));

test("a curve shows the main metric over a slider, and follows other values", () => opened({}, async (page) => {
  const key = "rig.slider.speed_m_per_s", words = () => page.value(`${curveOf(key)}.innerText`);
  await page.until(done);
  assert.equal(await page.value("document.querySelectorAll('.curve svg').length"), 0, "nothing is computed before a curve is opened");
  await openCurve(page, key);
  const [, headline] = /friction reduction([\d.]+) %/.exec(await text(page, "headline"));
  assert.ok((await words()).includes(`You are here: 38 mm/s, friction reduction ${headline} %.`), await words());
  const circles = () => page.value(`JSON.stringify([...${curveOf(key)}.querySelectorAll('circle.dot')].map((dot) => Number(dot.getAttribute('cy')).toFixed(1)))`);
  const first = await circles();
  const svg = (selector, attribute) => page.value(`${curveOf(key)}.querySelector('${selector}')${attribute}`);
  assert.match(await svg("svg", ".getAttribute('aria-label')"), /^friction reduction over Speed of the slider from [\d.]+ % at [\d.]+ mm\/s to [\d.]+ % at 200 mm\/s\. You are here: /);
  assert.match(await svg("svg", ".textContent"), /friction reduction, %.*Speed of the slider, mm\/s/);
  // Its own slider moves the marker; another one makes all points outdated, and they are computed again.
  const before = await svg("line.here", ".getAttribute('x1')");
  await slide(page, key, 300);
  assert.notEqual(await svg("line.here", ".getAttribute('x1')"), before);
  await waitForCurve(page, key);
  await slide(page, "rig.slider.load_n", 200);
  await waitForCurve(page, key, "busy");
  await waitForCurve(page, key);
  assert.notEqual(await circles(), first);
  // A stopped curve is computed again only by its button.
  await slide(page, "rig.slider.load_n", 300);
  await waitForCurve(page, key, "busy");
  await page.value(`${curveOf(key, "-act")}.click()`);
  assert.equal(await svg("svg", ".closest('.curve').dataset.state"), "stopped");
  await slide(page, "rig.slider.load_n", 100);
  await waitForCurve(page, key, "outdated");
  await page.value(`${curveOf(key, "-act")}.click()`);
  await waitForCurve(page, key);
}));

test("a target has all values of the key in the range, and sets one of them", () => opened({}, async (page) => {
  const key = await openKinematic(page), list = () => page.value(`[...${curveOf(key)}.querySelectorAll('.roots li')].map((one) => one.innerText)`);
  await enter(page, key, "-target", 0.5);
  const [root, ...others] = await list();
  assert.ok(others.length === 0 && Math.abs(parseFloat(root) - Math.SQRT1_2) < 0.001, root);
  await page.value(`document.body.dataset.state = ''; ${curveOf(key, "-root-0")}.focus(); ${curveOf(key, "-root-0")}.click()`);
  await page.until(done);
  assert.match(await page.value(`${curveOf(key)}.innerText`), /You are here: 0\.70\d*, friction ratio 0\.5\./);
  assert.equal(await page.value("document.activeElement.id"), `curve-${key}-root-0`);
  await enter(page, key, "-target", 2);
  assert.deepEqual(await list(), ["Not reached in this range."]);
}));

test("an uncertain key has an interval of the metric, as text and as a band", () => opened({}, async (page) => {
  const key = await openKinematic(page), words = () => page.value(`${curveOf(key)}.innerText`);
  await enter(page, key, "-band", 0.1);
  const [, low, high] = /friction ratio from ([\d.]+) to ([\d.]+) \(95 %\)/.exec(await words());
  assert.ok(Math.abs(low - 0.262) < 0.003 && Math.abs(high - 0.4097) < 0.003, await words());
  assert.equal(await page.value(`${curveOf(key)}.querySelectorAll('rect.band').length`), 2);
  await enter(page, key, "-band-unit", "%");
  assert.match(await words(), /within ± 0\.0005\./);
  await enter(page, key, "-band", 300);
  assert.match(await words(), /\d % of it are left out/);
}));

/** Drops a file with this text or these bytes on the page. */
const dropped = (page, name, content) => page.value(`(() => {
  document.body.dataset.state = '';
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([Uint8Array.from(${JSON.stringify([...Buffer.from(content)])})], '${name}'));
  document.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
})()`);

test("a dropped impedance becomes a scene with its fitted circuit; other files name their command", () => opened({}, async (page) => {
  await page.until(done);
  const drop = (...file) => dropped(page, ...file);
  // A motional branch of 40 kHz, Q = 400 and 50 ohm, next to 4 nF.
  const rows = Array.from({ length: 401 }, (_, place) => {
    const hz = 39000 + 5 * place, reactance = 50 * 400 * (hz / 40000 - 40000 / hz), size = 2500 + reactance ** 2;
    const [real, imaginary] = [50 / size, -reactance / size + 2 * Math.PI * hz * 4e-9];
    return [hz, (1 + 1e-4 * Math.sin(hz ** 2)) / Math.hypot(real, imaginary), (-180 / Math.PI) * Math.atan2(imaginary, real)].join();
  });
  await drop("horn.csv", ["frequency_hz,|Z| [ohm],theta [deg]", ...rows].join("\n"));
  await page.until(done);
  assert.match(await text(page, "fit"), /Circuit fitted to horn\.csv.*series resonance \[Hz\](40000|39999\.9)/s);
  assert.match(await page.value("document.getElementById('toml').value"), /q = (400|399)\./);
  for (const [name, content, words] of [
    ["signal.csv", "time [s],T [degC]\n0,1\n0.1,2\n", /a curve of this run over time, or its unit alone: .*frequency_command_hz.*`sim-host spectrum signal\.csv`/s],
    ["scene.toml", Buffer.from("\ufeffbase = 'lock'", "utf16le"), /^error: cannot read the scene `scene\.toml`: encoded as UTF-16; save it as UTF-8$/],
    ["log.csv", "t [s],F [N],v [m/s]\n0,1,0.1\n1,1,0.1\n", /^error: log\.csv: unit missing: the normal force has no unit; give it with `--normal-n`, or/],
  ]) {
    await drop(name, content);
    await page.until(`${state("state")} === 'error'`);
    assert.match(await text(page, "error"), words);
  }
}));

test("a dropped time series is compared with the result, and the changes remain", () => opened({}, async (page) => {
  await page.until(done);
  const rows = Array.from({ length: 300 }, (_, n) => `${2 * n};${n < 200 ? 40 : 150}`);
  await dropped(page, "cell.csv", ["t [ms];F [mN]", ...rows].join("\n"));
  await page.until(done);
  assert.match(await text(page, "fit"), /cell\.csv and the scene experiment-1.*note: `F \[mN\]` is compared with `friction_true_n`/s);
  assert.match(await page.value("document.getElementById('toml').value"), /^base = "experiment-1"\n\n\[\[overlay\]\]\nname = "cell\.csv: F \[mN\]"/);
  assert.match(await page.value("document.getElementById('shown').textContent"), /cell\.csv: F \[mN\]/);
  await page.picture(join(folder, "pictures", "time-series.png"));
}));

test("dropped friction becomes a scene of its fit, after a question for missing values", () => opened({}, async (page) => {
  await page.until(done);
  const means = [20, 50, 80, 120].flatMap((v) => [0, 1, 2, 3, 4, 5].map((n) => {
    const mu = 0.3 * (1 + 0.01 * Math.sin(7 * v + n)), ratio = n % 2 ? (2 / Math.PI) * Math.asin(v / 200) : 1;
    return `${v};${n % 2 ? "ON;0,2" : "OFF;0"};${String(5 * mu * ratio).replace(".", ",")};5;40`;
  }));
  const table = ["v [mm/s];state;tip [m/s];F [N];N [N];frequency [kHz]", ...means].join("\n");
  await dropped(page, "means.csv", Buffer.from(`\ufeff${table}`, "utf16le"));
  await page.until(done);
  assert.match(await text(page, "fit"), /Friction fitted to means\.csv.*mu0\.(299|300).*assumed: the vibration is a sine/s);
  assert.match(await text(page, "title"), /^Measured contact at /);
  // Dahl friction of 1.5 N and 0.2 N/µm along a sine, with a heading in Latin-1.
  let force = 0, before = 0;
  const log = Array.from({ length: 401 }, (_, n) => {
    const x = 50 * Math.sin(Math.PI * n / 100), step = (x - before) / 50;
    for (let part = 0; part < 50; part += 1) force += 0.2 * step * (1 - (force / 1.5) * Math.sign(step));
    before = x;
    return [n / 400, x, force + 0.01 * Math.sin(n * n), 5].join();
  });
  await dropped(page, "slide.csv", Buffer.from(["t [s],x [\xb5m],F [N],N [N]", ...log].join("\n"), "latin1"));
  await page.until(`${state("state")} === 'error'`);
  assert.equal(await text(page, "error"), "note: no scene is written: it needs `--frequency-hz` and `--tip-m-per-s`");
  assert.match(await text(page, "fit"), /Friction fitted to slide\.csv.*mu0\.300/s);
  await page.picture(join(folder, "pictures", "friction.png"));
  await page.value("document.getElementById('fit-frequency_hz').value = 4e4; document.getElementById('fit-tip_m_per_s').value = 0.2");
  await press(page, "fit-again");
  await page.until(done);
  assert.match(await text(page, "title"), /^Measured contact slide: friction under a 40 kHz vibration/);
}));

test("a curve that is opened before the first result begins with it", () => opened({}, async (page) => {
  const key = "rig.slider.speed_m_per_s";
  await page.until(`${curveOf(key, "-open")} !== null`);
  await page.value(`${curveOf(key, "-open")}.click()`);
  assert.match(await page.value(`${curveOf(key)}.innerText`), /no result to draw yet/);
  await waitForCurve(page, key);
}));

test("a link contains the scene and its changes", () => opened({}, async (page) => {
  await page.until(done);
  await page.value("(() => { document.body.dataset.state = ''; const s = document.getElementById('slider-contact.dahl.mu'); s.value = 150; s.dispatchEvent(new Event('input')); })()");
  await page.until(done);
  const hash = await page.value(state("hash")), fragment = await page.value("location.hash");
  assert.match(fragment, /^#z=/);
  await opened({}, async (other) => {
    await other.until(done);
    assert.equal(await other.value(state("hash")), hash);
  }, fragment);
  await opened({}, async (other) => {
    await other.until(done);
    assert.equal(await text(other, "hash-verdict"), "Equal to the host's, bit for bit.");
    assert.equal(await other.value("document.getElementById('scene').value"), "burst");
  }, "#scene=burst");
}));

test("errors in a scene have the message and the caret of the command line", () => opened({}, async (page) => {
  await page.until(done);
  const mistaken = (scene) => page.value(`(() => { document.body.dataset.state = ''; document.getElementById('toml').value = ${JSON.stringify(scene)}; document.getElementById('apply').click(); })()`);
  await mistaken('base = "lock"\n\n[controller.drive]\namplitud_v = 3\n');
  await page.until(`${state("state")} === 'error'`);
  const said = await text(page, "toml-error");
  assert.equal(await page.value("(() => { const t = document.getElementById('toml'); return t.value.slice(t.selectionStart, t.selectionEnd); })()"), "amplitud_v = 3");
  assert.match(said, /--> my-scene\.toml:4:1/);
  assert.match(said, /\^{5,}/);
  assert.match(said, /amplitude_v/);
  await mistaken('base = "lock"\ntitle = "mine"\nduration_s = 0.31\n');
  await page.until(done);
  assert.equal(await page.value("document.getElementById('toml-error').hidden"), true);
  assert.match(await text(page, "title"), /^mine/);
}));

test("a motor and a crash have their views, and files can be saved", () => opened({}, async (page) => {
  await page.until(done);
  await choose(page, "usm");
  await page.until(done);
  assert.match(await text(page, "motor-now"), /turned by [\d.]+°/);
  await page.picture(join(folder, "pictures", "usm.png"));
  await choose(page, "dring-crash");
  await page.until(done);
  assert.match(await page.value("document.querySelector('.crash-story').textContent"), /ms: /);
  await page.picture(join(folder, "pictures", "crash.png"));
  const files = await page.value("[...document.querySelectorAll('[data-file]')].map((button) => button.dataset.file)");
  assert.deepEqual(files, ["summary.json", "trace.csv", "scene.toml"]);
  const saved = await page.value(`new Promise((resolve) => {
    const address = URL.createObjectURL;
    URL.createObjectURL = (blob) => { URL.createObjectURL = address; blob.text().then(resolve); return address.call(URL, blob); };
    document.querySelector('[data-file="summary.json"]').click();
  })`);
  assert.equal(JSON.parse(saved).drive_hash, await page.value(state("hash")));
}));

test("everything can be reached by keyboard, and the focus is visible", () => opened({}, async (page) => {
  await page.until(done);
  await page.value("document.body.focus()");
  const reached = [];
  const focus = `(() => { const e = document.activeElement; const s = getComputedStyle(e); return { id: e.id || e.dataset.file || e.className || e.tagName, name: e.ariaLabel || e.labels?.[0]?.textContent || e.textContent || '', seen: e.closest('label.file') !== null || parseFloat(s.outlineWidth) >= 2 }; })()`;
  for (let n = 0; n < 250; n += 1) {
    await page.key("Tab");
    const now = await page.value(focus);
    if (now.id === "BODY" && reached.length) break;
    reached.push(now);
  }
  const ids = reached.map(({ id }) => id);
  for (const id of ["skip", "scene", "run", "slider-rig.slider.load_n", "slider-stack.bvd.q", "play", "time", "speed", "switch", "fault", "break", "copy", "link", "summary.json"]) assert.ok(ids.includes(id), `${id} is not reachable: ${ids.join(" ")}`);
  assert.deepEqual(reached.filter(({ seen, name }) => !seen || !name.trim()), []);
  // A slider is moved by its arrow keys, and the scene is run by its key.
  const first = await page.value(state("hash"));
  await page.value("document.body.dataset.state = ''; document.getElementById('slider-rig.slider.speed_m_per_s').focus()");
  await page.key("ArrowRight");
  await page.until(done);
  assert.notEqual(await page.value(state("hash")), first);
  await page.value("document.body.dataset.state = ''; document.getElementById('run').focus()");
  await page.key(" ");
  await page.until(done);
  assert.match(await text(page, "status"), /^Done in/);
}));

test("axe finds nothing, light and dark, wide and narrow", async (context) => {
  const source = await readFile(process.env.AXE ?? "", "utf8").catch(() => null);
  if (source === null) return context.skip("axe-core could not be installed");
  for (const options of [{}, { dark: true }, { width: 360, height: 740 }]) {
    await opened(options, async (page) => {
      for (const scene of ["experiment-1", "dring-crash", "usm"]) {
        await page.until(done);
        await choose(page, scene);
        await page.until(done);
        await page.value("document.querySelectorAll('details').forEach((one) => { one.open = true; })");
        await page.value("document.querySelector('.control > .text').click()");
        await page.until("document.querySelector('.curve').dataset.state === 'done'");
        await page.value(source);
        const found = await page.value("axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] }).then(({ violations }) => violations.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 4).map((node) => node.target + ' ' + (node.any[0]?.message ?? '')).join(', ')}`))");
        assert.deepEqual(found, [], `${scene} ${JSON.stringify(options)}`);
      }
    });
  }
});

test("a phone shows it without horizontal scrolling", () => opened({ width: 360, height: 740 }, async (page) => {
  await page.until(done);
  for (const scene of ["experiment-1", "usm", "dring-crash", "contact"]) {
    await choose(page, scene);
    await page.until(done);
    assert.equal(await page.value("document.documentElement.scrollWidth"), 360, scene);
  }
  await choose(page, "experiment-1");
  await page.until(done);
  await page.picture(join(folder, "pictures", "phone.png"));
}));

test("pictures are taken", async () => {
  for (const [name, options] of [["light", {}], ["dark", { dark: true }], ["tablet", { width: 800 }]]) {
    await opened(options, async (page) => {
      await page.until(done);
      await page.picture(join(folder, "pictures", `${name}.png`));
    });
  }
});

test("a zoomed map of a report has ticks for its cells, and a double-click restores it", async () => {
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
  await page.picture(join(folder, "pictures", "map.png"));
  for (const type of ["mousePressed", "mouseReleased"]) await mouse(type, 0.5, 0.5, 2);
  assert.deepEqual([await labels(), page.complaints], [whole, []]);
  await page.close();
});
