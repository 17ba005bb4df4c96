// The board's view of the page in a headless Chromium: with the simulated board in the page, and over
// a stand-in for a serial port with a board that `sim-host link ... serve` simulates.
import assert from "node:assert/strict";
import { once } from "node:events";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { pathToFileURL } from "node:url";

import { Browser } from "./browser.mjs";
import { Cable, ModelledBoard, ServedBoard } from "./cable.mjs";

const folder = resolve(process.env.SONOGLIDE_PAGE ?? "target/web");
const address = `${pathToFileURL(join(folder, "sonoglide.html")).href}#board`;
const state = (name) => `document.body.dataset.board === '${name}'`;
/** Host timeout of the served board, and time for the commands of a test, ms. */
const HOST_TIMEOUT_MS = 1000, MARGIN_MS = 400;
/** Numbers of cables that are pulled and tabs that are closed. */
const PULLS = Number(process.env.PULLS ?? 6);

let browser;
before(async () => {
  await mkdir(join(folder, "pictures"), { recursive: true });
  browser = await Browser.start(process.env.CHROMIUM ?? "chromium");
});
after(() => browser.stop());

/** Opens the view of a board; afterwards there must be no errors and no network requests. */
async function opened(options, look) {
  const page = await browser.page(address, options);
  try {
    await page.until("document.body.dataset.state === 'done'");
    await look(page);
    assert.deepEqual(page.complaints, []);
    assert.deepEqual(page.requests, []);
  } finally {
    await page.close();
  }
}

const click = (page, id) => page.value(`(() => { const e = document.getElementById('${id}'); if (e.disabled || e.closest('[disabled]')) throw new Error('${id} is disabled'); globalThis.clicks = (globalThis.clicks ?? 0) + 1; e.click(); })()`);
const text = (page, id) => page.value(`document.getElementById('${id}').textContent`);
const type = (page, id, value) => page.value(`document.getElementById('${id}').value = '${value}'`);
const submit = (page, id) => page.value(`(globalThis.clicks = (globalThis.clicks ?? 0) + 1, document.getElementById('${id}').requestSubmit())`);
const send = async (page, line) => { await type(page, "b-command", line); await submit(page, "b-command-form"); };
const logged = (page, words, limit) => page.until(`document.getElementById('b-log').textContent.includes(${JSON.stringify(words)})`, limit);

async function armed(page) {
  await page.until(`${state("connected")} && document.getElementById('b-log').textContent.includes('> update')`);
  await click(page, "b-arm");
  await page.until(state("armed"));
}

/** Opens a page with a cable to a served board. */
async function wired(scene, look, options = {}) {
  const board = await ServedBoard.start(scene);
  let cable;
  try {
    await opened({ ...options, prepare: async (page) => { cable = await Cable.lay(page, board.address); } }, (page) => look(page, cable, board));
  } finally {
    cable?.cut();
    board.stop();
  }
}

test("the simulated board has the dialogue of the command line, byte for byte", () => opened({}, async (page) => {
  const script = await readFile(new URL("dialogue.txt", import.meta.url), "utf8");
  const hash = (await readFile(new URL("dialogue.hash", import.meta.url), "utf8")).trim();
  const unlzma = (await readFile(new URL("../page/lzma.js", import.meta.url), "utf8")).replaceAll("export ", "");
  const ended = await page.value(`(async () => {
    const text = (id) => document.getElementById(id).textContent;
    const bytes = Uint8Array.from(atob(text("wasm").trim()), (letter) => letter.charCodeAt(0));
    ${unlzma}
    const module = await WebAssembly.compile(unlzma(bytes));
    const worker = new Worker(URL.createObjectURL(new Blob([text("worker-text")], { type: "text/javascript" })));
    worker.postMessage({ module });
    for (const request of [{ ask: "arm", armed: true }, { ask: "lines", id: 1, text: ${JSON.stringify(script)} }, { ask: "leave" }]) worker.postMessage({ request });
    worker.postMessage({ connect: { scene: JSON.stringify({ name: "lock" }) } });
    return new Promise((resolve) => { worker.onmessage = ({ data }) => { const event = JSON.parse(data.event ?? JSON.stringify(data)); if (event.event === "ended" || event.lost || event.panic) resolve(event); }; });
  })()`);
  assert.deepEqual(ended, { event: "ended", error: null, dialogue: hash });
}));

