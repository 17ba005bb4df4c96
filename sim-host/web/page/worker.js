// The simulator in its worker: the module comes with the first message, requests follow one at a
// time.
"use strict";
self.sonoglideProgress = (reached) => self.postMessage({ progress: reached });
self.sonoglidePanic = (said) => self.postMessage({ panic: said });

let ready = null;
self.onmessage = async ({ data }) => {
  if (data.module) {
    ready = wasm_bindgen({ module_or_path: data.module });
    return;
  }
  if (linkMessage(data)) return;
  const { id, ask, argument, content } = data;
  try {
    await ready;
    self.postMessage({ id, answer: wasm_bindgen[ask](argument, content) });
  } catch (error) {
    self.postMessage({ id, lost: String(error) });
  }
};
