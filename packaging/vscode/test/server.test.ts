/** The messages that the editor's client sends, to the real `achse lsp` and `achse plc debug`.

ACHSE names the program, as a JSON list of words; without it these tests are left out. */

import assert from 'node:assert/strict';
import { spawn, type ChildProcessWithoutNullStreams } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import {
  createProtocolConnection,
  StreamMessageReader,
  StreamMessageWriter,
  type DocumentSymbol,
  type PublishDiagnosticsParams,
  type TextEdit,
} from 'vscode-languageserver-protocol/node';
import { programOf } from '../src/program';
import { watched } from '../src/live';

const words = JSON.parse(process.env.ACHSE ?? '[]') as string[];
const skip = words.length === 0;
const TEXT = 'PROGRAM MAIN\nVAR\n    nCounter : INT; // parts\nEND_VAR\nIF nCounter > 3 THEN\nnCountre := 1;\nEND_IF\nEND_PROGRAM\n';

/** Return a symbol as the editor has it: kinds count from 0 there, in the protocol from 1. */
function asInEditor(one: DocumentSymbol): DocumentSymbol {
  const kind = (one.kind - 1) as DocumentSymbol['kind'];
  return { ...one, kind, children: (one.children ?? []).map(asInEditor) };
}

function started(...more: string[]): ChildProcessWithoutNullStreams {
  const program = programOf(words, ...more);
  return spawn(program.command, program.args);
}

test('the language server answers what the editor asks', { skip }, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'achse-server-'));
  process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
  writeFileSync(join(folder, 'MAIN.st'), TEXT);
  const uri = pathToFileURL(join(folder, 'MAIN.st')).href;
  const child = started('lsp');
  const server = createProtocolConnection(
    new StreamMessageReader(child.stdout),
    new StreamMessageWriter(child.stdin),
  );
  const findings = new Map<number, PublishDiagnosticsParams>();
  let told: () => void = () => undefined;
  server.onNotification('textDocument/publishDiagnostics', (params: PublishDiagnosticsParams) => {
    findings.set(params.version ?? 0, params);
    told();
  });
  server.onRequest('client/registerCapability', () => null);
  server.listen();
  const seen = async (version: number) => {
    while (!findings.has(version)) await new Promise<void>((resolve) => (told = resolve));
    return findings.get(version)!.diagnostics;
  };
  const answer = await server.sendRequest<{ capabilities: Record<string, unknown> }>('initialize', {
    processId: process.pid,
    clientInfo: { name: 'Visual Studio Code' },
    rootUri: pathToFileURL(folder).href,
    workspaceFolders: [{ uri: pathToFileURL(folder).href, name: 'project' }],
    initializationOptions: { libraries: [], defines: [] },
    capabilities: {
      general: { positionEncodings: ['utf-16'] },
      workspace: { didChangeWatchedFiles: { dynamicRegistration: true } },
      textDocument: { documentSymbol: { hierarchicalDocumentSymbolSupport: true } },
    },
  });
  assert.ok(answer.capabilities.documentFormattingProvider);
  assert.ok(answer.capabilities.renameProvider);
  await server.sendNotification('initialized', {});
  const document = { uri, languageId: 'iecst', version: 1, text: TEXT };
  await server.sendNotification('textDocument/didOpen', { textDocument: document });
  const [finding] = await seen(1);
  assert.equal(finding!.code, 'ST3001');
  assert.match(finding!.message, /near: ncounter/i);
  const textDocument = { uri };
  const actions = await server.sendRequest<{ title: string }[]>('textDocument/codeAction', {
    textDocument, range: finding!.range, context: { diagnostics: [finding] },
  });
  assert.match(actions[0]!.title, /nCounter/i);
  const symbols = await server.sendRequest<DocumentSymbol[]>('textDocument/documentSymbol', { textDocument });
  assert.deepEqual(watched(symbols.map(asInEditor) as never).map((one) => one.name), ['MAIN.nCounter']);
  const edits = await server.sendRequest<TextEdit[]>('textDocument/formatting', {
    textDocument, options: { tabSize: 4, insertSpaces: true },
  });
  assert.deepEqual(edits.map((one) => [one.range.start.line, one.newText]), [[5, '    ']]);
  await server.sendNotification('textDocument/didChange', {
    textDocument: { uri, version: 2 },
    contentChanges: [{ range: finding!.range, text: 'nCounter' }],
  });
  assert.deepEqual(await seen(2), []);
  const position = { line: 5, character: 2 };
  const hover = await server.sendRequest<{ contents: { value: string } }>('textDocument/hover', { textDocument, position });
  assert.match(hover.contents.value, /nCounter : INT[\s\S]*parts/);
  const renamed = await server.sendRequest<{ changes: Record<string, TextEdit[]> }>('textDocument/rename', {
    textDocument, position, newName: 'nParts',
  });
  assert.equal(renamed.changes[uri]!.length, 3);
  await server.sendRequest('shutdown');
  await server.sendNotification('exit');
  server.end();
  await new Promise((resolve) => child.on('close', resolve));
  server.dispose();
});

test('the debugger answers the editor', { skip }, async () => {
  const child = started('plc', 'debug');
  const body = JSON.stringify({ seq: 1, type: 'request', command: 'initialize', arguments: { adapterID: 'achse' } });
  child.stdin.write(`Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`);
  let output = '';
  for await (const data of child.stdout) {
    output += String(data);
    if (/"command": ?"initialize"/.test(output) && output.includes('}')) break;
  }
  child.kill();
  assert.match(output, /"success": ?true/);
  assert.match(output, /supportsConfigurationDoneRequest/);
});
