// The report's page as its readers meet it, in a headless Chromium.
//
//   node report_page_test.mjs PAGE_FOLDER TOOLS_FOLDER DATA_FOLDER WORK_FOLDER CHROMIUM [--duck]
//
// PAGE_FOLDER: where the page is built, with screenshot.mjs and npm's packages. Solves scenes with
// the tools, opens their reports from disk, and exits with 1 where something is not as it should
// be; every line says what.

import {execFileSync} from 'node:child_process';
import {existsSync, mkdirSync, readFileSync, rmSync, statSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

const [pageFolder, tools, data, work, executable, ...rest] = process.argv.slice(2);
const {withChromium} = await import(pathToFileURL(join(pageFolder, 'browser.mjs')));

let failures = 0;
function check(holds, what) {
  console.log(`${holds ? 'ok     ' : 'FAILED '} ${what}`);
  if (!holds) ++failures;
}

function run(tool, ...words) {
  try {
    execFileSync(join(tools, tool), [...words, '--quiet', '--threads=1'], {
      cwd: work, stdio: ['ignore', 'ignore', 'pipe'],
    });
    return 0;
  } catch (error) {
    return error.status;
  }
}

const HOSTILE = '</script><script>window.hacked=1</script><img src=x onerror="window.hacked=2">&lt;';
const ball = (name, steps) => `name: ${JSON.stringify(name)}
surface: {kind: icosphere, radius: 20, frequency: 4}
shell: {thickness: 1.5, young_modulus: 4, poisson_ratio: 0.3}
model: {theory: nonlinear}
steps: ${steps}
supports:
  - {on: {near: [0, 0, 20], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -20], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: sphere, radius: 12}, position: [0, 0, 60], direction: [0, 0, -1], motion: {travel: 3}}
  - {name: bottom, shape: {kind: box, half_sizes: [6, 6, 3], rounding: 1}, position: [0, 0, -60], direction: [0, 0, 1], motion: {travel: 1}}
probes: [{name: side, at: {nearest: [20, 0, 0]}}]
expect: [{quantity: probes.side.displacement.x, value: 0, absolute_tolerance: 5}]
`;
const PLATE = (n) => `name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [${n}, ${n}]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}]
`;
const CALIBRATION = `name: ball
parameters: {young_modulus: {}}
grasps:
  - scene: ball.yaml
    scans: [scan/scan.csv]
    forces: [{finger: top, value: 2.0, error: 0.1}]
`;

// ---- What a page says and does ------------------------------------------------------------------

const LIMIT_MS = 2000;

// Chromium's own words about a processor that draws.
const OF_THE_BROWSER = /GL Driver Message|software WebGL|GPU stall/;

// Opens a report; calls use(page). Errors, warnings and requests count against it.
async function open(context, file, what, use) {
  const page = await context.newPage();
  const words = [], requests = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !OF_THE_BROWSER.test(message.text())) {
      words.push(message.text());
    }
  });
  page.on('pageerror', (error) => words.push(String(error)));
  page.on('request', (request) => requests.push(request.url()));
  const url = pathToFileURL(file).href;
  // From navigation to a page that answers; the least of three where the machine is busy.
  let ready = Infinity;
  for (let attempt = 0; attempt < 3 && ready >= LIMIT_MS; ++attempt) {
    await page.goto(url);
    await page.waitForFunction(() => window.darboux?.ready > 0, null, {timeout: 30000});
    ready = Math.min(ready, await page.evaluate(() => window.darboux.ready));
  }
  try {
    await use(page, ready);
  } finally {
    await page.close();
  }
  check(words.length === 0, `${what}: no error and no warning in the console ${words.join(' | ')}`);
  const others = requests.filter((r) => r !== url && !r.startsWith('data:'));
  check(others.length === 0, `${what}: no request ${others.join(' ')}`);
}

// The picture of the shape: parts of pixels that are not the background, and number of colours.
async function pixels(page) {
  const bytes = await page.locator('.stage canvas').screenshot();
  return page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const {data} = context.getImageData(0, 0, image.width, image.height);
    const colors = new Set();
    let saturated = 0, hash = 0;
    for (let i = 0; i < data.length; i += 4) {
      colors.add((data[i] >> 4) << 8 | (data[i + 1] >> 4) << 4 | data[i + 2] >> 4);
      const high = Math.max(data[i], data[i + 1], data[i + 2]);
      if (high - Math.min(data[i], data[i + 1], data[i + 2]) > 40) ++saturated;
      hash = (hash * 31 + data[i] + 7 * data[i + 1] + 13 * data[i + 2]) | 0;
    }
    return {colors: colors.size, saturated: (4 * saturated) / data.length, hash};
  }, bytes.toString('base64'));
}

