// The pictures of README.md's tour: runs the tools with --report, and takes a picture of each report.
//
//   node tools/tour/make_tour.mjs --tools=build/tools --work=build/tour [--out=data/tour]
//                                 [--only=NAME,NAME] [--reuse]
//
// Pictures are listed in pictures.json: `run` is the command as README.md has it, without --report
// and --out; `shot` the flags of tools/report/screenshot.mjs. Runs that several pictures share are
// made once; with --reuse those whose report is in --work already are not made again. PNGs get a
// palette where pngquant is installed, and stay as they are, three times as large, where it is not.
// `cmake --build build --target tour` runs it. Needs Node and Chromium (Debian: nodejs chromium
// pngquant) and tools that are built with the page of the reports.
//
// Exit status: 0 all pictures made; 1 something failed, said in one line; 2 bad command line.

import {execFileSync, spawnSync} from 'node:child_process';
import {existsSync, mkdirSync, readFileSync, renameSync, statSync} from 'node:fs';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const root = resolve(here, '../..');
const MOST_BYTES = 150e3;  // of a picture: all of them are cloned by everybody
const SIZE = ['--size=1200x800', '--scale=1'];

function fail(message, status = 1) {
  process.stderr.write(`make_tour.mjs: ${message}\n`);
  process.exit(status);
}

const flags = {tools: join(root, 'build/tools'), work: join(root, 'build/tour'), out: join(root, 'data/tour'),
               only: ''};
let reuse = false;
for (const word of process.argv.slice(2)) {
  if (word === '--reuse') {
    reuse = true;
    continue;
  }
  const [, name, value] = /^--([a-z]+)=(.+)$/.exec(word) ?? [];
  if (!(name in flags)) fail(`found '${word}'; allowed --${Object.keys(flags).join('=..., --')}=..., --reuse`, 2);
  flags[name] = name === 'only' ? value : resolve(value);
}
const pictures = JSON.parse(readFileSync(join(here, 'pictures.json'), 'utf8'));
const wanted = flags.only === '' ? pictures.map((picture) => picture.name) : flags.only.split(',');
for (const name of wanted) {
  if (!pictures.some((picture) => picture.name === name)) {
    fail(`--only: found '${name}'; allowed ${pictures.map((picture) => picture.name).join(', ')}`, 2);
  }
}

// The folder of the results. A tool that is not content with an answer says so with status 1, which
// no picture of the tour may have.
const folders = new Map();
function run(picture) {
  if (folders.has(picture.run)) return folders.get(picture.run);
  const [tool, ...words] = picture.run.split(' ');
  const folder = join(flags.work, picture.name);
  folders.set(picture.run, folder);
  if (reuse && existsSync(join(folder, 'report.html'))) return folder;
  const begin = Date.now();
  const result = spawnSync(join(flags.tools, tool), [...words, '--report', '--quiet', `--out=${folder}`],
                           {cwd: root, stdio: ['ignore', 'inherit', 'inherit']});
  if (result.status !== 0) fail(`${picture.run}: ends with ${result.status ?? result.error}`);
  console.log(`${picture.run}: ${((Date.now() - begin) / 1000).toFixed(1)} s`);
  return folder;
}

function shoot(picture, folder) {
  const raw = join(flags.work, `${picture.name}.png`);
  const words = picture.shot === '' ? [] : picture.shot.split(' ');
  const size = words.some((word) => word.startsWith('--size')) ? ['--scale=1'] : SIZE;
  try {
    execFileSync(process.execPath, [join(flags.tools, 'report/screenshot.mjs'), join(folder, 'report.html'),
                                    raw, ...size, ...words], {stdio: ['ignore', 'inherit', 'inherit']});
  } catch {
    fail(`${picture.name}: no picture of ${join(folder, 'report.html')}`);
  }
  const out = join(flags.out, `${picture.name}.png`);
  const result = spawnSync('pngquant', ['--force', '--strip', '--speed=1', '--quality=60-95', `--output=${out}`, raw]);
  if (result.status !== 0) {
    if (result.error === undefined) fail(`${picture.name}: pngquant ends with ${result.status}`);
    renameSync(raw, out);  // It is not installed.
  }
  const bytes = statSync(out).size;
  console.log(`  ${out}: ${(bytes / 1000).toFixed(0)} kB`);
  return bytes;
}

if (!existsSync(join(flags.tools, 'report/screenshot.mjs'))) {
  fail(`${flags.tools}: found no report/screenshot.mjs; allowed the folder of tools with the page of the reports`);
}
mkdirSync(flags.work, {recursive: true});
mkdirSync(flags.out, {recursive: true});
let total = 0;
for (const picture of pictures) {
  if (!wanted.includes(picture.name)) continue;
  const bytes = shoot(picture, run(picture));
  if (bytes > MOST_BYTES) console.log(`  that is much: install pngquant`);
  total += bytes;
}
console.log(`${wanted.length} picture${wanted.length === 1 ? '' : 's'}, ${(total / 1000).toFixed(0)} kB`);
