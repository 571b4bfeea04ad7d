/** The program achse: its words, and runs of it. */

import { spawn } from 'node:child_process';

/** A program with its first words. */
export interface Program {
  command: string;
  args: string[];
}

/** Return the program that a setting names, with further words. */
export function programOf(setting: readonly string[] | undefined, ...words: string[]): Program {
  const [command, ...before] = setting && setting.length > 0 ? setting : ['achse'];
  return { command: command ?? 'achse', args: [...before, ...words] };
}

/** Result of a program that ended. */
export interface Ended {
  code: number | null;
  output: string;
}

/** Run a program to its end; `cancel` returns a function that is called to stop it. */
export function run(
  program: Program,
  cwd: string,
  cancel: (stop: () => void) => void = () => undefined,
): Promise<Ended> {
  return new Promise((resolve, reject) => {
    const child = spawn(program.command, program.args, { cwd, stdio: ['ignore', 'pipe', 'pipe'] });
    let output = '';
    child.stdout.on('data', (data: Buffer) => (output += data.toString()));
    child.stderr.on('data', (data: Buffer) => (output += data.toString()));
    child.on('error', reject);
    child.on('close', (code) => resolve({ code, output }));
    cancel(() => child.kill());
  });
}
