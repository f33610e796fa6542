// A headless Chromium for those that look at reports: screenshot.mjs and the tests.

import {existsSync, mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {delimiter, join} from 'node:path';
import {chromium} from 'playwright-core';

const NAMES = ['chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable'];

// The program: the one given, that of the environment's CHROMIUM, or the first one on the path.
export function findChromium(given) {
  const asked = given || process.env.CHROMIUM;
  if (asked) return asked;
  for (const folder of (process.env.PATH ?? '').split(delimiter)) {
    for (const name of NAMES) {
      if (existsSync(join(folder, name))) return join(folder, name);
    }
  }
  throw new Error(`no Chromium: none of ${NAMES.join(', ')} is on the path`);
}

// Starts it with a profile of its own; WebGL runs on the processor, so that any machine will do.
// Calls `use(context)` and closes it, whatever happens.
export async function withChromium({executable, width = 1400, height = 1000, scale = 1, dark = false,
                                    args = []}, use) {
  const profile = mkdtempSync(join(tmpdir(), 'darboux-report-'));
  let context = null;
  try {
    context = await chromium.launchPersistentContext(profile, {
      executablePath: findChromium(executable),
      headless: true,
      viewport: {width, height},
      deviceScaleFactor: scale,
      colorScheme: dark ? 'dark' : 'light',
      args: ['--no-sandbox', '--disable-quic', '--no-first-run',
             '--disable-background-networking', '--disable-component-update', '--disable-sync',
             '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
             ...args],
    });
    return await use(context);
  } finally {
    if (context !== null) await context.close();
    rmSync(profile, {recursive: true, force: true, maxRetries: 5});
  }
}
