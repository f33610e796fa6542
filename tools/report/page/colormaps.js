// Colour maps of our own, perceptually uniform: paths in OKLab (B. Ottosson, 2020) along which equal
// steps of the value are equal distances in that space.

const TABLE = 256;

function oklabToLinear(L, a, b) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

// Lightness, chroma, hue in degrees; the chroma gives way where a screen has no such colour.
function inGamut(L, C, h) {
  const angle = (h * Math.PI) / 180;
  for (let chroma = C; ; chroma *= 0.97) {
    const lab = [L, chroma * Math.cos(angle), chroma * Math.sin(angle)];
    const rgb = oklabToLinear(...lab);
    if (chroma < 1e-3 || rgb.every((x) => x >= -1e-4 && x <= 1.0001)) {
      return {lab, rgb: rgb.map((x) => Math.min(1, Math.max(0, x)))};
    }
  }
}

const mix = (a, b, t) => a + (b - a) * t;

// Table of linear RGB and of OKLab along knots [L, C, h], evenly spaced by colour distance.
function tabulate(knots, count) {
  const fine = [];
  const parts = 400;
  for (let i = 0; i <= parts * (knots.length - 1); ++i) {
    const k = Math.min(Math.floor(i / parts), knots.length - 2);
    const t = i / parts - k;
    const smooth = (j) => mix(knots[k][j], knots[k + 1][j], t);
    fine.push(inGamut(smooth(0), smooth(1), smooth(2)));
  }
  const distance = [0];
  for (let i = 1; i < fine.length; ++i) {
    distance.push(distance[i - 1] +
                  Math.hypot(...fine[i].lab.map((x, j) => x - fine[i - 1].lab[j])));
  }
  const all = distance[distance.length - 1];
  const table = [];
  for (let i = 0, j = 0; i < count; ++i) {
    const at = (all * i) / (count - 1);
    while (j + 2 < distance.length && distance[j + 1] < at) ++j;
    const t = Math.min(1, Math.max(0, (at - distance[j]) / (distance[j + 1] - distance[j])));
    table.push({
      rgb: fine[j].rgb.map((x, k) => mix(x, fine[j + 1].rgb[k], t)),
      lab: fine[j].lab.map((x, k) => mix(x, fine[j + 1].lab[k], t)),
    });
  }
  return table;
}

// Violet to yellow; lightness rises evenly enough to be read in grey as well.
const SEQUENTIAL = [
  [0.27, 0.11, 303], [0.4, 0.125, 272], [0.55, 0.105, 226], [0.68, 0.115, 176], [0.8, 0.16, 138],
  [0.92, 0.175, 104],
];
// Blue, light grey, red: zero is in the middle, and both ends are equally dark.
const COLD = [[0.38, 0.15, 262], [0.6, 0.13, 254], [0.8, 0.065, 246], [0.94, 0.004, 240]];
const WARM = [[0.38, 0.15, 22], [0.6, 0.15, 30], [0.8, 0.085, 48], [0.94, 0.004, 60]];

export const sequential = tabulate(SEQUENTIAL, TABLE);
export const diverging = [...tabulate(COLD, TABLE / 2), ...tabulate(WARM, TABLE / 2).reverse()];
export const NO_VALUE = [0.3, 0.3, 0.3];  // linear grey

// Linear RGB at t in [0, 1], as three bytes would not do for materials that are lit.
export function lookUp(table, t, out, at) {
  const x = Math.min(1, Math.max(0, t)) * (table.length - 1);
  const i = Math.min(Math.floor(x), table.length - 2);
  const f = x - i;
  const a = table[i].rgb, b = table[i + 1].rgb;
  for (let k = 0; k < 3; ++k) out[at + k] = a[k] + (b[k] - a[k]) * f;
}

const encode = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
export const css = (rgb) => `rgb(${rgb.map(encode).join(' ')})`;

// A CSS gradient from low to high.
export function gradient(table, direction) {
  const stops = [];
  for (let i = 0; i <= 32; ++i) {
    stops.push(css(table[Math.round((i * (table.length - 1)) / 32)].rgb));
  }
  return `linear-gradient(${direction}, ${stops.join(', ')})`;
}
