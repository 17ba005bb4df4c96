// Decoder of LZMA, which packs the module to two thirds of the size of gzip.
//
// A file begins with 13 bytes: properties, size of the dictionary, and number of bytes. The rest is a
// range code of literals, matches and repeated matches (7-Zip, LZMA specification).

const FEW_BITS = 11, MOVE = 5, LEAST_RANGE = 2 ** 24;
const STATES = 12, POSITIONS = 16, FIRST_LITERAL_STATE = 7;
/** Number of distance slots with bits of their own, and first slot with direct bits. */
const SLOTS = 64, FIRST_MODEL_SLOT = 4, FIRST_DIRECT_SLOT = 14, ALIGN_BITS = 4;

const probabilities = (count) => new Uint16Array(count).fill(1 << (FEW_BITS - 1));

/** Range decoder of bits. */
class Bits {
  constructor(bytes, start) {
    this.bytes = bytes;
    this.range = 0xffffffff;
    this.code = 0;
    this.at = start + 1;
    for (let n = 0; n < 4; n += 1) this.code = ((this.code << 8) | bytes[this.at++]) >>> 0;
  }

  #fill() {
    this.range = (this.range << 8) >>> 0;
    this.code = ((this.code << 8) | this.bytes[this.at++]) >>> 0;
  }

  /** Returns a bit, and adapts its probability. */
  bit(table, place) {
    const chance = table[place], bound = (this.range >>> FEW_BITS) * chance, isZero = this.code < bound;
    if (isZero) {
      this.range = bound;
      table[place] = chance + (((1 << FEW_BITS) - chance) >>> MOVE);
    } else {
      this.range -= bound;
      this.code -= bound;
      table[place] = chance - (chance >>> MOVE);
    }
    if (this.range < LEAST_RANGE) this.#fill();
    return isZero ? 0 : 1;
  }

  /** Returns bits of equal probability. */
  direct(count) {
    let value = 0;
    for (let n = 0; n < count; n += 1) {
      this.range >>>= 1;
      const bit = this.code >= this.range ? 1 : 0;
      if (bit) this.code -= this.range;
      if (this.range < LEAST_RANGE) this.#fill();
      value = value * 2 + bit;
    }
    return value;
  }

  /** Returns bits of a tree, the highest first. */
  tree(table, count, offset = 0) {
    let place = 1;
    for (let n = 0; n < count; n += 1) place = (place << 1) | this.bit(table, offset + place);
    return place - (1 << count);
  }

  /** Returns bits of a tree, the lowest first. */
  reversed(table, count, offset = 0) {
    let place = 1, value = 0;
    for (let n = 0; n < count; n += 1) {
      const bit = this.bit(table, offset + place);
      place = (place << 1) | bit;
      value |= bit << n;
    }
    return value;
  }
}

/** Lengths of matches. */
class Lengths {
  choice = probabilities(2);
  low = probabilities(POSITIONS << 3);
  middle = probabilities(POSITIONS << 3);
  high = probabilities(256);

  next(bits, position) {
    if (!bits.bit(this.choice, 0)) return 2 + bits.tree(this.low, 3, position << 3);
    if (!bits.bit(this.choice, 1)) return 10 + bits.tree(this.middle, 3, position << 3);
    return 18 + bits.tree(this.high, 8);
  }
}

/** Unpacks a file of LZMA with a known number of bytes. */
export function unlzma(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const lc = bytes[0] % 9, lp = Math.floor(bytes[0] / 9) % 5, pb = Math.floor(bytes[0] / 45);
  const size = Number(view.getBigUint64(5, true)), out = new Uint8Array(size), bits = new Bits(bytes, 13);
  const literals = probabilities(0x300 << (lc + lp)), lengths = new Lengths(), repeatedLengths = new Lengths();
  const [isMatch, isRepeated0Long] = [probabilities(STATES * POSITIONS), probabilities(STATES * POSITIONS)];
  const [isRepeated, isRepeated0, isRepeated1, isRepeated2] = Array.from({ length: 4 }, () => probabilities(STATES));
  const slots = probabilities(4 * SLOTS), specials = probabilities(128), aligned = probabilities(1 << ALIGN_BITS);
  let state = 0, at = 0, back = [0, 0, 0, 0];
  const literal = () => {
    const previous = at > 0 ? out[at - 1] : 0, offset = 0x300 * (((at & ((1 << lp) - 1)) << lc) + (previous >>> (8 - lc)));
    let symbol = 1;
    if (state >= FIRST_LITERAL_STATE) {
      let match = out[at - back[0] - 1];
      do {
        const expected = (match >>> 7) & 1, bit = bits.bit(literals, offset + ((1 + expected) << 8) + symbol);
        match <<= 1;
        symbol = (symbol << 1) | bit;
        if (bit !== expected) break;
      } while (symbol < 0x100);
    }
    while (symbol < 0x100) symbol = (symbol << 1) | bits.bit(literals, offset + symbol);
    out[at++] = symbol;
    state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
  };
  const distance = (length) => {
    const slot = bits.tree(slots, 6, Math.min(length - 2, 3) << 6);
    if (slot < FIRST_MODEL_SLOT) return slot;
    const count = (slot >>> 1) - 1, base = (2 | (slot & 1)) * 2 ** count;
    if (slot < FIRST_DIRECT_SLOT) return base + bits.reversed(specials, count, base - slot);
    return base + bits.direct(count - ALIGN_BITS) * (1 << ALIGN_BITS) + bits.reversed(aligned, ALIGN_BITS);
  };
  while (at < size) {
    const position = at & ((1 << pb) - 1), both = state * POSITIONS + position;
    if (!bits.bit(isMatch, both)) { literal(); continue; }
    let length = 1;
    if (!bits.bit(isRepeated, state)) {
      length = lengths.next(bits, position);
      back = [distance(length), back[0], back[1], back[2]];
      state = state < FIRST_LITERAL_STATE ? 7 : 10;
    } else {
      // One of the last four distances; the most recent one also for a single byte.
      const nearest = !bits.bit(isRepeated0, state);
      if (nearest && !bits.bit(isRepeated0Long, both)) state = state < FIRST_LITERAL_STATE ? 9 : 11;
      else {
        if (!nearest) {
          const which = !bits.bit(isRepeated1, state) ? 1 : !bits.bit(isRepeated2, state) ? 2 : 3;
          back.unshift(...back.splice(which, 1));
        }
        length = repeatedLengths.next(bits, position);
        state = state < FIRST_LITERAL_STATE ? 8 : 11;
      }
    }
    for (let n = 0; n < length; n += 1, at += 1) out[at] = out[at - back[0] - 1];
  }
  return out;
}