test("a board is only read until it is armed, and STOP and Esc stop it", () => opened({}, async (page) => {
  await click(page, "b-simulate");
  await page.until(state("connected"));
  await logged(page, "> update");
  assert.match(await text(page, "b-identity"), /a Sonoglide board, firmware .*protocol/);
  assert.equal(await page.value("document.getElementById('b-acts').matches(':disabled')"), true);
  await send(page, "lock");
  await page.until("document.getElementById('b-error').textContent.includes('arm this connection first')");
  await click(page, "b-arm");
  await page.until(state("armed"));
  for (const stop of [() => click(page, "b-stop"), () => page.key("Escape")]) {
    await send(page, "drive --volts 1");
    await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
    await stop();
    await logged(page, "stopped: the drive is silent");
    await page.until("document.getElementById('b-mode').textContent === 'idle'");
    await page.value("document.getElementById('b-log').textContent = ''");
  }
  await send(page, "drive --volts 1");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
  await click(page, "b-arm");
  await page.until(`${state("connected")} && document.getElementById('b-mode').textContent === 'idle'`);
  await click(page, "b-arm");
  await page.until(state("armed"));
  await send(page, "settings set link.patience_s 0");
  await page.until("document.getElementById('b-error').textContent.includes('is not changed by a page')");
  await click(page, "b-leave");
  await page.until("document.getElementById('b-state').textContent === 'Disconnected.'");
  // The next connection is armed anew.
  await click(page, "b-simulate");
  await page.until(state("connected"));
  assert.equal(await text(page, "b-armed"), "read-only");
}));

test("a recording has the signals of the drive, and the commands are a script", () => opened({}, async (page) => {
  const saved = (id) => page.value(`new Promise((resolve) => {
    const address = URL.createObjectURL;
    URL.createObjectURL = (blob) => { URL.createObjectURL = address; blob.text().then(resolve); return address.call(URL, blob); };
    document.getElementById('${id}').click();
  })`);
  await click(page, "b-simulate");
  await armed(page);
  await click(page, "b-record");
  await send(page, "scan -o scan");
  await page.until("!document.getElementById('b-loop-panel').hidden");
  await send(page, "drive --volts 1 --for 0.2");
  await logged(page, "the drive is silent", 20000);
  await page.picture(join(folder, "pictures", "board-scan.png"));
  const [head, ...rows] = (await saved("b-record")).trim().split("\n").map((row) => row.split(","));
  const column = (name) => rows.map((row) => row[head.indexOf(name)]);
  const volts = column("voltage_v").map(Number).filter((_, n) => column("mode")[n] === "run");
  assert.ok(volts.some((value) => Math.abs(value - 1) < 0.1), volts.slice(0, 20).join());
  assert.ok(column("time_s").map(Number).every((time, n, all) => n === 0 || time >= all[n - 1]));
  assert.equal(await saved("b-save-script"), "scan -o scan\ndrive --volts 1 --for 0.2\n");
}));

/** Returns the bursts that the bars show, s: start and end of each. */
const bars = (page) => page.value("[...document.querySelectorAll('#b-timeline .move')].map((one, n) => ['start', 'end'].map((end) => Number(document.querySelector(`#b-timeline [aria-label=\"Burst ${n + 1}, ${end}\"]`).getAttribute('aria-valuenow'))))");

