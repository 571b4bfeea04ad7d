/** Blocks of samples as they come over the WebSocket (little endian, as the server writes them). */

const HEADER = 16;
const SAMPLES = 1;
const GAP = 1;
const TRIGGER = 2;
const END = 4;

/**
 * A block: which scope, what it tells, and its columns, the first of them the time in seconds.
 * Null for anything that is not a whole block.
 *
 * @param {ArrayBuffer} buffer
 */
export function decode(buffer) {
  if (!(buffer instanceof ArrayBuffer) || buffer.byteLength < HEADER) return null;
  const head = new DataView(buffer);
  if (head.getUint8(0) !== SAMPLES) return null;
  const flags = head.getUint8(1);
  const width = head.getUint32(4, true);
  const rows = head.getUint32(8, true);
  if (buffer.byteLength !== HEADER + 8 * width * rows) return null;
  const columns = [];
  if (rows > 0) {
    for (let n = 0; n < width; n += 1) {
      columns.push(new Float64Array(buffer, HEADER + 8 * n * rows, rows));
    }
  }
  return {
    scope: head.getUint16(2, true), rows, columns, dropped: head.getUint32(12, true),
    gap: (flags & GAP) !== 0, trigger: (flags & TRIGGER) !== 0, end: (flags & END) !== 0,
  };
}
