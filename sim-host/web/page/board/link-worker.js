// The client of a board in a worker. It waits for bytes by suspending its WebAssembly stack
// (JavaScript Promise Integration), so that the code of the command line runs unchanged.
const INTERRUPTED = -2, CLOSED = -1;
const link = { port: undefined, requests: [], chunks: [], wake: null, interrupted: false, closed: false, hiddenSince: null, hidden_ms: 0 };

self.sonoglidePort = () => link.port;
self.sonoglideTell = (event) => self.postMessage({ event });
self.sonoglideNext = () => link.requests.shift();
self.sonoglideIsWaiting = () => link.requests.length > 0;
self.sonoglideSend = (bytes) => { const copy = bytes.slice(); self.postMessage({ send: copy }, [copy.buffer]); };
self.sonoglideNow = () => (link.hiddenSince ?? performance.now()) - link.hidden_ms;
self.sonoglideRandom = () => crypto.getRandomValues(new Uint32Array(1))[0];
self.sonoglideReceived = (count) => {
  const chunk = link.chunks.shift() ?? new Uint8Array();
  if (chunk.length > count) link.chunks.unshift(chunk.subarray(count));
  return chunk.subarray(0, count);
};

/** Returns the reason for which a wait ends at once; 0 if there is none. */
function reason() {
  if (link.interrupted) return INTERRUPTED;
  return link.chunks[0]?.length ?? (link.closed ? CLOSED : 0);
}

/** Resumes after the present messages; a timer would wait for at least 4 ms. */
const soon = new MessageChannel();
let due = null;
soon.port1.onmessage = () => { const call = due; due = null; call?.(); };

self.sonoglideWait = (time_ms) => new Promise((resolve) => {
  let timer = null, over = false;
  // While the page is hidden, nothing continues.
  const end = () => {
    if (over) return;
    if (link.hiddenSince !== null) { link.wake = end; return; }
    over = true;
    clearTimeout(timer);
    link.wake = null;
    const result = reason();
    link.interrupted = false;
    resolve(result);
  };
  link.wake = end;
  if (time_ms < 1 || reason() !== 0) { due = end; soon.port2.postMessage(null); } else timer = setTimeout(end, time_ms);
});

/** Returns imports in which a wait suspends the stack. */
function suspending(imports) {
  for (const functions of Object.values(imports)) for (const name of Object.keys(functions)) {
    if (name.includes("sonoglideWait")) functions[name] = new WebAssembly.Suspending(functions[name]);
  }
  return imports;
}
if (WebAssembly.Suspending) {
  const instantiate = WebAssembly.instantiate;
  WebAssembly.instantiate = (module, imports) => instantiate.call(WebAssembly, module, suspending(imports));
}

/** Messages of the page to the client; each is one of these. */
const messages = {
  async connect({ scene }) {
    link.port = scene ?? undefined;
    await WebAssembly.promising((await ready).connect)();
    self.close();
  },
  bytes(chunk) { link.chunks.push(chunk); link.wake?.(); },
  request(request) { link.requests.push(JSON.stringify(request)); },
  closed() { link.closed = true; link.wake?.(); },
  interrupt() { link.requests.length = 0; link.interrupted = true; link.wake?.(); },
  hidden(hidden) {
    if (hidden) link.hiddenSince ??= performance.now();
    else if (link.hiddenSince !== null) {
      link.hidden_ms += performance.now() - link.hiddenSince;
      link.hiddenSince = null;
      link.wake?.();
    }
  },
};
function linkMessage(data) {
  const name = Object.keys(messages).find((one) => one in data);
  return name ? Promise.resolve(messages[name](data[name])).catch((error) => self.postMessage({ lost: String(error) })) : null;
}
