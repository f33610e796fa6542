// The section with the deformed shape: viewer, colour bar, controls, readings.

import {gradient} from './colormaps.js';
import {header} from './data.js';
import {element, newId} from './dom.js';
import {quantitiesOf} from './fields.js';
import {number, tickTexts, ticks, unit, power} from './format.js';
import {vector} from './tables.js';
import {Viewer} from './viewer.js';

const KEYS = 'Arrow keys turn, with Shift they move; + and − zoom; Home resets; Space plays.';

function select(label, options, onchange) {
  const id = newId('select');
  const box = element('select', {id, onchange: () => onchange(box.value)});
  const fill = (list) => {
    box.replaceChildren(...list.map(([value, text]) => element('option', {value}, text)));
  };
  fill(options);
  return {box, fill, row: element('div', {class: 'control'}, element('label', {for: id}, label), box)};
}

function toggle(label, on, onchange) {
  const id = newId('toggle');
  const box = element('input', {type: 'checkbox', id, onchange: () => onchange(box.checked)});
  box.checked = on;
  return {box, row: element('div', {class: 'toggle'}, box, element('label', {for: id}, label))};
}

export class ShapeSection {
  constructor(views, onView) {
    this.views = views;
    this.onView = onView;
    this.canvas = element('canvas', {
      tabindex: 0, role: 'img', 'aria-label': `Deformed shape. ${KEYS}`,
    });
    this.overlay = element('div', {class: 'overlay', 'aria-hidden': 'true'});
    this.tip = element('div', {class: 'tip', hidden: true, role: 'status'});
    this.barTitle = element('div', {class: 'bar-title'});
    this.barScale = element('div', {class: 'bar-scale'});
    this.bar = element('div', {class: 'bar', 'aria-label': 'Colour bar'}, this.barTitle,
                       this.barScale);
    this.stage = element('div', {class: 'stage'}, this.canvas, this.overlay, this.bar, this.tip);
    this.node = element('section', {id: 'shape', class: 'shape', 'aria-label': 'Deformed shape'});
    try {
      this.viewer = new Viewer(this.canvas, this.overlay);
    } catch (error) {
      this.viewer = null;
      this.node.append(element('p', {class: 'message', role: 'alert'},
        'The shape cannot be drawn: this browser offers no WebGL. All numbers, tables and plots ' +
        'are below; shell.pvd beside this file opens in ParaView.'));
      return;
    }
    this.build();
  }

