// The simulator, in a separate worker. Stopping a run ends its worker, and the next request starts
// another.

import { unlzma } from "./lzma.js";

/** Unpacks compressed text of the page. */
export const unpacked = (packed) => unlzma(Uint8Array.from(atob(packed.trim()), (letter) => letter.charCodeAt(0)));

/** An error in a scene, or a run without a result, with the message of the command line. */
export class SimulatorError extends Error {}

export class Core {
  #module = null;
  #worker = null;
  #waiting = new Map();
  #count = 0;

  /** Creates the simulator from the module, which is compressed text in the page, or is that of another one. */
  constructor(packed, script, other = null) {
    this.script = other?.script ?? URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
    this.#module = other ? other.#module : Core.#compile(packed);
    this.onprogress = () => {};
  }

  static async #compile(packed) { return WebAssembly.compile(unpacked(packed)); }

  /** Starts a worker with the module. */
  async spawn() {
    const worker = new Worker(this.script);
    worker.postMessage({ module: await this.#module });
    return worker;
  }

  async #start() {
    await this.#module;
    if (this.#worker) return this.#worker;
    const worker = await this.spawn();
    worker.onmessage = ({ data }) => this.#receive(data);
    worker.onerror = (event) => this.#lost(event.message);
    this.#worker = worker;
    return worker;
  }

  #receive({ id, answer, progress, panic, lost }) {
    if (progress !== undefined) return this.onprogress(progress);
    if (panic !== undefined || lost !== undefined) return this.#lost(panic ?? lost);
    const { resolve, reject } = this.#waiting.get(id);
    this.#waiting.delete(id);
    const { value, error } = JSON.parse(answer);
    return error === undefined ? resolve(value) : reject(new SimulatorError(error));
  }

  #lost(said) {
    this.stop(new SimulatorError(`error: the simulator has stopped: ${said}`));
  }

  /** Stops all requests. */
  stop(reason = null) {
    this.#worker?.terminate();
    this.#worker = null;
    for (const { reject } of this.#waiting.values()) reject(reason ?? new DOMException("stopped", "AbortError"));
    this.#waiting.clear();
  }

  /** Sends a request to the simulator, with the content of a file if it has one. Returns its value. */
  async ask(question, argument, content) {
    const worker = await this.#start();
    const id = (this.#count += 1);
    const text = typeof argument === "string" ? argument : JSON.stringify(argument ?? {});
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      worker.postMessage({ id, ask: question, argument: text, content });
    });
  }
}
