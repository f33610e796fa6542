// A picture of a report, as PNG, by a headless Chromium.
//
//   node build/tools/report/screenshot.mjs REPORT.html OUT.png [flags]
//
//   --field=NAME[.COMPONENT]  what is coloured: displacement, membrane_strain, bending_strain,
//                             von_mises, energy_density, contact_pressure, scan_distance;
//                             COMPONENT as in the page, e.g. displacement.z, von_mises.top
//   --step=K                  the load step, from 0 (at rest); default: the last one drawn
//   --magnification=M         of the displacements; default: what the page chooses
//   --range=all|step|inner    of the colours
//   --view=K                  of the shapes in the report, from 0
//   --from=X,Y,Z              direction to look from; default: as the page
//   --zoom=F                  closer by this factor
//   --ghost --elements --scan show the undeformed shape, the elements, the points of a scan
//   --no-fingers --no-probes --no-scan
//   --only=shape|viewer|page|plots|numbers
//                             viewer (default): the shape with its colour bar; shape: with its
//                             controls; page: all of it; plots, numbers: that section
//   --size=WxH                of the window, default 1400x1000 (viewer: 1200x800)
//   --scale=S                 pixels per pixel, default 2
//   --dark                    the dark colours
//   --chromium=PROGRAM        default: the environment's CHROMIUM, or the one on the path
//
// Exit status: 0 done, 1 the page could not be shown, 2 bad command line.

import {pathToFileURL} from 'node:url';
import {existsSync} from 'node:fs';
import {withChromium} from './browser.mjs';

const FLAGS = {
  field: 'text', step: 'number', magnification: 'number', range: ['all', 'step', 'inner'], view: 'number',
  from: 'vector', zoom: 'number', ghost: 'bool', elements: 'bool', scan: 'bool', 'no-fingers': 'bool', 'no-probes': 'bool',
  'no-scan': 'bool', only: ['viewer', 'shape', 'page', 'plots', 'numbers'], size: 'size', scale: 'number',
  dark: 'bool', chromium: 'text',
};

function fail(message, status = 2) {
  process.stderr.write(`screenshot.mjs: ${message}\n`);
  process.exit(status);
}

function parse(words) {
  const flags = {only: 'viewer', scale: 2};
  const files = [];
  for (const word of words) {
    if (!word.startsWith('--')) {
      files.push(word);
      continue;
    }
    const [name, ...rest] = word.slice(2).split('=');
    const value = rest.join('=');
    const kind = FLAGS[name];
    if (!kind) fail(`found the unknown flag '--${name}'; allowed --${Object.keys(FLAGS).join(', --')}`);
    if (kind === 'bool') {
      flags[name] = true;
    } else if (kind === 'number') {
      flags[name] = Number(value);
      if (value === '' || !Number.isFinite(flags[name])) fail(`--${name}: found '${value}'; allowed a number`);
    } else if (kind === 'vector') {
      flags[name] = value.split(',').map(Number);
      if (flags[name].length !== 3 || !flags[name].every(Number.isFinite) || !flags[name].some((x) => x !== 0)) {
        fail(`--${name}: found '${value}'; allowed X,Y,Z, not all 0`);
      }
    } else if (kind === 'size') {
      flags[name] = value.split('x').map(Number);
      if (flags[name].length !== 2 || !flags[name].every((x) => Number.isInteger(x) && x > 0)) {
        fail(`--${name}: found '${value}'; allowed WIDTHxHEIGHT`);
      }
    } else if (Array.isArray(kind) && !kind.includes(value)) {
      fail(`--${name}: found '${value}'; allowed ${kind.join(' | ')}`);
    } else {
      flags[name] = value;
    }
  }
  if (files.length !== 2) fail('usage: screenshot.mjs REPORT.html OUT.png [flags]; flags are on top of its file');
  if (!existsSync(files[0])) fail(`${files[0]}: no such file`);
  return {flags, report: files[0], out: files[1]};
}

// In the page. Null, or what is wrong.
function prepare(flags) {
  const {viewer, shape, drawAllPlots} = window.darboux;
  drawAllPlots();
  if (flags.only === 'plots' || flags.only === 'numbers') return null;
  if (!viewer) return 'the page has no shape, or no WebGL';
  if (flags.view !== undefined) {
    if (!shape.views[flags.view]) return `--view: found ${flags.view}; allowed 0 to ${shape.views.length - 1}`;
    shape.show(flags.view);
  }
  if (flags.only === 'viewer') {
    // Over all the rest.
    const stage = viewer.canvas.parentElement;
    document.body.append(stage);
    stage.style.cssText = 'position: fixed; inset: 0; height: 100vh; border-radius: 0; z-index: 99';
    viewer.resize();
    viewer.resetCamera();
  }
  if (flags.field !== undefined) {
    const [name, component] = flags.field.split('.');
    const names = viewer.view.fields.map((f) => f.name);
    if (!names.includes(name)) return `--field: found '${name}'; allowed ${names.join(' | ')}`;
    viewer.setField(name, component, flags.range);
    if (component !== undefined && viewer.quantity.key !== component) {
      return `--field: found the component '${component}'; allowed ${
        [...shape.quantitySelect.box.options].map((o) => o.value).join(' | ') || 'none'}`;
    }
    shape.fillQuantities();
  } else if (flags.range !== undefined) {
    viewer.setField(viewer.field?.name, viewer.quantity?.key, flags.range);
  }
  if (flags.step !== undefined) {
    if (!(flags.step >= 0 && flags.step <= viewer.lastStep)) {
      return `--step: found ${flags.step}; allowed 0 to ${viewer.lastStep}`;
    }
    shape.setStep(flags.step);
  }
  if (flags.magnification !== undefined) shape.setMagnification(flags.magnification);
  const switches = {
    ghost: ['ghost', true], elements: ['mesh', true], scan: ['cloud', true], 'no-scan': ['cloud', false],
    'no-fingers': ['fingers', false], 'no-probes': ['probes', false],
  };
  for (const [flag, [name, on]] of Object.entries(switches)) {
    if (!flags[flag]) continue;
    viewer.setOption(name, on);
    shape.toggles[name].box.checked = on;
  }
  if (flags.from) {
    const along = flags.from[0] === 0 && flags.from[1] === 0;
    viewer.lookFrom(shape.vector(flags.from), along ? [0, 1, 0] : [0, 0, 1]);
  }
  if (flags.zoom) viewer.zoom(1 / flags.zoom);
  viewer.drawNow();
  return null;
}

const {flags, report, out} = parse(process.argv.slice(2));
const [width, height] = flags.size ?? (flags.only === 'viewer' ? [1200, 800] : [1400, 1000]);
try {
  const wrong = await withChromium({executable: flags.chromium, width, height, scale: flags.scale,
                                    dark: flags.dark}, async (context) => {
    const page = context.pages()[0] ?? await context.newPage();
    await page.goto(pathToFileURL(report).href);
    await page.waitForFunction(() => window.darboux?.ready > 0, null, {timeout: 60000});
    const message = await page.evaluate(prepare, flags);
    if (message !== null) return message;
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const element = {viewer: '.stage', shape: '#shape', plots: '#plots', numbers: '#numbers'}[flags.only];
    if (element) await page.locator(element).screenshot({path: out});
    else await page.screenshot({path: out, fullPage: true});
    return null;
  });
  if (wrong !== null) fail(wrong);
} catch (error) {
  fail(error.message, 1);
}