const state = (page) => page.evaluate(() => {
  const {viewer} = window.darboux;
  const sum = (values) => values.reduce((total, x, i) => total + x * ((i % 97) + 1), 0);
  return {
    positions: sum(viewer.positions.array), colors: sum(viewer.colors.array), time: viewer.time,
    camera: sum(viewer.camera.position.toArray()), range: viewer.range,
    fingers: viewer.fingers.meshes.map((m) => m.position.z),
  };
});

const frames = (page) => page.evaluate(() => new Promise((done) => {
  requestAnimationFrame(() => requestAnimationFrame(done));
}));

async function testBall(context) {
  const summary = JSON.parse(readFileSync(join(work, 'ball', 'summary.json'), 'utf8'));
  await open(context, join(work, 'ball', 'report.html'), 'ball', async (page, ready) => {
    check(ready < LIMIT_MS, `ball: ready after ${Math.round(ready)} ms`);
    const first = await pixels(page);
    check(first.colors > 50 && first.saturated > 0.05,
          `ball: the shape is there: ${first.colors} colours, ${(100 * first.saturated).toFixed(1)} % coloured`);

    // A name with markup in it is a name.
    check(await page.evaluate(() => window.hacked) === undefined, 'ball: a hostile name runs nothing');
    check(await page.locator('h1').textContent() === HOSTILE, 'ball: a hostile name is shown as it is');
    check(await page.locator('img').count() === 0, 'ball: a hostile name makes no element');

    // The slider moves the mesh and the fingers.
    const loaded = await state(page);
    await page.locator('#step').focus();
    await page.keyboard.press('Home');
    await frames(page);
    const rest = await state(page);
    const restPixels = await pixels(page);
    check(rest.time === 0 && rest.positions !== loaded.positions, 'ball: the slider moves the vertices');
    check(restPixels.hash !== first.hash, 'ball: the slider changes the picture');
    check(Math.abs(rest.fingers[0] - loaded.fingers[0] - 3) < 1e-9 &&
          Math.abs(rest.fingers[1] - loaded.fingers[1] + 1) < 1e-9, 'ball: the fingers travel');
    await page.keyboard.press('End');
    await frames(page);
    check((await state(page)).positions === loaded.positions, 'ball: and back again');
    check((await page.locator('output.step').textContent()).includes('load factor 1'),
          'ball: the load step is named');

    // Fields, one by one.
    const seen = new Set([loaded.colors]);
    const names = await page.locator('.panel select').nth(1).locator('option').evaluateAll(
      (options) => options.map((o) => o.value));
    for (const name of ['displacement', 'membrane_strain', 'bending_strain', 'von_mises', 'energy_density',
                        'contact_pressure']) {
      check(names.includes(name), `ball: there is ${name}`);
      await page.locator('.panel select').nth(1).selectOption(name);
      await frames(page);
      const {colors, range} = await state(page);
      check((name === 'displacement') === seen.has(colors), `ball: ${name} has colours of its own`);
      check(range[1] > range[0], `ball: ${name} is in [${range.map((x) => x.toPrecision(3))}]`);
      check(await page.locator('.tick').count() >= 2, `ball: ${name} has a bar with ticks`);
      seen.add(colors);
    }
    await page.locator('.panel select').nth(1).selectOption('displacement');
    await page.locator('.panel select').nth(2).selectOption('z');
    await frames(page);
    const z = await state(page);
    check(z.range[0] === -z.range[1], 'ball: a signed field has zero in the middle');
    await page.locator('.panel select').nth(2).selectOption('x');

    // A reading under the probe is what the summary says of it.
    const read = await page.evaluate(() => {
      const {viewer} = window.darboux;
      viewer.lookFrom(viewer.camera.position.clone().set(1, 0, 0.001));
      viewer.drawNow();
      const p = viewer.probes[0].dot.position.clone().project(viewer.camera);
      const box = viewer.canvas.getBoundingClientRect();
      const at = [(0.5 + 0.5 * p.x) * box.width, (0.5 - 0.5 * p.y) * box.height];
      return {at: [box.left + at[0], box.top + at[1]], value: viewer.read(viewer.pick(...at)).value};
    });
    const expected = summary.probes.side.displacement.x;
    check(Math.abs(read.value - expected) < 2e-3 * Math.abs(expected),
          `ball: reads ${read.value} at the probe, summary.json has ${expected}`);
    await page.mouse.move(read.at[0] + 1, read.at[1]);
    await frames(page);
    check(await page.locator('.tip').isVisible(), 'ball: pointing at the shape shows what is there');
    await page.mouse.down();
    await page.mouse.up();
    check(await page.locator('.readings tbody tr').count() === 1, 'ball: a click keeps the reading');

    // The rest of the controls.
    const before = await state(page);
    const plain = await pixels(page);
    await page.locator('.stage canvas').focus();
    await page.keyboard.press('ArrowLeft');
    await frames(page);
    check((await state(page)).camera !== before.camera, 'ball: arrow keys turn');
    for (const label of ['Undeformed shape', 'Elements', 'Fingers']) {
      const one = await pixels(page);
      await page.getByRole('checkbox', {name: label}).click();
      await frames(page);
      check((await pixels(page)).hash !== one.hash, `ball: ${label} changes the picture`);
    }
    await page.locator('.factor').fill('3');
    await page.locator('.factor').press('Enter');
    await frames(page);
    check((await state(page)).positions !== before.positions, 'ball: displacements are enlarged');
    check((await pixels(page)).hash !== plain.hash, 'ball: and seen to be');
    await page.getByLabel('Play the load steps').click();
    await page.waitForFunction(() => window.darboux.viewer.time < window.darboux.viewer.lastStep);
    await page.waitForFunction(() => window.darboux.viewer.time === window.darboux.viewer.lastStep, null,
                               {timeout: 20000});
    check(true, 'ball: plays to the end');

    // Numbers and plots.
    const text = await page.locator('#numbers').textContent();
    const force = summary.fingers.top.normal_force;
    check(text.includes(force.toPrecision(4).replace(/0+$/, '')), `ball: the force ${force} is in a table`);
    check(text.includes('Expectations') && text.includes('holds'), 'ball: expectations are listed');
    const effects = await page.locator('#effects').textContent();
    check(effects.includes('geometric nonlinearity') && effects.includes('no finger has friction'),
          'ball: effects have reasons');
    await page.evaluate(() => window.darboux.drawAllPlots());
    const titles = await page.locator('.plot h3').allTextContents();
    for (const title of ['Force against travel', 'Convergence', 'Energies', 'Load against displacement']) {
      check(titles.includes(title), `ball: there is the plot ${title}`);
    }
    const blank = await page.locator('.plot canvas').evaluateAll((list) => list.filter((canvas) => {
      const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      return !data.some((x) => x !== 0);
    }).length);
    check(blank === 0, 'ball: no plot is blank');
    await page.locator('#all summary').click();
    await page.getByRole('searchbox').fill('normal_force');
    check(await page.locator('#all tbody tr').count() === 2, 'ball: all numbers can be filtered');

    // Dark.
    const light = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    await page.emulateMedia({colorScheme: 'dark'});
    check(await page.evaluate(() => getComputedStyle(document.body).backgroundColor) !== light,
          'ball: dark where the reader prefers that');
    // Narrow.
    await page.setViewportSize({width: 390, height: 800});
    await frames(page);
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    check(width <= 390, `ball: fits a narrow window (${width})`);
  });
}

