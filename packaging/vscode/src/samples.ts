/** Samples of `achse ads read --watch --json`: one JSON document a line. */

export interface Sample {
  name: string;
  value: unknown;
}

/** Cuts what a program prints into samples. */
export class SampleReader {
  private rest = '';

  /** Return the samples that are whole with some more output. */
  read(output: string): Sample[] {
    const lines = (this.rest + output).split('\n');
    this.rest = lines.pop() ?? '';
    return lines.flatMap((line) => {
      try {
        const found: unknown = JSON.parse(line);
        return isSample(found) ? [found] : [];
      } catch {
        return [];
      }
    });
  }
}

function isSample(found: unknown): found is Sample {
  return typeof found === 'object' && found !== null && 'name' in found && 'value' in found;
}

/** Return a value as it is shown beside the code. */
export function shown(value: unknown): string {
  if (typeof value === 'number' && !Number.isInteger(value)) return value.toPrecision(7).replace(/\.?0+$/, '');
  if (typeof value === 'string') return `'${value.slice(0, 40)}'`;
  const text = JSON.stringify(value);
  return text.length > 60 ? `${text.slice(0, 59)}…` : text;
}