  build() {
    const {viewer} = this;
    this.viewSelect = select('Shape', this.views.map((v, i) => [String(i), v.title]),
                             (value) => this.show(Number(value)));
    this.viewSelect.row.hidden = this.views.length < 2;
    this.fieldSelect = select('Colour', [], (value) => {
      viewer.setField(value, undefined);
      this.fillQuantities();
      this.refreshTime();
    });
    this.quantitySelect = select('Component', [], (value) => viewer.setField(viewer.field.name, value));
    this.rangeSelect = select('Range of colours', [
      ['all', 'all steps'], ['step', 'this step'], ['inner', 'this step, without 2 % extremes'],
    ], (value) => viewer.setField(viewer.field?.name, viewer.quantity?.key, value));

    const id = newId('magnification');
    this.factor = element('input', {
      type: 'number', id, min: 0, step: 'any', class: 'factor', onchange: () => {
        const value = Number(this.factor.value);
        if (Number.isFinite(value) && value >= 0) this.setMagnification(value);
      },
    });
    this.factorSlider = element('input', {
      type: 'range', min: 0, max: 200, step: 1, 'aria-label': 'Magnification of displacements',
      oninput: () => this.setMagnification(
          Number(((Number(this.factorSlider.value) / 100) * this.factorUnit).toPrecision(3))),
    });
    const magnification = element('div', {class: 'control'},
      element('label', {for: id}, 'Displacements enlarged'),
      element('div', {class: 'row'}, this.factorSlider, this.factor,
        element('button', {type: 'button', onclick: () => this.setMagnification(1)}, '1×')));

    this.toggles = {
      ghost: toggle('Undeformed shape', false, (on) => viewer.setOption('ghost', on)),
      mesh: toggle('Elements', false, (on) => viewer.setOption('mesh', on)),
      fingers: toggle('Fingers', true, (on) => viewer.setOption('fingers', on)),
      probes: toggle('Probes', true, (on) => viewer.setOption('probes', on)),
      cloud: toggle('Scan points', true, (on) => viewer.setOption('cloud', on)),
    };
    const views = [['Reset', null], ['+x', [1, 0, 0]], ['−x', [-1, 0, 0]], ['+y', [0, 1, 0]],
                   ['−y', [0, -1, 0]], ['+z', [0, 0, 1]], ['−z', [0, 0, -1]]];
    const buttons = views.map(([text, from]) => element('button', {
      type: 'button', title: from ? `Look from ${text}` : 'Look as at first',
      onclick: () => {
        if (from === null) viewer.resetCamera();
        else viewer.lookFrom(this.vector(from), from[2] !== 0 ? [0, 1, 0] : [0, 0, 1]);
      },
    }, text));
    const save = element('button', {type: 'button', onclick: () => this.save()}, 'Save picture');

    this.panel = element('div', {class: 'panel'}, this.viewSelect.row, this.fieldSelect.row,
      this.quantitySelect.row, this.rangeSelect.row, magnification,
      element('div', {class: 'toggles'}, ...Object.values(this.toggles).map((t) => t.row)),
      element('div', {class: 'views', role: 'group', 'aria-label': 'Camera'}, ...buttons, save),
      element('p', {class: 'hint'}, 'Drag to turn, right drag to move, wheel to zoom. Point at the ' +
        'shape to read it, click to keep the reading. ' + KEYS));

    this.play = element('button', {
      type: 'button', class: 'play', 'aria-label': 'Play the load steps', onclick: () => this.toggle(),
    }, '▶');
    this.slider = element('input', {
      type: 'range', min: 0, step: 1, 'aria-label': 'Load step', id: 'step',
      oninput: () => {
        this.stop();
        this.setStep(Number(this.slider.value));
      },
    });
    this.stepText = element('output', {for: 'step', class: 'step'});
    this.timeline = element('div', {class: 'timeline'}, this.play, this.slider, this.stepText);
    this.readings = element('div', {class: 'readings'});
    this.note = element('p', {class: 'hint', hidden: true});
    this.node.append(element('div', {class: 'shape-grid'},
      element('div', {}, this.stage, this.timeline, this.note), this.panel), this.readings);
    viewer.listeners.push(() => this.refreshBar());
    this.listen();
  }

  vector(from) {
    const {position} = this.viewer.camera;
    return position.clone().set(...from);
  }

  show(index) {
    if (!this.viewer) return;
    this.stop();
    const view = this.views[index];
    this.index = index;
    this.viewer.clearMarkers();
    this.viewer.rangeKind = this.rangeSelect.box.value;
    this.viewer.show(view);
    this.viewSelect.box.value = String(index);
    this.fieldSelect.fill(view.fields.map((f) => [f.name, f.label]));
    this.fieldSelect.row.hidden = view.fields.length === 0;
    this.rangeSelect.row.hidden = view.fields.length === 0;
    this.fillQuantities();
    const first = this.viewer.naturalMagnification();
    this.factorUnit = first;
    this.setMagnification(first);
    // What a fit is about is its error; the points would hide it.
    const showsScan = header.tool === 'darboux_scan' || view.fields.length === 0;
    this.toggles.cloud.box.checked = showsScan;
    this.viewer.setOption('cloud', showsScan);
    if (header.tool === 'darboux_fit' && view.fields.some((f) => f.name === 'scan_distance')) {
      this.viewer.setField('scan_distance');
      this.fillQuantities();
    }
    this.toggles.fingers.row.hidden = view.fingers.length === 0;
    this.toggles.probes.row.hidden = view.probes.length === 0;
    this.toggles.cloud.row.hidden = view.clouds.length === 0;
    this.toggles.ghost.row.hidden = view.steps.length < 2;
    this.slider.max = String(view.steps.length - 1);
    this.timeline.hidden = view.steps.length < 2;
    this.note.hidden = !(view.drawn < view.states);
    this.note.textContent = `${view.drawn} of ${view.states} load steps are drawn, evenly spread, to ` +
      'keep this file small; numbers and plots have all of them.';
    this.refreshTime();
    this.refreshReadings();
    this.onView(index);
  }

