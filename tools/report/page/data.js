// What the tool has written into this page: a header in JSON and arrays in base64, which are
// decoded when somebody asks for them. Format: solver/report_arrays.h, solver/report_view.h.

export const header = JSON.parse(document.getElementById('darboux-header').textContent);

function decode(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

const NO_VALUE = 65535;

// Float32Array or Uint32Array, components side by side; NaN where there is no value.
export function readArray(info) {
  const length = info.count * info.components;
  if (info.type === 'u16' && info.blob === null) {
    const values = new Float32Array(length);
    for (let i = 0; i < length; ++i) values[i] = info.offset[i % info.components];
    return values;
  }
  const bytes = decode(document.getElementById(`darboux-${info.blob}`).textContent);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (info.type === 'u32') {
    const values = new Uint32Array(length);
    for (let i = 0; i < length; ++i) values[i] = view.getUint32(4 * i, true);
    return values;
  }
  const values = new Float32Array(length);
  if (info.type === 'f32') {
    for (let i = 0; i < length; ++i) values[i] = view.getFloat32(4 * i, true);
    return values;
  }
  for (let i = 0; i < length; ++i) {
    const code = view.getUint16(2 * i, true);
    const k = i % info.components;
    values[i] = code === NO_VALUE ? NaN : info.offset[k] + info.scale[k] * code;
  }
  return values;
}

// Reads each array once, and keeps the last few.
export class Cache {
  constructor(most) {
    this.most = most;
    this.kept = new Map();
  }
  read(info) {
    const found = this.kept.get(info);
    if (found) {
      this.kept.delete(info);
      this.kept.set(info, found);
      return found;
    }
    const values = readArray(info);
    this.kept.set(info, values);
    if (this.kept.size > this.most) this.kept.delete(this.kept.keys().next().value);
    return values;
  }
}
