// A request: a scene and its changes, as used by the page, the command line and a link.
import { plain } from "./format.js";

const encoder = new TextEncoder();

/** A scene and the reader's changes of it. */
export class Ask {
  /** Creates a request for a built-in scene by its entry, or for the reader's own text. */
  constructor({ name, text = null, sets = [] }) {
    Object.assign(this, { name, text, base: [...sets], moved: new Map(), bursts: null, faults: [], whole: false, faultCount: 0 });
  }

  /** Returns the changes as `key=value`. */
  get sets() {
    const given = new Map();
    for (const [key, { value, also }] of this.moved) {
      given.set(key, value);
      for (const [other, number] of also) if (!this.moved.has(other)) given.set(other, plain(number));
    }
    // A switch in the run replaces an earlier slider of its bursts.
    const switched = (key) => this.bursts && /^controller\.burst\.o(n|ff)_s$/.test(key);
    const own = [...given].filter(([key]) => !switched(key)).map(([key, value]) => `${key}=${value}`);
    const list = (times) => `[${times.map(plain).join(", ")}]`;
    const bursts = this.bursts ? [`controller.burst.on_s=${list(this.bursts.on_s)}`, `controller.burst.off_s=${list(this.bursts.off_s)}`] : [];
    const faults = this.faults.map(({ at_s, fault }, place) => `fault.${this.faultCount + place}={at_s=${plain(at_s)}, ${fault}}`);
    const newer = new Set([...own, ...bursts].map((set) => set.split("=")[0]));
    return [...this.base.filter((set) => !newer.has(set.split("=")[0])), ...own, ...bursts, ...faults];
  }

  /** Returns the ON and OFF times: those of the scene, as changed by sliders, or by the switch. */
  burst(scene) {
    const moved = (key) => JSON.parse(this.moved.get(`controller.burst.${key}`)?.value ?? "null") ?? scene[key];
    return this.bursts ?? { ...scene, on_s: moved("on_s"), off_s: moved("off_s") };
  }

  /** Returns the request for the simulator. */
  get request() {
    return { name: this.name, text: this.text, sets: this.sets, whole: this.whole };
  }

  /** Returns true if anything differs from the scene as the page opens it. */
  get changed() {
    return this.moved.size > 0 || this.bursts !== null || this.faults.length > 0;
  }

  /** Returns the equivalent command line. */
  get command() {
    const quoted = (text) => (/^[\w.=+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
    return ["sim-host run", quoted(this.text === null ? this.name : this.name), ...this.sets.map((set) => `--set ${quoted(set)}`)].join(" ");
  }
}

async function through(bytes, transform) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(transform)).arrayBuffer());
}

/** Returns a fragment with the scene and its changes: readable for an unchanged built-in scene, otherwise compressed. */
export async function toFragment(ask) {
  if (ask.text === null && ask.sets.length === 0 && !ask.whole) return `#scene=${ask.name}`;
  const state = JSON.stringify({ n: ask.name, t: ask.text, s: ask.sets, w: ask.whole || undefined });
  const packed = await through(encoder.encode(state), new CompressionStream("deflate-raw"));
  let letters = "";
  for (const byte of packed) letters += String.fromCharCode(byte);
  return `#z=${btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
}

/** Returns the scene of a fragment; null if it contains none. */
export async function fromFragment(fragment) {
  const named = /^#scene=([\w-]+)$/.exec(fragment);
  if (named) return { name: named[1], text: null, sets: [], whole: false };
  const packed = /^#z=([\w-]+)$/.exec(fragment);
  if (!packed) return null;
  try {
    const letters = atob(packed[1].replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = await through(Uint8Array.from(letters, (letter) => letter.charCodeAt(0)), new DecompressionStream("deflate-raw"));
    const { n, t, s, w } = JSON.parse(new TextDecoder().decode(bytes));
    if (typeof n !== "string" || !(t === null || typeof t === "string") || !Array.isArray(s) || !s.every((set) => typeof set === "string")) return null;
    return { name: n, text: t, sets: s, whole: Boolean(w) };
  } catch {
    return null;
  }
}
