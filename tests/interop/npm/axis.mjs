// Move axis 1 by 50 mm with the NC's services; print start, end and peak velocity as JSON.
import { setTimeout as delay } from "node:timers/promises";
import { Client } from "ads-client";

const NC = { adsPort: 501 };
const client = new Client({ hideConsoleWarnings: true, ...JSON.parse(process.argv[2]) });
await client.connect();

async function online() {
  const data = await client.readRaw(0x4101, 0, 112, NC);
  return {
    error: data.readInt32LE(0),
    actual: data.readDoubleLE(4),
    position: data.readDoubleLE(20),
    velocity: data.readDoubleLE(44),
    status: data.readUInt32LE(96),
  };
}

const [NOT_MOVING, HAS_JOB] = [1 << 2, 1 << 8];
const dword = (value) => Buffer.from(new Uint32Array([value]).buffer);
await client.writeRaw(0x4301, 0x01, dword(7), NC);
await client.writeRaw(0x4301, 0x21, dword(1_000_000), NC);
while (!((await online()).status & 1)) await delay(5);

const start = await online();
const command = Buffer.alloc(24);
command.writeUInt32LE(2, 0); // relative
command.writeDoubleLE(50, 8);
command.writeDoubleLE(100, 16);
await client.writeRaw(0x4201, 0x20, command, NC);

let peak = 0;
let now;
do {
  now = await online();
  peak = Math.max(peak, now.velocity);
} while (!(now.status & NOT_MOVING) || now.status & HAS_JOB || now.position < start.position + 49);

await delay(200);
const end = await online();
await client.writeRaw(0x4301, 0x01, dword(0), NC);
await client.disconnect();
console.log(JSON.stringify({ start, end, peak }));
