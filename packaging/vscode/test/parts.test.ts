import assert from 'node:assert/strict';
import { test } from 'node:test';
import { results } from '../src/junit';
import { programOf, run } from '../src/program';
import { SampleReader, shown } from '../src/samples';

const REPORT = `<?xml version="1.0"?>
<testsuites><testsuite name="MAIN.a" tests="4">
<testcase classname="MAIN.a" name="good" time="0.020" file="FB_A.TcPOU" line="7" />
<testcase classname="MAIN.a" name="bad &lt;1&gt;" time="0.01"><failure message="no">1 &#38; 2</failure></testcase>
<testcase classname="MAIN.a" name="left out" time="0"><skipped /></testcase>
<testcase classname="project" name="runs" time="0"><error message="no task" type="project" /></testcase>
</testsuite></testsuites>`;

test('results have outcome, message and place', () => {
  const found = results(REPORT);
  assert.deepEqual(found.map((one) => one.outcome), ['passed', 'failed', 'skipped', 'errored']);
  assert.deepEqual(
    { ...found[0] },
    { suite: 'MAIN.a', name: 'good', outcome: 'passed', message: '', duration: 20, file: 'FB_A.TcPOU', line: 7 },
  );
  assert.equal(found[1]!.name, 'bad <1>');
  assert.equal(found[1]!.message, '1 & 2');
  assert.equal(found[3]!.message, 'no task');
  assert.deepEqual(results('no document'), []);
});

test('samples may come in pieces', () => {
  const reader = new SampleReader();
  const line = '{"time": "x", "name": "MAIN.n", "value": 3, "lost": 0, "gap": false}\n';
  assert.deepEqual(reader.read(line.slice(0, 20)), []);
  const found = reader.read(`${line.slice(20)}noise\n[1]\n`);
  assert.deepEqual(found.map((one) => [one.name, one.value]), [['MAIN.n', 3]]);
});

test('values are short', () => {
  assert.equal(shown(0.1 + 0.2), '0.3');
  assert.equal(shown(42), '42');
  assert.equal(shown(true), 'true');
  assert.equal(shown('text'), "'text'");
  assert.equal(shown(Array(99).fill(1)).length, 60);
});

test('a program may have words before its own', async () => {
  assert.deepEqual(programOf(undefined, 'lsp'), { command: 'achse', args: ['lsp'] });
  assert.deepEqual(programOf([], 'lsp').command, 'achse');
  const program = programOf([process.execPath, '-e'], 'console.log(1); process.exitCode = 3');
  assert.deepEqual(await run(program, '.'), { code: 3, output: '1\n' });
  await assert.rejects(run(programOf(['no such program']), '.'));
});