  fillQuantities() {
    const {field, quantity} = this.viewer;
    const list = field ? quantitiesOf(field) : [];
    this.quantitySelect.fill(list.map((q) => [q.key, q.label]));
    this.quantitySelect.row.hidden = list.length < 2;
    if (field) {
      this.fieldSelect.box.value = field.name;
      this.quantitySelect.box.value = quantity.key;
    }
  }

  setMagnification(value) {
    this.factor.value = String(value);
    this.factorSlider.value = String(Math.round((100 * value) / this.factorUnit));
    this.viewer.setMagnification(value);
  }

  // ---- Time ---------------------------------------------------------------------------------

  setStep(step) {
    this.viewer.setTime(step);
    this.refreshTime();
  }

  refreshTime() {
    const {time, view} = this.viewer;
    this.slider.value = String(Math.round(time));
    const step = view.steps[Math.round(time)];
    const load = step.number > 0 ? `, load factor ${number(step.factor, 4)}` : '';
    this.stepText.textContent = step.label + load;
    this.slider.setAttribute('aria-valuetext', this.stepText.textContent);
    this.refreshReadings();
  }

  toggle() {
    if (this.timer) this.stop();
    else this.start();
  }

  start() {
    const {viewer} = this;
    if (viewer.lastStep === 0) return;
    if (viewer.time >= viewer.lastStep) viewer.time = 0;
    // All steps in a few seconds, one by one.
    const seconds = Math.min(8, 1.5 + 0.25 * viewer.lastStep);
    const from = viewer.time;
    let begin = null;
    this.play.textContent = '❚❚';
    this.play.setAttribute('aria-label', 'Pause');
    const frame = (now) => {
      begin ??= now;
      const time = from + ((now - begin) / 1000) * (viewer.lastStep / seconds);
      this.setStep(Math.min(time, viewer.lastStep));
      if (time >= viewer.lastStep) this.stop();
      else this.timer = requestAnimationFrame(frame);
    };
    this.timer = requestAnimationFrame(frame);
  }

  stop() {
    if (!this.timer) return;
    cancelAnimationFrame(this.timer);
    this.timer = null;
    this.play.textContent = '▶';
    this.play.setAttribute('aria-label', 'Play the load steps');
    this.setStep(Math.round(this.viewer.time));
  }

  // ---- Colour bar ---------------------------------------------------------------------------

  refreshBar() {
    const {field, quantity, range, table} = this.viewer;
    this.bar.hidden = !field;
    if (!field) return;
    const name = quantity.label ? `${field.label}, ${quantity.label}` : field.label;
    const [low, high] = range;
    const at = high > low ? ticks(low, high, 5) : [low];
    const {texts, exponent} = tickTexts(at);
    this.barTitle.replaceChildren(element('b', {}, name), element('br'),
      (exponent !== 0 ? `${power(exponent)} × ` : '') + `[${unit(field.dimension, header.units)}]`);
    const strip = element('div', {class: 'strip'});
    strip.style.background = gradient(table, 'to right');
    const marks = at.map((value, i) => {
      const mark = element('span', {class: 'tick'}, texts[i]);
      mark.style.left = `${high > low ? (100 * (value - low)) / (high - low) : 50}%`;
      return mark;
    });
    this.barScale.replaceChildren(strip, element('div', {class: 'ticks'}, ...marks),
      element('div', {class: 'bar-range'}, element('span', {}, `min ${number(low, 4)}`),
              element('span', {}, `max ${number(high, 4)}`)));
  }