test("bursts are edited by mouse and keyboard, and the board gets the times of the bars", { timeout: 120000 }, () => opened({}, async (page) => {
  await page.value("document.getElementById('b-scene').value = 'lock'");
  await click(page, "b-simulate");
  await armed(page);
  const focus = (name) => page.value(`document.querySelector('[aria-label="${name}"]').focus()`);
  const press = async (name, ...keys) => { await focus(name); for (const [key, modifiers] of keys) await page.key(key, modifiers); };
  const SHIFT = 8;
  // The board has the bursts of its scene.
  await page.until("document.querySelectorAll('#b-timeline .move').length === 2");
  assert.deepEqual(await bars(page), [[0.15, 0.22], [0.26, 0.3]]);
  await press("Burst 1, start", ["ArrowRight"], ["ArrowRight", SHIFT]);
  await press("Burst 1, end", ["ArrowLeft"]);
  await press("Burst 2, position", ["ArrowLeft"], ["ArrowLeft"]);
  assert.deepEqual((await bars(page)).slice(0, 2), [[0.1555, 0.215], [0.25, 0.29]]);
  // Neighbours are limits.
  await press("Burst 2, position", ["Home"]);
  assert.deepEqual((await bars(page))[1], [0.215, 0.255]);
  await press("Burst 2, end", ["Delete"]);
  await click(page, "b-add");
  await click(page, "b-add");
  const before = await bars(page);
  assert.deepEqual(before, [[0.052, 0.104], [0.1555, 0.215], [0.31, 0.405]]);
  // The timeline always contains all bars.
  await page.value("(() => { const span = document.getElementById('b-span'); span.value = '0.02'; span.dispatchEvent(new Event('change')); })()");
  assert.equal(await page.value("document.getElementById('b-span').value"), "0.5");
  // The bar in the middle follows the mouse, and so does the end of the last one.
  const drag = async (name, pixels) => {
    const [x, y] = await page.value(`(() => { const one = document.querySelector('[aria-label="${name}"]'); one.scrollIntoView({ block: "center", behavior: "instant" }); const b = one.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()`);
    for (const [type, at] of [["mousePressed", x], ["mouseMoved", x + pixels / 2], ["mouseMoved", x + pixels], ["mouseReleased", x + pixels]]) await page.send("Input.dispatchMouseEvent", { type, x: at, y, button: "left", buttons: 1, clickCount: 1 });
  };
  await drag("Burst 2, position", 9);
  await drag("Burst 3, end", 12);
  const shown = await bars(page), width = await page.value("document.getElementById('b-timeline').clientWidth");
  const moved = Math.round((1000 * 9) / width) * 5e-4, longer = Math.round((1000 * 12) / width) * 5e-4;
  const micro = (time) => Math.round(1e6 * time);
  assert.deepEqual(shown.flat().map(micro), [before[0], before[1].map((time) => time + moved), [before[2][0], before[2][1] + longer]].flat().map(micro));
  await page.picture(join(folder, "pictures", "board-bursts.png"));
  await submit(page, "b-burst");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'", 20000);
  assert.equal(await text(page, "b-error"), "");
  await send(page, "settings get burst");
  await logged(page, "> settings get burst");
  const log = await text(page, "b-log");
  const active = (n, end) => Number(new RegExp(`burst\\.${end}_${n}_s +(\\S+)`).exec(log.slice(log.indexOf("> settings get burst")))[1]);
  assert.deepEqual(Array.from({ length: 8 }, (_, n) => [active(n + 1, "on"), active(n + 1, "off")]), Array.from({ length: 8 }, (_, n) => shown[n] ?? [0, 0]));
  await page.key("Escape");
  await page.until("document.getElementById('b-mode').textContent === 'idle'");
  await page.value("(() => { const files = new DataTransfer(); files.items.add(new File(['no update'], 'a.bin')); const i = document.getElementById('b-update'); i.files = files.files; i.dispatchEvent(new Event('change')); })()");
  await page.until("document.getElementById('b-error').textContent.includes('this is not an update: it is too short')");
}));

test("the self-test of a bare board shows its figures, and a failure", { timeout: 120000 }, async () => {
  await opened({}, async (page) => {
    await page.value("document.getElementById('b-scene').value = 'dummy-load'");
    await click(page, "b-jumper");
    await click(page, "b-simulate");
    await page.until(state("connected"));
    await send(page, "selftest");
    await page.until("document.getElementById('b-error').textContent.includes('`selftest` acts on the board: arm this connection first')");
    await armed(page);
    await page.value("document.querySelector('[data-run^=selftest]').click()");
    await page.until("!document.getElementById('b-result').hidden", 30000);
    assert.match(await text(page, "b-answer"), /gain       V (2\.00|1\.99)\d+, I (2\.00|1\.99)\d+ codes per code of the DAC[^]*\npassed\n$/);
    assert.equal(await text(page, "b-error"), "");
    assert.deepEqual(await page.value("[...document.querySelectorAll('#b-figures h3')].map((one) => one.textContent)"), ["Tone of the self-test", "Codes at rest"]);
    assert.equal(await page.value("document.querySelectorAll('#b-figures .uplot').length"), 2);
    assert.match(await text(page, "b-result-files"), /selftest\.json/);
    await page.picture(join(folder, "pictures", "board-selftest.png"));
  });
  await opened({}, async (page) => {
    await page.value("document.getElementById('b-scene').value = 'dummy-load'");
    await click(page, "b-simulate");
    await armed(page);
    await page.value("document.querySelector('[data-run^=selftest]').click()");
    await page.until("/self-test|played no tone/.test(document.getElementById('b-error').textContent)", 30000);
  });
});

