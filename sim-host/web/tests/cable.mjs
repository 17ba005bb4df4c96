// A served board of the simulator, and a cable from it to a page: a stand-in for `navigator.serial`
// whose bytes go to a TCP port.
import { execFile, spawn } from "node:child_process";
import { connect } from "node:net";
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
