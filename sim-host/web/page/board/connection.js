// A connection to a board: its port, and the client in a worker. All bytes to a serial port pass
// through the page, so that a page that is closed, hidden, frozen or busy sends none, and the board
// stops its drive after its host timeout.

/** Baud rate of the board, bit/s; the client cannot change it. */
const BAUD = 921600;

/** Why this browser cannot talk to a board; null if it can. */
export function unsupported({ serial }) {
  if (!WebAssembly.Suspending) return "This browser cannot run the client of a board: use Chrome, Edge or another Chromium, version 137 or later. The simulator works here.";
  if (serial && !navigator.serial) return "This browser has no Web Serial: use Chrome, Edge or another Chromium on a computer. The simulator and the simulated board work here.";
  return null;
}

/** Lets the user choose a serial port, and opens it. */
export async function openSerial() {
  const port = await navigator.serial.requestPort();
  try {
    await port.open({ baudRate: BAUD, bufferSize: 65536 });
  } catch (error) {
    throw new Error(`The port cannot be opened: ${error.message} Does another program or tab use it (a terminal, a modem manager, another page)? End that first. On Linux, your user needs access to the port: see the book, "Talk to a board".`);
  }
  return port;
}

export class Connection {
  #worker;
  #port;
  #writer = null;
  #waiting = new Map();
  #count = 0;
  #stopFrame = null;
  #ended = false;
  /** True once this connection was armed. Otherwise a running drive belongs to another host, and only STOP ends it. */
  #mayDrive = false;

  /** Connects to an open serial port, or to a simulated board of a scene. */
  constructor(worker, { port = null, scene = null }, onevent) {
    this.#worker = worker;
    this.#port = port;
    this.onevent = onevent;
    worker.onmessage = ({ data }) => this.#receive(data);
    worker.onerror = ({ message }) => this.#end(message);
    if (port) this.#openStreams();
    worker.postMessage({ connect: { scene: scene && JSON.stringify(scene) } });
    this.watch = ({ type }) => this.#look(document.hidden || type === "freeze" || type === "pagehide");
    for (const name of ["visibilitychange", "freeze", "resume"]) document.addEventListener(name, this.watch);
    window.addEventListener("pagehide", this.watch);
  }

  get isSerial() { return this.#port !== null; }

  #openStreams() {
    this.#writer = this.#port.writable.getWriter();
    this.#read();
  }

  async #read() {
    // After a damaged byte the port has another stream; after a pulled cable it has none.
    while (this.#port.readable && !this.#ended) {
      this.reader = this.#port.readable.getReader();
      try {
        for (;;) {
          const { value, done } = await this.reader.read();
          if (done) break;
          this.#worker.postMessage({ bytes: value }, [value.buffer]);
        }
      } catch { /* The frame is repeated, or the port is lost. */ }
      this.reader.releaseLock();
    }
    this.#worker.postMessage({ closed: true });
  }

  #write(bytes) {
    this.#writer?.write(bytes).catch(() => this.#worker.postMessage({ closed: true }));
  }

  #receive({ event, send, panic, lost }) {
    if (send) {
      // A hidden page gives no sign of life.
      if (!document.hidden) this.#write(send);
      return;
    }
    if (panic !== undefined || lost !== undefined) return this.#end(`the program has stopped: ${panic ?? lost}`);
    if (event === undefined) return;
    const told = JSON.parse(event);
    if (told.event === "stop_frame") this.#stopFrame = Uint8Array.from(told.bytes);
    if (told.event === "armed") this.#mayDrive ||= told.armed;
    if (told.event === "done") {
      this.#waiting.get(told.id)?.(told.error);
      this.#waiting.delete(told.id);
    }
    if (told.event === "ended") return this.#end(told.error);
    this.onevent(told);
  }

  /** Stops the drive past all queues: by a frame of its own, and by ending the present command. */
  stop() {
    if (this.#stopFrame) this.#write(this.#stopFrame);
    this.#worker.postMessage({ interrupt: true });
    for (const resolve of this.#waiting.values()) resolve("stopped");
    this.#waiting.clear();
  }

  #look(hidden) {
    if (hidden && this.#mayDrive) {
      this.stop();
      this.ask({ ask: "arm", armed: false });
      this.onevent({ event: "hidden" });
    }
    this.#worker.postMessage({ hidden });
  }

  /** Sends a request without an answer. */
  ask(request) { this.#worker.postMessage({ request }); }

  /** Sends a request, and returns its error, or null. */
  request(request) {
    const id = (this.#count += 1);
    return new Promise((resolve) => {
      this.#waiting.set(id, resolve);
      this.ask({ ...request, id });
    });
  }

  /** Runs lines of a script; returns the error, or null. */
  run(text) { return this.request({ ask: "lines", text }); }

  /** Ends the session, and the drive that it has started. */
  leave() {
    if (this.#mayDrive) this.stop();
    this.ask({ ask: "leave" });
  }

  async #end(error) {
    if (this.#ended) return;
    this.#ended = true;
    for (const name of ["visibilitychange", "freeze", "resume"]) document.removeEventListener(name, this.watch);
    window.removeEventListener("pagehide", this.watch);
    this.#worker.terminate();
    for (const resolve of this.#waiting.values()) resolve(error ?? "the connection has ended");
    this.#waiting.clear();
    // The port is closed even if the client has failed; a lost one cannot be.
    if (this.#port) {
      if (this.#stopFrame && this.#mayDrive) this.#write(this.#stopFrame);
      await this.reader.cancel().catch(() => {});
      await this.#writer.close().catch(() => {});
      this.#writer.releaseLock();
      await this.#port.close().catch(() => {});
    }
    this.onevent({ event: "ended", error });
  }
}
