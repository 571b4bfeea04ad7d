/** A stub of the module `vscode`: what the extension registers is kept, to be called. */

/* eslint-disable @typescript-eslint/no-explicit-any */

export const registered: Record<string, any> = {};
export const settings: Record<string, unknown> = {};
export const symbols: any[] = [];

export class EventEmitter {
  fired = 0;
  event = () => ({ dispose: () => undefined });
  fire(): void {
    this.fired += 1;
  }
}
export class Position {
  constructor(readonly line: number, readonly character: number) {}
}
export class Range {
  constructor(readonly start: Position, readonly end: Position) {}
  contains(at: Position): boolean {
    return at.line >= this.start.line && at.line <= this.end.line;
  }
}
export class Location {
  constructor(readonly uri: any, readonly range: Range) {}
}
export class InlayHint {
  paddingLeft = false;
  constructor(readonly position: Position, readonly label: string) {}
}
export class TestMessage {
  location: Location | undefined;
  constructor(readonly message: string) {}
}
export class DebugAdapterExecutable {
  constructor(readonly command: string, readonly args: string[]) {}
}
export const SymbolKind = { Module: 1, Namespace: 2, Class: 4, Field: 7, Variable: 12 };
export const TestRunProfileKind = { Run: 1 };
export const Uri = { file: (name: string) => uri(name) };

export function uri(fsPath: string): any {
  return { fsPath, toString: () => `file://${fsPath}` };
}

class Items {
  private readonly items = new Map<string, any>();
  constructor(private readonly parent?: any) {}
  get size(): number {
    return this.items.size;
  }
  add(item: any): void {
    item.parent = this.parent;
    this.items.set(item.id, item);
  }
  replace(items: any[]): void {
    this.items.clear();
    items.forEach((item) => this.add(item));
  }
  forEach(visit: (item: any) => void): void {
    this.items.forEach(visit);
  }
}

/** Outcomes of test runs: `passed name`. */
export const outcomes: string[] = [];

function testRun(): any {
  const note = (kind: string) => (item: any) => outcomes.push(`${kind} ${item.label}`);
  return {
    started: note('started'), passed: note('passed'), failed: note('failed'),
    errored: note('errored'), skipped: note('skipped'),
    appendOutput: (text: string) => outcomes.push(`output ${text.length > 0}`),
    end: () => outcomes.push('end'),
  };
}

export const tests = {
  createTestController: () => {
    const controller: any = {
      items: new Items(),
      createTestItem: (id: string, label: string, at: any) => {
        const item: any = { id, label, uri: at };
        item.children = new Items(item);
        return item;
      },
      createRunProfile: (...[, , handler]: any[]) => (registered.runTests = handler),
      createTestRun: testRun,
      dispose: () => undefined,
    };
    registered.controller = controller;
    return controller;
  },
};
export const workspace = {
  files: [] as any[],
  getConfiguration: () => ({ get: (key: string, other?: unknown) => settings[key] ?? other }),
  findFiles: async () => workspace.files,
  asRelativePath: (at: any) => at.fsPath.split('/').slice(-2).join('/'),
};
export const window = {
  messages: [] as string[],
  activeTextEditor: undefined as any,
  createOutputChannel: () => ({ append() {}, appendLine() {}, dispose() {} }),
  showErrorMessage: async (text: string) => void window.messages.push(text),
};
export const languages = {
  registerInlayHintsProvider: (_: any, provider: any) => (registered.hints = provider),
};
export const commands = {
  registerCommand: (name: string, run: any) => ((registered[name] = run), { dispose() {} }),
  executeCommand: async () => symbols,
};
export const debug = {
  registerDebugAdapterDescriptorFactory: (type: string, factory: any) =>
    ((registered[`debug ${type}`] = factory), { dispose() {} }),
};
