import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { activate, deactivate } from '../src/extension';
import { clients } from './client';
import * as editor from './editor';

const folder = mkdtempSync(join(tmpdir(), 'achse-extension-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
const context = { subscriptions: [] as unknown[] };

/** A program that answers as achse does. */
const PROGRAM = `
const words = process.argv.slice(2);
const report = words[words.indexOf('--junit') + 1];
if (words[0] === 'test') {
  require('fs').writeFileSync(report, '<testcase classname="S" name="a" time="1" file="A.st" line="3"/>' +
    '<testcase classname="S" name="b"><failure>wrong</failure></testcase>');
  console.log('1 failed');
  process.exitCode = 1;
} else {
  console.log(JSON.stringify({ name: 'MAIN.nCount', value: words.includes('--json') ? 7 : 0 }));
  setTimeout(() => undefined, 10_000);
}`;

test('activation starts the server, and registers debugger, tests and values', async () => {
  writeFileSync(join(folder, 'achse.js'), PROGRAM);
  editor.settings.command = [process.execPath, join(folder, 'achse.js')];
  await activate(context as never);
  const [client] = clients;
  assert.equal(client!.state, 'started');
  assert.deepEqual(client!.server.args.slice(-1), ['lsp']);
  assert.deepEqual(client!.options.initializationOptions, { libraries: [], defines: [] });
  const adapter = editor.registered['debug achse'].createDebugAdapterDescriptor();
  assert.deepEqual(adapter.args.slice(-2), ['plc', 'debug']);
});

test('tests of a project are run, and shown by suite', async () => {
  const station = join(folder, 'station.toml');
  editor.workspace.files = [editor.uri(station), editor.uri(join(folder, 'Plc.plcproj'))];
  const token = { isCancellationRequested: false, onCancellationRequested: () => undefined };
  await editor.registered.controller.resolveHandler();
  assert.equal(editor.registered.controller.items.size, 1);
  await editor.registered.runTests({ include: undefined }, token);
  const label = station.split('/').slice(-2).join('/');
  assert.deepEqual(editor.outcomes, [
    `started ${label}`, 'output true', 'passed a', 'failed b', `failed ${label}`, 'end',
  ]);
});

test('live values of programs stand behind their declarations', async () => {
  const at = new editor.Position(2, 10);
  const range = new editor.Range(new editor.Position(0, 0), new editor.Position(9, 0));
  const variable = { name: 'nCount', kind: editor.SymbolKind.Variable, selectionRange: { end: at } };
  editor.symbols.push(
    { name: 'MAIN', kind: editor.SymbolKind.Module, children: [variable] },
    { name: 'FB_A', kind: editor.SymbolKind.Class, children: [variable] },
  );
  const document = { uri: editor.uri(join(folder, 'MAIN.st')) };
  editor.window.activeTextEditor = { document };
  await editor.registered['achse.liveValues']();
  const provider = editor.registered.hints;
  for (let tries = 0; tries < 500 && provider.provideInlayHints(document, range).length === 0; tries++) {
    await new Promise((resolve) => setTimeout(resolve, 10));
  }
  const [hint] = provider.provideInlayHints(document, range);
  assert.deepEqual([hint.label, hint.position], [' = 7', at]);
  await editor.registered['achse.liveValues']();
  assert.deepEqual(provider.provideInlayHints(document, range), []);
});

test('a program that is missing is reported, and a restart stops the old one', async () => {
  editor.settings.command = ['missing'];
  await editor.registered['achse.restart']();
  assert.equal(clients[0]!.state, 'stopped');
  assert.match(editor.window.messages[0]!, /achse lsp does not start/);
  await deactivate();
});
