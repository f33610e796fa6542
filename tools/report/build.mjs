// Bundles page/ with its libraries into one HTML file and writes it as a C++ source file.
//
//   node build.mjs OUT.cc OUT.html
//
// The HTML has two marks, <!--darboux:title--> and <!--darboux:data-->, where tools/html_report.cc
// puts what it has to say. Its policy allows no request and no script but the bundle, by hash.

import {createHash} from 'node:crypto';
import {readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const [sourceFile, htmlFile] = process.argv.slice(2);

async function bundle(entry, loader) {
  const result = await build({
    entryPoints: [join(here, 'page', entry)],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: ['es2020'],
    charset: 'ascii',
    legalComments: 'inline',
    loader,
  });
  // What would end the element that holds it.
  return result.outputFiles[0].text.replaceAll('</script', '<\\/script').replaceAll('<!--', '<\\!--');
}

const script = await bundle('main.js', {});
const style = (await build({
  entryPoints: [join(here, 'page', 'style.css')], minify: true, write: false,
})).outputFiles[0].text;

const escape = (text) => text.replace(/[&<>]/g, (c) => ({'&': '&amp;', '<': '&lt;', '>': '&gt;'})[c]);
// The packages that are in the bundle, with their licences in full.
const packages = ['three', 'chart.js', '@kurkle/color'];
const notices = packages.map((name) => {
  const folder = join(here, 'node_modules', name);
  const {version, license} = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  const text = ['LICENSE', 'LICENSE.md'].map((file) => {
    try {
      return readFileSync(join(folder, file), 'utf8').trim();
    } catch {
      return '';
    }
  }).find((t) => t !== '');
  if (!text) throw new Error(`${name}: no licence text found`);
  return `${name} ${version} (${license})\n\n${text}`;
}).join('\n\n----\n\n');

const hash = createHash('sha256').update(script, 'utf8').digest('base64');
const replace = (text, mark, value) => {
  const parts = text.split(mark);
  if (parts.length !== 2) throw new Error(`page.html has ${parts.length - 1} times ${mark}`);
  return parts.join(value);
};
let html = readFileSync(join(here, 'page', 'page.html'), 'utf8');
html = replace(html, '@HASH@', `'sha256-${hash}'`);
html = replace(html, '@STYLE@', style);
html = replace(html, '@NOTICES@', escape(notices));
html = replace(html, '@SCRIPT@', script);
for (const mark of ['<!--darboux:title-->', '<!--darboux:data-->']) replace(html, mark, '');

// String literals are limited in length; every byte but plain ASCII is an octal escape.
const bytes = Buffer.from(html, 'utf8');
const parts = [];
for (let begin = 0; begin < bytes.length; begin += 16000) {
  let literal = '';
  for (const byte of bytes.subarray(begin, begin + 16000)) {
    const c = String.fromCharCode(byte);
    if (c === '\n') literal += '\\n';
    else if (c === '"' || c === '\\') literal += '\\' + c;
    else if (c === '?' || byte < 32 || byte > 126) literal += '\\' + byte.toString(8).padStart(3, '0');
    else literal += c;
  }
  parts.push(`    "${literal}"`);
}
writeFileSync(htmlFile, html);
writeFileSync(sourceFile, `// Made by tools/report/build.mjs.

#include <cstddef>

namespace darboux {

extern const char* const kReportPage[];
extern const std::size_t kReportPageParts;
const char* const kReportPage[] = {
${parts.join(',\n')}};
const std::size_t kReportPageParts = ${parts.length};

}  // namespace darboux
`);
console.log(`page: ${bytes.length} bytes`);
