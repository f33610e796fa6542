// Elements without markup: text from a scene is only ever text.

// element('td', {class: 'number', onclick: f}, 'text', child, ...)
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith('on')) node.addEventListener(key.slice(2), value);
    else node.setAttribute(key, value === true ? '' : String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

let numIds = 0;
export const newId = (name) => `${name}-${++numIds}`;

export function colorOf(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
