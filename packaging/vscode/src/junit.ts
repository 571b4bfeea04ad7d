/** Results of `achse test --junit`: suites with their tests. */

export type Outcome = 'passed' | 'failed' | 'errored' | 'skipped';

export interface TestResult {
  suite: string;
  name: string;
  outcome: Outcome;
  message: string;
  /** Duration in PLC time, ms. */
  duration: number;
  file?: string;
  line?: number;
}

const CASE = /<testcase\b([^>]*?)(?:\/>|>([\s\S]*?)<\/testcase>)/g;
const ATTRIBUTE = /([\w-]+)="([^"]*)"/g;
const PROBLEM = /<(failure|error|skipped)\b([^>]*?)(?:\/>|>([\s\S]*?)<\/\1>)/;
const ENTITIES: Record<string, string> = { lt: '<', gt: '>', amp: '&', quot: '"', apos: "'" };

function plain(text: string): string {
  return text.replace(/&(?:#(\d+)|#x([0-9a-f]+)|(\w+));/gi, (all, decimal, hex, name) => {
    if (decimal) return String.fromCodePoint(Number(decimal));
    if (hex) return String.fromCodePoint(parseInt(hex, 16));
    return ENTITIES[name] ?? all;
  });
}

function attributes(text: string): Record<string, string> {
  const found: Record<string, string> = {};
  for (const [, name, value] of text.matchAll(ATTRIBUTE)) found[name!] = plain(value!);
  return found;
}

/** Return the tests of a document, in order. */
export function results(document: string): TestResult[] {
  const found: TestResult[] = [];
  for (const [, head, inside] of document.matchAll(CASE)) {
    const facts = attributes(head!);
    const problem = PROBLEM.exec(inside ?? '');
    const outcome: Outcome = !problem
      ? 'passed'
      : problem[1] === 'failure' ? 'failed' : problem[1] === 'error' ? 'errored' : 'skipped';
    const line = Number(facts.line);
    found.push({
      suite: facts.classname ?? '',
      name: facts.name ?? '',
      outcome,
      message: problem ? plain(problem[3] ?? '').trim() || (attributes(problem[2]!).message ?? '') : '',
      duration: Number(facts.time ?? 0) * 1000,
      ...(facts.file ? { file: facts.file } : {}),
      ...(line > 0 ? { line } : {}),
    });
  }
  return found;
}
