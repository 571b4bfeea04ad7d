/** The extension: language server, debugger, tests and live values, all of the program achse. */

import * as vscode from 'vscode';
import { LanguageClient, type LanguageClientOptions } from 'vscode-languageclient/node';
import { LiveValues } from './live';
import { programOf } from './program';
import { addTests } from './tests';

const DOCUMENTS = [
  { scheme: 'file', language: 'iecst' },
  { scheme: 'file', pattern: '**/*.Tc{POU,GVL,DUT,IO}' },
];

let client: LanguageClient | undefined;

function command(): string[] | undefined {
  return vscode.workspace.getConfiguration('achse').get<string[]>('command');
}

function newClient(log: vscode.OutputChannel): LanguageClient {
  const setting = vscode.workspace.getConfiguration('achse');
  const options: LanguageClientOptions = {
    documentSelector: DOCUMENTS,
    outputChannel: log,
    initializationOptions: {
      libraries: setting.get<string[]>('libraries', []),
      defines: setting.get<string[]>('defines', []),
    },
  };
  return new LanguageClient('achse', 'achse', programOf(command(), 'lsp'), options);
}

async function start(log: vscode.OutputChannel): Promise<void> {
  client = newClient(log);
  try {
    await client.start();
  } catch (error) {
    const said = `achse lsp does not start: ${String(error)}. Is achse[lsp] installed?`;
    void vscode.window.showErrorMessage(said);
  }
}

export async function activate(context: vscode.ExtensionContext): Promise<void> {
  const log = vscode.window.createOutputChannel('achse');
  const live = new LiveValues(log);
  context.subscriptions.push(
    log,
    live,
    vscode.languages.registerInlayHintsProvider(DOCUMENTS, live),
    vscode.commands.registerCommand('achse.liveValues', () =>
      live.toggle(vscode.window.activeTextEditor?.document),
    ),
    vscode.commands.registerCommand('achse.restart', async () => {
      await client?.stop();
      await start(log);
    }),
    vscode.debug.registerDebugAdapterDescriptorFactory('achse', {
      createDebugAdapterDescriptor: () => {
        const program = programOf(command(), 'plc', 'debug');
        return new vscode.DebugAdapterExecutable(program.command, program.args);
      },
    }),
  );
  addTests(context);
  await start(log);
}

export async function deactivate(): Promise<void> {
  await client?.stop();
}
