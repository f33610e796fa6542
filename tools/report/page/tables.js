// Tables of a report's numbers.

import {element} from './dom.js';
import {number, words} from './format.js';

// What is but rounding beside the largest component is written as zero; the title has it.
export function vector(values, digits = 4) {
  const largest = Math.max(...values.map((x) => Math.abs(x ?? 0)));
  const show = (x) => (typeof x === 'number' && x !== 0 && Math.abs(x) < 1e-9 * largest ? '≈ 0' : number(x, digits));
  return `(${values.map(show).join(', ')})`;
}

export function cell(value) {
  if (value instanceof Node) return element('td', {}, value);
  if (typeof value === 'number' || value === null || value === undefined) {
    const text = number(value);
    return element('td', {class: 'number', title: typeof value === 'number' ? String(value) : null},
                   text);
  }
  if (typeof value === 'boolean') return element('td', {}, value ? 'yes' : 'no');
  if (Array.isArray(value)) {
    return element('td', {class: 'number', title: value.join(', ')}, vector(value));
  }
  return element('td', {class: String(value).length > 30 ? 'text' : null}, String(value));
}

// rows: arrays of values, the first of which names the row.
export function table(head, rows, caption) {
  const isNumber = (k) => k > 0 && rows.some((row) => typeof row[k] === 'number' || Array.isArray(row[k]));
  return element('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': caption},
    element('table', {},
      element('thead', {}, element('tr', {}, ...head.map((text, k) => element('th', {
        scope: 'col', class: isNumber(k) ? 'number' : null,
      }, text)))),
      element('tbody', {}, ...rows.map((row) => element('tr', {},
        element('th', {scope: 'row'}, row[0] instanceof Node ? row[0] : String(row[0])),
        ...row.slice(1).map(cell))))));
}

// Names on the left, values on the right.
export function pairs(rows, caption) {
  return element('div', {class: 'scroll', role: 'region', 'aria-label': caption},
    element('table', {class: 'pairs'}, element('tbody', {}, ...rows.map(([name, value]) => element(
      'tr', {}, element('th', {scope: 'row'}, name), cell(value))))));
}

// `wide`: over all columns, as tables of many columns are by themselves.
export function card(title, ...content) {
  return makeCard('card', title, content);
}
export function wideCard(title, ...content) {
  return makeCard('card wide', title, content);
}
function makeCard(className, title, content) {
  const parts = content.filter((part) => part !== null && part !== undefined);
  if (parts.length === 0) return null;
  return element('article', {class: className}, element('h3', {}, title), ...parts);
}

export function badge(kind, text) {
  return element('span', {class: `badge ${kind}`}, text);
}

export const xyz = (v) => (v === null || v === undefined ? null : [v.x, v.y, v.z]);

// Every number, text and truth of a document: its path and value.
function leaves(node, path, out) {
  if (node !== null && typeof node === 'object') {
    const entries = Object.entries(node);
    for (const [key, value] of entries) {
      const name = Array.isArray(node) ? `${path}[${key}]` : path === '' ? key : `${path}.${key}`;
      leaves(value, name, out);
    }
    if (entries.length === 0) out.push([path, Array.isArray(node) ? 'empty list' : 'empty']);
  } else {
    out.push([path, node]);
  }
}

// All of a document, hidden until asked for, with a filter. Rows are made when it is opened.
export function document_(name, content) {
  const rows = [];
  leaves(content, '', rows);
  const body = element('tbody');
  const shown = element('p', {class: 'hint', role: 'status'});
  const most = 2000;
  const fill = (filter) => {
    const found = rows.filter(([path]) => path.toLowerCase().includes(filter.toLowerCase()));
    body.replaceChildren(...found.slice(0, most).map(([path, value]) => element('tr', {},
      element('th', {scope: 'row'}, path),
      element('td', {class: 'number'}, value === null ? 'null' : String(value)))));
    shown.textContent = `${Math.min(found.length, most)} of ${rows.length} values`;
  };
  const input = element('input', {
    type: 'search', placeholder: 'filter, e.g. fingers', 'aria-label': `Filter ${name}`,
    oninput: () => fill(input.value),
  });
  const details = element('details', {class: 'card all', ontoggle: () => {
    if (details.open && body.childElementCount === 0) fill(input.value);
  }}, element('summary', {}, name), element('div', {class: 'row'}, input, shown),
    element('div', {class: 'scroll tall', tabindex: 0, role: 'region', 'aria-label': name},
      element('table', {class: 'pairs'}, body)));
  return details;
}

export const titled = (object) => Object.entries(object).map(([k, v]) => [words(k), v]);
