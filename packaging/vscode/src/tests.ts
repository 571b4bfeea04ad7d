/** Tests in the test explorer: each project with its suites, run by `achse test`. */

import * as fs from 'node:fs/promises';
import * as os from 'node:os';
import * as path from 'node:path';
import * as vscode from 'vscode';
import { results, type TestResult } from './junit';
import { programOf, run } from './program';

const PROJECTS = '**/{station.toml,*.plcproj}';
const MOST_PROJECTS = 50;

/** Make the test explorer's items of all projects in the open folders. */
export function addTests(context: vscode.ExtensionContext): vscode.TestController {
  const controller = vscode.tests.createTestController('achse', 'achse: TcUnit');
  controller.resolveHandler = async (item) => {
    if (!item) await findProjects(controller);
  };
  controller.refreshHandler = () => findProjects(controller);
  controller.createRunProfile(
    'Run in virtual time',
    vscode.TestRunProfileKind.Run,
    (request, token) => runTests(controller, request, token),
    true,
  );
  context.subscriptions.push(controller);
  return controller;
}

async function findProjects(controller: vscode.TestController): Promise<void> {
  const files = await vscode.workspace.findFiles(PROJECTS, '**/node_modules/**', MOST_PROJECTS);
  const stations = files.filter((file) => file.fsPath.endsWith('.toml'));
  const items = (stations.length > 0 ? stations : files).map((file) =>
    controller.createTestItem(file.fsPath, vscode.workspace.asRelativePath(file), file),
  );
  controller.items.replace(items);
}

/** Return the project that an item is of. */
function projectOf(item: vscode.TestItem): vscode.TestItem {
  return item.parent ? projectOf(item.parent) : item;
}

async function runTests(
  controller: vscode.TestController,
  request: vscode.TestRunRequest,
  token: vscode.CancellationToken,
): Promise<void> {
  if (controller.items.size === 0) await findProjects(controller);
  const wanted: vscode.TestItem[] = [];
  controller.items.forEach((item) => wanted.push(item));
  const projects = new Set((request.include ?? wanted).map(projectOf));
  const testRun = controller.createTestRun(request);
  try {
    for (const project of projects) {
      if (!token.isCancellationRequested) await runProject(controller, testRun, project, token);
    }
  } finally {
    testRun.end();
  }
}

async function runProject(
  controller: vscode.TestController,
  testRun: vscode.TestRun,
  project: vscode.TestItem,
  token: vscode.CancellationToken,
): Promise<void> {
  const folder = await fs.mkdtemp(path.join(os.tmpdir(), 'achse-tests-'));
  const report = path.join(folder, 'results.xml');
  const setting = vscode.workspace.getConfiguration('achse');
  const libraries = setting.get<string[]>('libraries', []).flatMap((one) => ['--library', one]);
  const words = ['test', project.id, ...libraries, '--junit', report];
  testRun.started(project);
  try {
    const program = programOf(setting.get<string[]>('command'), ...words);
    const ended = await run(program, path.dirname(project.id), (stop) =>
      token.onCancellationRequested(stop),
    );
    testRun.appendOutput(ended.output.replace(/\r?\n/g, '\r\n'));
    const document = await fs.readFile(report, 'utf8').catch(() => '');
    const found = results(document);
    show(controller, testRun, project, found);
    if (ended.code === 0) testRun.passed(project);
    else if (found.length > 0) testRun.failed(project, new vscode.TestMessage('a test failed'));
    else testRun.errored(project, new vscode.TestMessage(ended.output || 'achse test ended'));
  } catch (error) {
    testRun.errored(project, new vscode.TestMessage(String(error)));
  } finally {
    await fs.rm(folder, { recursive: true, force: true });
  }
}

/** Give a project the items of its tests, with their results. */
function show(
  controller: vscode.TestController,
  testRun: vscode.TestRun,
  project: vscode.TestItem,
  found: TestResult[],
): void {
  const suites = new Map<string, vscode.TestItem>();
  for (const result of found) {
    let suite = suites.get(result.suite);
    if (!suite) {
      suite = controller.createTestItem(`${project.id}#${result.suite}`, result.suite, project.uri);
      suites.set(result.suite, suite);
    }
    const place = placeOf(project, result);
    const item = controller.createTestItem(`${suite.id}#${result.name}`, result.name, place?.uri);
    if (place) item.range = place.range;
    suite.children.add(item);
    const message = new vscode.TestMessage(result.message);
    if (place) message.location = place;
    switch (result.outcome) {
      case 'passed': testRun.passed(item, result.duration); break;
      case 'failed': testRun.failed(item, message, result.duration); break;
      case 'errored': testRun.errored(item, message, result.duration); break;
      case 'skipped': testRun.skipped(item); break;
    }
  }
  project.children.replace([...suites.values()]);
}

function placeOf(project: vscode.TestItem, result: TestResult): vscode.Location | undefined {
  if (!result.file) return undefined;
  const file = path.resolve(path.dirname(project.id), result.file);
  const at = new vscode.Position(Math.max((result.line ?? 1) - 1, 0), 0);
  return new vscode.Location(vscode.Uri.file(file), new vscode.Range(at, at));
}