test("a second tab of a served page watches the board, and can stop it", async () => {
  const server = createServer(async (_, response) => response.end(await readFile(join(folder, "sonoglide.html")))).listen(0, "127.0.0.1");
  await once(server, "listening");
  const open = async () => {
    const page = await browser.page(`http://127.0.0.1:${server.address().port}/#board`, { newWindow: true });
    await page.until("document.body.dataset.state === 'done'");
    return page;
  };
  const page = await open();
  await click(page, "b-simulate");
  await armed(page);
  await send(page, "drive --volts 1");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
  const other = await open();
  await other.until("document.getElementById('b-mode').textContent === 'run, locked'");
  assert.match(await text(other, "b-state"), /Another tab of this page holds a simulated board/);
  assert.equal(await other.value("document.getElementById('b-connects').hidden && document.getElementById('b-acts').hidden"), true);
  await click(other, "b-stop");
  await logged(page, "stopped: the drive is silent");
  await other.until("document.getElementById('b-mode').textContent === 'idle'");
  await click(page, "b-leave");
  await other.until("!document.getElementById('b-connects').hidden");
  // Opened from a disk, tabs do not know of each other, and the port of the first is busy in the second.
  assert.deepEqual([...page.complaints, ...other.complaints], []);
  await Promise.all([page.close(), other.close()]);
  server.close();
});

test("a wrong value is a message next to STOP, wherever the page is scrolled to", () => opened({ width: 390, height: 844 }, async (page) => {
  await click(page, "b-simulate");
  await armed(page);
  const enter = (id, words) => page.value(`(() => { const field = document.getElementById('${id}') ?? document.querySelector('[data-form^="${id}"] input'); field.value = '${words}'; field.form.scrollIntoView({ behavior: "instant" }); field.form.requestSubmit(); })()`);
  for (const [id, words, message] of [
    ["b-low", "forty", "`forty` is not a frequency in kHz, such as 40 or 40.5"],
    ["b-low", "50", "The band begins with the lower frequency: 50 kHz is not below 45 kHz"],
    ["drive", "2 --stay", "`2--stay`: the unit `--stay` is unknown; expected volts, such as 2, 2V or 500mV"],
    ["friction", "-1", "`-1`: expected a ratio from 0 to 1 (0.4), a force (0.05N), or `configured`"],
  ]) {
    await enter(id, words);
    await page.until(`document.getElementById('b-error').textContent === ${JSON.stringify(message)}`);
    const [above, below] = await page.value("['top', 'bottom'].map((end) => document.getElementById('b-error').getBoundingClientRect()[end])");
    assert.ok(above > 0 && below < 844, `${message}: from ${above} to ${below}`);
  }
  // A decimal comma is a point.
  await enter("drive", "1,5");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
  assert.equal(await page.value("document.getElementById('b-error').hidden"), true);
}));

test("the page has the firmware of an empty Nucleo", (context) => opened({}, async (page) => {
  if (!(await text(page, "firmware"))) return context.skip("the page was packed without it");
  const bytes = await page.value(`new Promise((resolve) => {
    const address = URL.createObjectURL;
    URL.createObjectURL = (blob) => { URL.createObjectURL = address; blob.arrayBuffer().then((whole) => resolve([...new Uint8Array(whole)])); return address.call(URL, blob); };
    document.getElementById('b-firmware').click();
  })`);
  const image = Buffer.from(bytes), [stack, reset] = [image.readUInt32LE(0), image.readUInt32LE(4)];
  assert.ok(stack > 0x20000000 && stack <= 0x20020000 && reset % 2 === 1 && reset > 0x08000000 && reset < 0x08000000 + image.length, `${stack} ${reset}`);
  assert.ok(image.equals(await readFile(join(folder, "..", "web-parts", "nucleo.bin"))));
}));

test("a browser without the means for it has the simulator and a sentence", () => opened({
  prepare: (page) => page.send("Page.addScriptToEvaluateOnNewDocument", { source: "delete WebAssembly.Suspending; Object.defineProperty(navigator, 'serial', { value: undefined });" }),
}, async (page) => {
  assert.match(await text(page, "b-unsupported"), /use Chrome, Edge or another Chromium, version 137 or later/);
  assert.equal(await page.value("document.getElementById('b-connect').disabled && document.getElementById('b-simulate').disabled"), true);
}));

