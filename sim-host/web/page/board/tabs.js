// Several tabs of the page: one holds the board, the others watch it and can stop it.

/** Time without a word of the holder after which it has left, ms. */
const GONE_MS = 2000;
/** Shortest time between two words to the other tabs, ms. */
const WORD_MS = 100;

export class Tabs {
  #channel = new BroadcastChannel("sonoglide-board");
  #spoken = 0;
  #gone = null;

  constructor({ onreport, onstop }) {
    this.#channel.onmessage = ({ data: { report, name, stop } }) => {
      if (stop) return onstop();
      clearTimeout(this.#gone);
      onreport(report, name);
      if (name !== null) this.#gone = setTimeout(() => onreport(null, null), GONE_MS);
    };
  }

  /** Tells the other tabs that this one holds the board. */
  hold(report, name) {
    if (performance.now() - this.#spoken < WORD_MS) return;
    this.#spoken = performance.now();
    this.#channel.postMessage({ report, name });
  }

  release() { this.#channel.postMessage({ report: null, name: null }); }

  /** Asks the tab that holds the board to stop its drive. */
  stop() { this.#channel.postMessage({ stop: true }); }
}