async function testLarge(context, name, triangles, limit) {
  const file = join(work, name, 'report.html');
  const size = statSync(file).size;
  check(size < limit, `${name}: ${(size / 1e6).toFixed(2)} MB`);
  await open(context, file, name, async (page, ready) => {
    check(ready < LIMIT_MS, `${name}: ready after ${Math.round(ready)} ms`);
    const count = await page.evaluate(() => window.darboux.viewer.triangles.length / 3);
    check(count >= triangles, `${name}: ${count} triangles`);
    const picture = await pixels(page);
    check(picture.saturated > 0.05, `${name}: the shape is there`);
    const ms = await page.evaluate(() => {
      const begin = performance.now();
      window.darboux.shape.setStep(0);
      window.darboux.shape.setStep(1);
      return 0.5 * (performance.now() - begin);
    });
    check(ms < 250, `${name}: a step takes ${ms.toFixed(0)} ms`);
  });
}

// Reports of the other tools: a shape where there is one, their numbers and plots.
async function testTool(context, name, {shape, texts, plots}) {
  await open(context, join(work, name, 'report.html'), name, async (page, ready) => {
    check(ready < LIMIT_MS, `${name}: ready after ${Math.round(ready)} ms`);
    if (shape) {
      const picture = await pixels(page);
      check(picture.colors > 20, `${name}: the shape is there, ${picture.colors} colours`);
    }
    const all = await page.locator('main').textContent();
    for (const text of texts) check(all.includes(text), `${name}: says ${text}`);
    await page.evaluate(() => window.darboux.drawAllPlots());
    const titles = await page.locator('.plot h3').allTextContents();
    for (const title of plots) check(titles.includes(title), `${name}: there is the plot ${title}`);
    const empty = await page.evaluate(() => [...document.querySelectorAll('main td, main th')].filter(
      (cell) => /NaN|undefined|\[object/.test(cell.textContent)).map((cell) => cell.textContent));
    check(empty.length === 0, `${name}: no cell is nonsense ${empty.join(' | ')}`);
  });
}

function testPicture() {
  const script = join(pageFolder, 'screenshot.mjs');
  const shoot = (...words) => {
    try {
      execFileSync(process.execPath, [script, ...words, `--chromium=${executable}`],
                   {stdio: ['ignore', 'ignore', 'pipe']});
      return {status: 0, said: ''};
    } catch (error) {
      return {status: error.status, said: String(error.stderr)};
    }
  };
  const out = join(work, 'picture.png');
  const report = join(work, 'ball', 'report.html');
  check(shoot(report, out, '--field=von_mises.top', '--step=1', '--elements', '--size=400x300',
              '--scale=1').status === 0, 'picture: made');
  const png = existsSync(out) ? readFileSync(out) : Buffer.alloc(24);
  check(png.readUInt32BE(16) === 400 && png.readUInt32BE(20) === 300, 'picture: of the size asked for');
  const wrong = shoot(report, out, '--field=colour');
  check(wrong.status === 2 && wrong.said.includes("found 'colour'; allowed displacement |"),
        'picture: an unknown field is one clear error');
  check(shoot(report, out, '--sise=1x1').status === 2, 'picture: an unknown flag is an error');
}

// ---- Main ---------------------------------------------------------------------------------------

rmSync(work, {recursive: true, force: true});
mkdirSync(work, {recursive: true});
const options = {executable, width: 1000, height: 700};
if (rest.includes('--duck')) {
  check(run('darboux_deform', join(data, 'duck.yaml'), '--out=duck', '--report') === 0, 'duck: solved');
  await withChromium(options, (context) => testLarge(context, 'duck', 20000, 10e6));
} else {
  writeFileSync(join(work, 'hostile.yaml'), ball(HOSTILE, 3));
  writeFileSync(join(work, 'ball.yaml'), ball('ball', 1));
  writeFileSync(join(work, 'plate.yaml'), PLATE(6));
  writeFileSync(join(work, 'fine.yaml'), PLATE(80));
  writeFileSync(join(work, 'calibration.yaml'), CALIBRATION);
  check(run('darboux_deform', 'hostile.yaml', '--out=ball', '--report') === 0, 'ball: solved');
  check(run('darboux_deform', 'fine.yaml', '--out=fine', '--report') === 0, 'fine: solved');
  check(run('darboux_accuracy', 'plate.yaml', '--out=accuracy', '--report', '--levels=3',
            '--sweep=resolution,quadrature') === 0, 'accuracy: done');
  check(run('darboux_scan', 'ball.yaml', '--out=scan', '--report', '--noise=0.01', '--points=1500',
            '--outliers=0.01') === 0, 'scan: done');
  check(run('darboux_fit', 'ball.yaml', '--scan=scan/scan.csv', '--out=fit', '--report') <= 1, 'fit: done');
  check(run('darboux_calibrate', 'calibration.yaml', '--out=calibration', '--report') <= 1,
        'calibration: done');
  await withChromium(options, async (context) => {
    await testBall(context);
    await testLarge(context, 'fine', 50000, 10e6);
    await testTool(context, 'accuracy', {
      shape: true, texts: ['Cheapest settings', 'Reference'],
      plots: ['Error against unknowns', 'Error against time'],
    });
    await testTool(context, 'scan', {
      shape: true, texts: ['Frame of the scanner', 'strays'], plots: ['Force against travel']});
    await testTool(context, 'fit', {
      shape: true, texts: ['scan distance', 'Registration', 'Distances of the scan'],
      plots: ['Distances of the inliers', 'Choice of the weight'],
    });
    await testTool(context, 'calibration', {
      shape: true, texts: ['Young’s modulus', 'Forces', 'Scans', 'Errors that are shared'],
      plots: ['Forces, read and computed', 'Distances of the scans'],
    });
  });
  // Without WebGL everything else is there.
  await withChromium({...options, args: ['--disable-3d-apis']}, (context) => open(
    context, join(work, 'ball', 'report.html'), 'without WebGL', async (page) => {
      check(await page.getByRole('alert').isVisible(), 'without WebGL: says so');
      check(await page.locator('#numbers table').count() > 3, 'without WebGL: tables are there');
      check(await page.locator('.plot canvas').count() > 3, 'without WebGL: plots are there');
    }));
  testPicture();
}
console.log(failures === 0 ? 'all is as it should be' : `${failures} failures`);
process.exit(failures === 0 ? 0 : 1);