/** Tunes the board at the cable to an unknown transducer; `clock` returns a time, s. */
async function tune(page, clock, limit) {
  const began = clock();
  await click(page, "b-connect");
  await page.until(state("connected"), limit);
  await click(page, "b-arm");
  await page.until(state("armed"), limit);
  await type(page, "b-low", "30");
  await type(page, "b-high", "50");
  await type(page, "b-volts", "3");
  await submit(page, "b-commission");
  await page.until("!document.getElementById('b-proposal').hidden", limit);
  assert.match(await text(page, "b-proposed"), /proposed settings, and their effect or uncertainty/);
  await page.until("!document.getElementById('b-loop-panel').hidden");
  await page.picture(join(folder, "pictures", "board-tuned.png"));
  await click(page, "b-accept");
  await page.until("document.body.dataset.tuned === 'yes'", limit);
  const seconds = clock() - began, clicks = await page.value("clicks");
  console.log(`tuned in ${seconds.toFixed(1)} s and ${clicks} clicks`);
  assert.ok(clicks <= 6 && seconds <= 90, `${clicks} clicks, ${seconds} s`);
}

test("an unknown transducer is tuned in six clicks", { timeout: 120000 }, () => wired("transducer-skymen-60w", async (page, cable, board) => {
  await tune(page, () => Date.now() / 1000, 90000);
  await click(page, "b-leave");
  await page.until("document.getElementById('b-state').textContent.startsWith('Disconnected')");
  const lock = await board.ask("lock");
  assert.ok(Math.abs(lock.frequency_hz - 40038.8) < 30, JSON.stringify(lock));
}));

/** Opens a page with a cable to the modelled board with the flashed image. */
async function modelled(scene, look, atOnce = null) {
  let board;
  const prepare = async (page) => {
    board = await ModelledBoard.start(page, scene);
    if (atOnce) await page.send("Page.addScriptToEvaluateOnNewDocument", { source: `globalThis.requestsAtOnce = ${JSON.stringify(atOnce)}` });
  };
  await opened({ prepare }, (page) => look(page, board)).finally(() => board?.stop());
}
const inThorough = { timeout: 1800000, skip: process.env.BRIDGE ? false : "the flashed image is tested by .ci/thorough" };

test("the flashed image has the dialogue of the command line, byte for byte", inThorough, async () => {
  const lines = `identify\n${await readFile(new URL("dialogue.txt", import.meta.url), "utf8")}`, script = join(folder, "dialogue.txt");
  await writeFile(script, lines);
  const expected = ModelledBoard.dialogue("lock", script);
  // The first line is part of every connection.
  const requests = [{ ask: "arm", armed: true }, { ask: "lines", id: 0, text: lines.replace("identify\n", "") }, { ask: "leave" }];
  await modelled("lock", async (page, board) => {
    await click(page, "b-connect");
    await page.until("document.getElementById('b-state').textContent === 'Disconnected.'", 900000);
    const { sent, received } = board;
    console.log(`${sent.length} bytes sent and ${received.length} received in ${(1e-3 * board.now_ms).toFixed(2)} s of the board`);
    assert.ok(sent.length > 1000 && received.length > 1000);
    assert.deepEqual([sent, received], await expected);
  }, requests);
});

test("the flashed image is tuned to an unknown transducer in six clicks", inThorough, () => modelled("transducer-skymen-60w", async (page, board) => {
  await tune(page, () => 1e-3 * board.now_ms, 900000);
  await send(page, "lock");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'", 900000);
  const frequency = Number(/resonance at (\S+) Hz|locked at (\S+) Hz/.exec(await text(page, "b-log"))?.slice(1).find(Boolean));
  assert.ok(Math.abs(frequency - 40038.8) < 30, `${frequency} Hz`);
  await click(page, "b-leave");
  await page.until("document.getElementById('b-state').textContent === 'Disconnected.'", 900000);
}));

test("a page that only reads leaves the drive of another host running", () => wired("lock", async (page, cable, board) => {
  await board.ask("drive", "--volts", "1", "--stay");
  await click(page, "b-connect");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
  await click(page, "b-leave");
  await page.until("document.getElementById('b-state').textContent === 'Disconnected.'");
  assert.equal((await board.ask("status")).mode, "run");
  await click(page, "b-connect");
  await page.until(state("connected"));
  await logged(page, "> update");
  await page.key("Escape");
  await page.until("document.getElementById('b-mode').textContent === 'idle'");
}));

