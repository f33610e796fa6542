// Numbers and units as text.

const SUPERSCRIPT = '⁰¹²³⁴⁵⁶⁷⁸⁹';

export function power(exponent) {
  const digits = String(Math.abs(exponent)).split('').map((d) => SUPERSCRIPT[Number(d)]).join('');
  return `10${exponent < 0 ? '⁻' : ''}${digits}`;
}

// `digits` significant digits; powers of ten where the number would be long.
export function number(value, digits = 5) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (typeof value !== 'number') return String(value);
  if (!Number.isFinite(value)) return value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e7) return minus(group(String(value)));
  const exponent = Math.floor(Math.log10(size));
  if (exponent < -4 || exponent >= 6) {
    let [mantissa, e] = value.toExponential(digits - 1).split('e');
    mantissa = mantissa.replace(/\.?0+$/, '');
    return minus(`${mantissa} × ${power(Number(e))}`);
  }
  let text = value.toPrecision(digits);
  if (text.includes('e')) text = String(Number(text));
  if (text.includes('.')) text = text.replace(/\.?0+$/, '');
  return minus(text);
}

const minus = (text) => text.replace(/^-/, '−');
const group = (text) => text.replace(/\B(?=(\d{3})+(?!\d))/g, ' ');

export const percent = (value, digits = 3) =>
  value === null || value === undefined ? '–' : `${number(100 * value, digits)} %`;

export function seconds(value) {
  if (value === null || value === undefined || value < 0) return '–';
  if (value >= 100) return `${value.toFixed(0)} s`;
  return value >= 1 ? `${value.toFixed(2)} s` : `${number(1000 * value, 3)} ms`;
}

// What a number is measured in. Scenes are in any consistent system of units, which they do not
// name.
const DIMENSIONS = {
  '1': 'no unit',
  'length': 'length',
  '1/length': '1 / length',
  'force': 'force',
  'force/length^2': 'force / length²',
  'energy/length^2': 'energy / length²',
  'energy': 'energy',
};
export function unit(dimension, known = {}) {
  if (dimension === '1') return DIMENSIONS['1'];
  if (dimension === 'length' && known.length) return known.length;
  if (dimension === '1/length' && known.length) return `1 / ${known.length}`;
  return `${DIMENSIONS[dimension] ?? dimension}, scene units`;
}

// Round numbers in [low, high], about `count` of them.
export function ticks(low, high, count = 6) {
  if (!(high > low)) return [low];
  const raw = (high - low) / count;
  const size = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * size).find((s) => s >= raw * 0.999) ?? 10 * size;
  const list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) list.push(k * step);
  return list;
}

// Ticks as text with a power of ten in common: {texts, exponent}; 0: none.
export function tickTexts(values) {
  const largest = Math.max(...values.map(Math.abs));
  if (!(largest > 0)) return {texts: values.map(() => '0'), exponent: 0};
  let exponent = 3 * Math.floor(Math.log10(largest * 1.0000001) / 3);
  if (exponent === 0 || (largest >= 0.1 && largest < 1e4)) exponent = 0;
  const scaled = values.map((v) => v / 10 ** exponent);
  const step = scaled.length > 1 ? Math.abs(scaled[1] - scaled[0]) : Math.abs(scaled[0]);
  const digits = Math.min(6, Math.max(0, -Math.floor(Math.log10(step) + 1e-9) + (isRound(step) ? 0 : 1)));
  return {texts: scaled.map((v) => minus((Math.abs(v) < 1e-12 ? 0 : v).toFixed(digits))), exponent};
}
const isRound = (step) => {
  const mantissa = step / 10 ** Math.floor(Math.log10(step) + 1e-9);
  return Math.abs(mantissa - Math.round(mantissa)) < 1e-6;
};

// "largest_pressure" -> "largest pressure"
const NAMES = {young_modulus: 'Young’s modulus', poisson_ratio: 'Poisson’s ratio'};
export const words = (name) => NAMES[name] ?? String(name).replaceAll('_', ' ');
