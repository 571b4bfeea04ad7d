/** Bundle the tests with a stub of the editor's module, and run them. */

import { spawnSync } from 'node:child_process';
import { readdirSync } from 'node:fs';
import { build } from 'esbuild';

const here = new URL('.', import.meta.url).pathname;
const tests = readdirSync(here).filter((name) => name.endsWith('.test.ts'));
await build({
  entryPoints: tests.map((name) => `${here}${name}`),
  bundle: true,
  platform: 'node',
  outdir: `${here}../out/test`,
  alias: { vscode: `${here}editor.ts`, 'vscode-languageclient/node': `${here}client.ts` },
});
const files = tests.map((name) => `${here}../out/test/${name.replace('.ts', '.js')}`);
const { status } = spawnSync(process.execPath, ['--test', ...files], { stdio: 'inherit' });
process.exit(status ?? 1);