test("STOP reaches the port at once, also during a capture", () => wired("lock", async (page, cable) => {
  await click(page, "b-connect");
  await armed(page);
  await send(page, "drive --volts 1");
  await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
  const delays = [];
  for (let n = 0; n < 5; n += 1) {
    await send(page, "capture -o here");
    await sleep(15 * n);
    const before = cable.sent.length, at = Date.now();
    const isStop = ({ bytes }) => bytes.indexOf("ffff03", "hex") >= 0;
    await page.key("Escape");
    while (!cable.sent.slice(before).some(isStop)) await sleep(1);
    delays.push(Date.now() - at);
    await page.until("document.getElementById('b-mode').textContent === 'idle'");
    await send(page, "drive --volts 1");
    await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
  }
  console.log(`STOP after ${delays.join(", ")} ms`);
  assert.ok(delays.every((ms) => ms <= 50), delays.join());
}));

test("without a living, visible page the board is silent within its host timeout", { timeout: 1800000 }, async () => {
  const ends = [
    ["pulled", (page) => page.value("pullCable()")],
    ["closed", (page) => page.close()],
    ["hidden", () => browser.page("about:blank")],
    ["frozen", (page) => page.send("Page.setWebLifecycleState", { state: "frozen" })],
    ["busy", (page) => page.send("Runtime.evaluate", { expression: "for (const end = Date.now() + 4000; Date.now() < end;);" }).catch(() => {}) && null],
  ];
  for (let n = 0; n < PULLS; n += 1) {
    const [how, end] = ends[n % ends.length], board = await ServedBoard.start("lock");
    let cable;
    const page = await browser.page(address, { prepare: async (one) => { cable = await Cable.lay(one, board.address); } });
    try {
      await page.until("document.body.dataset.state === 'done'");
      await click(page, "b-connect");
      await armed(page);
      await send(page, "drive --volts 1");
      await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
      await sleep(Math.random() * 400);
      await end(page);
      await sleep(HOST_TIMEOUT_MS + MARGIN_MS);
      cable.cut();
      const { mode } = await board.ask("status");
      assert.ok(["idle", "fault"].includes(mode), `${how}: ${mode}`);
      if (how === "hidden") {
        assert.equal(await page.value("document.hidden"), true);
        await logged(page, "the page was hidden: the drive was stopped, and the connection is disarmed");
      }
      if (how === "pulled") assert.match(await text(page, "b-error"), /lost the serial port: .*cable/);
    } finally {
      if (how !== "closed") await page.close().catch(() => {});
      cable.cut();
      board.stop();
    }
  }
});

/** Returns a frame of a later version of the protocol, whose body is unknown here. */
function laterFrame() {
  const plain = [4, 1, 5, 0, 0, 0, 0xff];
  let crc = 0xffffffff;
  for (const byte of plain) {
    crc ^= byte;
    for (let n = 0; n < 8; n += 1) crc = (crc >>> 1) ^ (crc & 1 ? 0x82f63b78 : 0);
  }
  const checked = Buffer.alloc(11);
  checked.set(plain);
  checked.writeUInt32LE(~crc >>> 0, 7);
  // COBS: each zero becomes the distance to the next.
  const stuffed = [];
  for (const part of checked.toString("latin1").split("\0")) stuffed.push(part.length + 1, ...Buffer.from(part, "latin1"));
  return Buffer.from([...stuffed, 0]);
}

test("foreign devices, other versions and busy ports have a message and no dead end", async () => {
  const garbage = (bytes) => ({ prepare: async (page) => { (await Cable.lay(page, null)).onsend = (_, cable) => cable.give(bytes); } });
  await opened(garbage(Buffer.from("hello\r\n")), async (page) => {
    await click(page, "b-connect");
    await page.until("document.getElementById('b-error').textContent.includes('answers, but not as a Sonoglide board')");
    assert.equal(await page.value("document.getElementById('b-connects').hidden"), false);
    await page.value("globalThis.portIsBusy = true");
    await click(page, "b-connect");
    await page.until("document.getElementById('b-error').textContent.includes('another program or tab')");
    await click(page, "b-simulate");
    await page.until(state("connected"));
  });
  await opened(garbage(laterFrame()), async (page) => {
    await click(page, "b-connect");
    await page.until("/speaks version 4 of the link's protocol, this program version \\d/.test(document.getElementById('b-error').textContent)");
  });
  await opened(garbage(Buffer.alloc(0)), async (page) => {
    await click(page, "b-connect");
    await page.until("document.getElementById('b-error').textContent.includes('nothing answers there')");
  });
});

