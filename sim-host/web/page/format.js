// Formatting of numbers: four digits, thin spaces, a prefix of the unit.
const PREFIXES = [[1e-9, "n"], [1e-6, "µ"], [1e-3, "m"], [1, ""], [1e3, "k"], [1e6, "M"]];
const PREFIXED = new Set(["s", "m", "m/s", "N", "V", "A", "W", "N/m", "Nm"]);

/** Inserts thin spaces between thousands. */
export function grouped(text) {
  const [whole, part] = text.split(".");
  const spaced = whole.replace(/^-?\d{5,}$/, (digits) => digits.replace(/\B(?=(\d{3})+$)/g, "\u202f"));
  return (part === undefined ? spaced : `${spaced}.${part}`).replace("-", "\u2212");
}

/** Formats a number with `count` significant digits; longer integers are unchanged. */
export function digits(value, count = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size < -4 || size > 8) return value.toExponential(count - 1).replace("-", "\u2212");
  const text = value.toFixed(Math.max(0, Math.min(8, count - 1 - size)));
  return grouped(text.includes(".") ? text.replace(/\.?0+$/, "") : text);
}

/** Returns the most readable unit for values of this size, in units of the given one, and its name. */
export function prefixed(size, unit) {
  if (!PREFIXED.has(unit) || size === 0) return [1, unit];
  const [factor, prefix] = PREFIXES.findLast(([factor]) => size >= 0.9999 * factor) ?? PREFIXES[0];
  return [factor, `${prefix}${unit}`];
}

/** Formats a number with its unit, with the most readable prefix. */
export function quantity(value, unit, count = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const [factor, name] = prefixed(Math.abs(value), unit);
  return `${digits(value / factor, unit === "Hz" ? 8 : count)} ${name}`.trim();
}

/** Formats a number as in a scene's text. */
export const plain = (value) => String(Number(value.toPrecision(9)));
