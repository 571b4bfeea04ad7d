/** Live values: those of a running station beside the declarations of its programs and lists. */

import { spawn, type ChildProcess } from 'node:child_process';
import * as vscode from 'vscode';
import { programOf } from './program';
import { SampleReader, shown } from './samples';

const REFRESH_MS = 200;
const MOST_NAMES = 200;
/** Kinds of symbols that exist once, so that the name of a variable is its address. */
const PLACED = new Set([vscode.SymbolKind.Module, vscode.SymbolKind.Namespace]);
const VARIABLES = new Set([vscode.SymbolKind.Variable, vscode.SymbolKind.Field]);

interface Watched {
  name: string;
  at: vscode.Position;
}

/** Shows values as inlay hints while they are switched on. */
export class LiveValues implements vscode.InlayHintsProvider, vscode.Disposable {
  private readonly changed = new vscode.EventEmitter<void>();
  readonly onDidChangeInlayHints = this.changed.event;
  private child: ChildProcess | undefined;
  private places: Watched[] = [];
  private document = '';
  private readonly values = new Map<string, unknown>();
  private timer: NodeJS.Timeout | undefined;

  constructor(private readonly log: vscode.OutputChannel) {}

  /** Show the values of a document, or hide them. */
  async toggle(document: vscode.TextDocument | undefined): Promise<void> {
    const wasOn = this.document;
    this.dispose();
    if (document && document.uri.toString() !== wasOn) await this.watch(document);
    this.changed.fire();
  }

  private async watch(document: vscode.TextDocument): Promise<void> {
    this.document = document.uri.toString();
    const symbols = await vscode.commands.executeCommand<vscode.DocumentSymbol[] | undefined>(
      'vscode.executeDocumentSymbolProvider',
      document.uri,
    );
    this.places = watched(symbols ?? []).slice(0, MOST_NAMES);
    if (this.places.length === 0) return;
    const setting = vscode.workspace.getConfiguration('achse');
    const program = programOf(
      setting.get<string[]>('command'),
      ...['ads', 'read', '--watch', '--json', '--host', setting.get('host', '127.0.0.1')],
      ...['--tcp-port', String(setting.get('tcpPort', 48898))],
      ...['--port', String(setting.get('plcPort', 851)), '--cycle-time', '0.2'],
      ...this.places.map((place) => place.name),
    );
    const child = (this.child = spawn(program.command, program.args, { stdio: ['ignore', 'pipe', 'pipe'] }));
    const reader = new SampleReader();
    child.stdout!.on('data', (data: Buffer) => {
      for (const sample of reader.read(data.toString())) this.values.set(sample.name, sample.value);
      this.timer ??= setTimeout(() => {
        this.timer = undefined;
        this.changed.fire();
      }, REFRESH_MS);
    });
    child.stderr!.on('data', (data: Buffer) => this.log.append(data.toString()));
    child.on('error', (error) => this.log.appendLine(String(error)));
  }

  provideInlayHints(document: vscode.TextDocument, range: vscode.Range): vscode.InlayHint[] {
    if (document.uri.toString() !== this.document) return [];
    return this.places
      .filter((place) => this.values.has(place.name) && range.contains(place.at))
      .map((place) => {
        const hint = new vscode.InlayHint(place.at, ` = ${shown(this.values.get(place.name))}`);
        hint.paddingLeft = true;
        return hint;
      });
  }

  dispose(): void {
    this.child?.kill();
    clearTimeout(this.timer);
    this.timer = undefined;
    this.child = undefined;
    this.document = '';
    this.places = [];
    this.values.clear();
  }
}

/** Return the variables of programs and lists, with the ends of their names. */
export function watched(symbols: readonly vscode.DocumentSymbol[]): Watched[] {
  return symbols
    .filter((unit) => PLACED.has(unit.kind))
    .flatMap((unit) =>
      unit.children
        .filter((one) => VARIABLES.has(one.kind))
        .map((one) => ({ name: `${unit.name}.${one.name}`, at: one.selectionRange.end })),
    );
}