test("damaged frames are repeated, and a restarted board is a message", () => wired("lock", async (page, cable, board) => {
  cable.onsend = (bytes) => {
    // Every fifth frame has a wrong byte.
    if (cable.sent.length % 5 === 0 && bytes.length > 4) bytes[2] ^= 0x10;
    cable.socket?.write(bytes);
  };
  await click(page, "b-connect");
  await armed(page);
  await send(page, "lock");
  await logged(page, "locked", 20000);
  cable.onsend = null;
  // A damaged byte ends the stream of the port, which has another one.
  await page.value("damageByte()");
  await click(page, "b-stop");
  await page.until("document.getElementById('b-mode').textContent === 'idle'");
  // A restart by another client ends this session.
  cable.cut();
  await board.ask("reset");
  cable.take("open");
  await send(page, "status");
  await page.until("/obeys another session|no answer/.test(document.getElementById('b-error').textContent)");
  await page.until("document.querySelector('#b-tiles dt').textContent === 'mode in the last report'");
  await click(page, "b-connect");
  await page.until(state("connected"));
}));

test("the twin runs next to the board, and settings are compared", { timeout: 120000 }, () => opened({}, async (page) => {
  await page.value("document.getElementById('b-scene').value = 'lock'");
  await click(page, "b-simulate");
  await armed(page);
  await submit(page, "b-commission");
  await page.until("!document.getElementById('b-proposal').hidden", 90000);
  await click(page, "b-accept");
  await page.until("document.body.dataset.tuned === 'yes'", 60000);
  await page.value("document.getElementById('b-twin').click()");
  await logged(page, "the twin runs next to the board", 30000);
  await send(page, "lock");
  const apart = await page.until("document.getElementById('b-mode').textContent === 'run, locked' && [...document.querySelectorAll('#b-values tr')].find((row) => row.cells[0].textContent === 'frequency' && /^.?\\d+(\\.\\d+)? Hz$/.test(row.cells[3].textContent) && Math.abs(Number(row.cells[3].textContent.replace('\u2212', '-').replace(' Hz', ''))) < 30)?.cells[3].textContent", 30000);
  console.log(`board − twin: ${apart}`);
  await click(page, "b-stop");
  await page.value("document.getElementById('b-settings-panel').open = true");
  await page.until("document.querySelectorAll('#b-settings tr').length > 50", 30000);
  await page.value("(() => { const s = document.getElementById('b-differ'); s.value = 'default'; s.dispatchEvent(new Event('change')); })()");
  await page.until("document.getElementById('b-settings').textContent.includes('tracking.nominal_q')");
  await page.picture(join(folder, "pictures", "board-settings.png"));
}));

test("axe finds nothing at a board, and a phone shows it without horizontal scrolling", async (context) => {
  const source = await readFile(process.env.AXE ?? "", "utf8").catch(() => null);
  for (const [name, options] of [["light", {}], ["dark", { dark: true }], ["phone", { width: 390, height: 844 }]]) {
    await opened(options, async (page) => {
      await click(page, "b-simulate");
      await armed(page);
      await send(page, "drive --volts 1");
      await page.until("document.getElementById('b-mode').textContent === 'run, locked'");
      await sleep(700);
      await page.picture(join(folder, "pictures", `board-${name}.png`));
      await page.value("document.querySelectorAll('#board details').forEach((one) => { one.open = true; })");
      await page.until("document.querySelectorAll('#b-settings tr').length > 50", 30000);
      if (options.width) assert.equal(await page.value("document.documentElement.scrollWidth"), options.width);
      // The button to stop is not covered.
      assert.equal(await page.value("(() => { const b = document.getElementById('b-stop').getBoundingClientRect(); return document.elementFromPoint(b.x + b.width / 2, b.y + b.height / 2).id; })()"), "b-stop");
      if (source === null) return;
      await page.value(source);
      const found = await page.value("axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] }).then(({ violations }) => violations.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 4).map((node) => node.target + ' ' + (node.any[0]?.message ?? '')).join(', ')}`))");
      assert.deepEqual(found, [], name);
    });
  }
  if (source === null) context.skip("axe-core could not be installed");
});
