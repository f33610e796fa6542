// What of a field can be looked at: its components and what follows from them.

const principal = (which) => (v, n) => {
  const out = new Float32Array(n);
  for (let i = 0; i < n; ++i) {
    const a = v[3 * i], b = v[3 * i + 1], c = v[3 * i + 2];
    out[i] = 0.5 * (a + b) + which * Math.hypot(0.5 * (a - b), c);
  }
  return out;
};
const component = (k, of) => (v, n) => {
  if (of === 1) return v;
  const out = new Float32Array(n);
  for (let i = 0; i < n; ++i) out[i] = v[of * i + k];
  return out;
};
const combine = (of, f) => (v, n) => {
  const out = new Float32Array(n);
  for (let i = 0; i < n; ++i) out[i] = f(...v.subarray(of * i, of * i + of));
  return out;
};

const DERIVED = {
  displacement: {before: [['magnitude', false, combine(3, (x, y, z) => Math.hypot(x, y, z))]]},
  membrane_strain: {before: [['larger principal', true, principal(1)],
                             ['smaller principal', true, principal(-1)]]},
  bending_strain: {before: [['larger principal', true, principal(1)],
                            ['smaller principal', true, principal(-1)]]},
  von_mises: {before: [['larger of both faces', false, combine(2, Math.max)]]},
  // Where nothing touches there is no pressure to be coloured.
  contact_pressure: {own: () => (v) => v.map((p) => (p > 0 ? p : NaN))},
  energy_density: {before: [['total', false, combine(2, (a, b) => a + b)]]},
};

// [{key, label, signed, compute(values, points) -> Float32Array}]
export function quantitiesOf(field) {
  const derived = DERIVED[field.name]?.before ?? [];
  const own = field.components.map((name, k) => [
    name, field.signed, (DERIVED[field.name]?.own ?? component)(k, field.components.length),
  ]);
  return [...derived, ...own].map(([label, signed, compute]) => ({
    key: label.replaceAll(' ', '_'), label, signed, compute,
  }));
}

// Lowest and highest finite value; null where there is none.
export function rangeOf(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : null;
}

// Without the lowest and highest `part` of the values.
export function innerRangeOf(values, part) {
  const sorted = Float32Array.from(values.filter((v) => !Number.isNaN(v))).sort();
  if (sorted.length === 0) return null;
  const cut = Math.floor(part * sorted.length);
  return [sorted[cut], sorted[sorted.length - 1 - cut]];
}

export function merge(a, b) {
  if (a === null || b === null) return a ?? b;
  return [Math.min(a[0], b[0]), Math.max(a[1], b[1])];
}