  // ---- Reading ------------------------------------------------------------------------------

  lines(place) {
    const {viewer} = this;
    const {rest, displacement, value} = viewer.read(place);
    const list = [];
    if (viewer.field) {
      const name = viewer.quantity.label ? `${viewer.field.label}, ${viewer.quantity.label}` :
                                           viewer.field.label;
      const none = value === null || Number.isNaN(value);
      list.push([name, none ? 'no value here' : number(value, 5)]);
    }
    if (displacement) list.push(['displacement', vector(displacement)]);
    list.push([displacement ? 'at rest at' : 'at', vector(rest)]);
    return list;
  }

  refreshReadings() {
    const {viewer} = this;
    if (viewer.readings.length === 0) {
      this.readings.replaceChildren();
      return;
    }
    const rows = viewer.readings.map(({place}, i) => element('tr', {},
      element('th', {scope: 'row'}, String(i + 1)),
      ...this.lines(place).map(([name, text]) => element('td', {}, element('span', {class: 'key'}, name),
                                                        ' ', text))));
    this.readings.replaceChildren(
      element('div', {class: 'row'}, element('h3', {}, 'Readings'),
        element('button', {type: 'button', onclick: () => {
          viewer.clearReadings();
          this.refreshReadings();
        }}, 'Clear')),
      element('div', {class: 'scroll'}, element('table', {}, element('tbody', {}, ...rows))));
  }

  listen() {
    const {canvas, viewer} = this;
    let down = null, pending = null;
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener('pointerdown', (event) => {
      down = place(event);
      this.tip.hidden = true;
    });
    canvas.addEventListener('pointerup', (event) => {
      const [x, y] = place(event);
      const still = down && Math.hypot(x - down[0], y - down[1]) < 4 && event.button === 0;
      down = null;
      if (!still) return;
      const found = viewer.pick(x, y);
      if (!found || viewer.readings.length >= 12) return;
      viewer.addReading(found);
      this.refreshReadings();
    });
    canvas.addEventListener('pointerleave', () => {
      this.tip.hidden = true;
    });
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons !== 0) return;
      const at = place(event);
      if (pending) {
        pending = at;
        return;
      }
      pending = at;
      requestAnimationFrame(() => {
        const [x, y] = pending;
        pending = null;
        this.hover(x, y);
      });
    });
    canvas.addEventListener('keydown', (event) => {
      const keys = {
        ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
      };
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key in keys) {
        const [x, y] = keys[event.key];
        if (event.shiftKey) viewer.pan(-0.04 * x, -0.04 * y);
        else viewer.turn(0.12 * x, 0.12 * y);
      } else if (event.key === '+' || event.key === '=') {
        viewer.zoom(0.87);
      } else if (event.key === '-') {
        viewer.zoom(1.15);
      } else if (event.key === 'Home') {
        viewer.resetCamera();
      } else if (event.key === ' ') {
        this.toggle();
      } else {
        return;
      }
      event.preventDefault();
    });
  }

  hover(x, y) {
    const found = this.viewer.pick(x, y);
    this.tip.hidden = !found;
    if (!found) return;
    this.tip.replaceChildren(...this.lines(found).map(([name, text]) => element('div', {},
      element('span', {class: 'key'}, name), ' ', text)));
    const {clientWidth, clientHeight} = this.stage;
    const left = x + 16 + this.tip.offsetWidth > clientWidth ? x - 12 - this.tip.offsetWidth : x + 16;
    const top = Math.min(y + 12, clientHeight - this.tip.offsetHeight - 4);
    this.tip.style.transform = `translate(${Math.max(0, left)}px, ${Math.max(0, top)}px)`;
  }

  save() {
    const link = element('a', {href: this.viewer.picture(), download: 'darboux.png'});
    link.click();
  }
}
