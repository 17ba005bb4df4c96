// A served board of the simulator, and a cable from it to a page: a stand-in for `navigator.serial`
// whose bytes go to a TCP port.
import { execFile, spawn } from "node:child_process";
import { connect } from "node:net";
import { createInterface } from "node:readline";
import { promisify } from "node:util";

const SIM_HOST = process.env.SIM_HOST ?? "target/release/sim-host";

export class ServedBoard {
  /** Serves the simulated board of a scene. */
  static async start(scene) {
    const board = new ServedBoard();
    board.child = spawn(SIM_HOST, ["link", `sim:${scene}`, "serve"], { stdio: ["ignore", "pipe", "ignore"] });
    board.address = await new Promise((resolve, reject) => {
      board.child.stdout.once("data", (line) => resolve(String(line).trim()));
      board.child.once("exit", (code) => reject(new Error(`sim-host has ended with ${code}`)));
    });
    return board;
  }

  /** Runs a command of the command line; returns its answer. */
  async ask(...words) {
    const { stdout } = await promisify(execFile)(SIM_HOST, ["link", this.address, ...words, "--format", "json"]);
    return JSON.parse(stdout.trim().split("\n").at(-1));
  }

  stop() { this.child.kill(); }
}

/** Script of the page, before any other. */
const STAND_IN = `(() => {
  const lost = () => new DOMException("The device has been lost.", "NetworkError");
  let controller = null;
  const stream = () => new ReadableStream({ start(one) { controller = one; }, cancel() { controller = null; } });
  const port = {
    async open() {
      if (globalThis.portIsBusy) throw new DOMException("Failed to open serial port.", "NetworkError");
      port.readable = stream();
      port.writable = new WritableStream({ write(chunk) { if (!controller) throw lost(); toBoard(btoa(String.fromCharCode(...chunk))); } });
      toBoard("open");
    },
    async close() { toBoard("close"); },
  };
  globalThis.fromBoard = (text) => controller?.enqueue(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)));
  globalThis.damageByte = () => { const former = controller; port.readable = stream(); former.error(new DOMException("Framing error.", "FramingError")); };
  globalThis.pullCable = () => { const pulled = controller; controller = null; port.readable = null; pulled?.error(lost()); toBoard("close"); };
  Object.defineProperty(navigator, "serial", { value: { requestPort: async () => port } });
})()`;

/** Script of the page that lets the time of the client be that of a board, which advances only in turns. */
const IN_TURNS = `(() => {
  const inWorker = () => {
    let now = 0, sent = 0, received = 0, expected = 0, answered = false;
    const { sonoglideSend } = self, { bytes } = messages;
    self.sonoglideSend = (chunk) => { sent += chunk.length; sonoglideSend(chunk); };
    self.sonoglideNow = () => now;
    self.sonoglideRandom = () => Math.round(1e6 * now) % 2 ** 32;
    messages.bytes = (chunk) => { received += chunk.length; bytes(chunk); };
    messages.answer = (answer) => { now = answer.now; expected += answer.count; answered = true; link.wake(); };
    self.sonoglideWait = (ms) => new Promise((resolve) => {
      answered = reason() !== 0;
      if (!answered) self.postMessage({ turn: { ms, sent } });
      link.wake = () => {
        if (!answered || received < expected) return;
        link.wake = null;
        resolve(reason());
        link.interrupted = false;
      };
      link.wake();
    });
  };
  let worker = null;
  globalThis.Worker = class extends Worker {
    constructor(address) {
      super(address);
      this.addEventListener("message", ({ data: { turn } }) => { if (turn) { worker = this; toBoard("turn " + JSON.stringify(turn)); } });
    }
    postMessage(message, transfer) {
      if (message.connect) for (const request of globalThis.requestsAtOnce ?? []) super.postMessage({ request });
      super.postMessage(message, transfer);
    }
  };
  globalThis.answerTurn = (now, text, count) => { worker.postMessage({ answer: { now, count } }); if (count) fromBoard(text); };
  document.addEventListener("readystatechange", () => { if (document.readyState === "interactive") document.getElementById("worker-text").append("(" + inWorker + ")();"); });
})()`;

/** A modelled board with the flashed image, whose time advances only while its client waits. */
export class ModelledBoard {
  now_ms = 0;
  sent = [];
  received = [];
  #unsent = [];
  #turn = null;

  /** Starts the board of a scene, with a cable to a page that is not open yet. */
  static async start(page, scene) {
    const board = new ModelledBoard(), cable = await Cable.lay(page, null);
    await page.send("Page.addScriptToEvaluateOnNewDocument", { source: IN_TURNS });
    board.child = spawn(process.env.BRIDGE, [scene], { stdio: ["pipe", "pipe", "inherit"] });
    createInterface({ input: board.child.stdout }).on("line", (line) => {
      const [now_ms, bytes] = JSON.parse(line);
      board.now_ms = now_ms;
      board.received.push(...bytes);
      page.send("Runtime.evaluate", { expression: `answerTurn(${now_ms}, "${Buffer.from(bytes).toString("base64")}", ${bytes.length})` }).catch(() => {});
    });
    cable.onsend = (bytes) => { board.#unsent.push(...bytes); board.#advance(); };
    cable.onturn = (turn) => { board.#turn = turn; board.#advance(); };
    return board;
  }

  /** Returns the bytes that the client of the command line sends and receives in a script. */
  static async dialogue(scene, script) {
    return JSON.parse((await promisify(execFile)(process.env.BRIDGE, [scene, script], { maxBuffer: 1 << 28 })).stdout);
  }

  /** Plays a turn once all bytes are here that the client has sent before it. */
  #advance() {
    if (!this.#turn || this.sent.length + this.#unsent.length < this.#turn.sent) return;
    this.child.stdin.write(`${JSON.stringify([this.#turn.ms, this.#unsent])}\n`);
    this.sent.push(...this.#unsent);
    [this.#unsent, this.#turn] = [[], null];
  }

  stop() { this.child.kill(); }
}

export class Cable {
  /** Bytes of the page, each with its time. */
  sent = [];
  socket = null;

  /** Lays a cable from a page to an address, before the page is opened. */
  static async lay(page, address, onopen = null) {
    const cable = Object.assign(new Cable(), { page, address, onopen });
    page.onbinding = ({ payload }) => cable.take(payload);
    await page.send("Runtime.addBinding", { name: "toBoard" });
    await page.send("Page.addScriptToEvaluateOnNewDocument", { source: STAND_IN });
    return cable;
  }

  take(payload) {
    if (payload === "close") return this.cut();
    if (payload === "open") {
      if (!this.address) return this.onopen?.(this);
      const [, host, port] = /^tcp:(.*):(\d+)$/.exec(this.address);
      this.socket = connect(Number(port), host);
      this.socket.setNoDelay(true);
      this.socket.on("data", (bytes) => this.give(bytes)).on("error", () => {});
      return undefined;
    }
    if (payload.startsWith("turn ")) return this.onturn(JSON.parse(payload.slice(5)));
    const bytes = Buffer.from(payload, "base64");
    this.sent.push({ at: Date.now(), bytes });
    return this.onsend ? this.onsend(bytes, this) : this.socket?.write(bytes);
  }

  /** Gives bytes to the page. */
  give(bytes) {
    return this.page.send("Runtime.evaluate", { expression: `fromBoard("${Buffer.from(bytes).toString("base64")}")` }).catch(() => {});
  }

  cut() {
    this.socket?.destroy();
    this.socket = null;
  }
}
