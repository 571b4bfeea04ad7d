// Restart the target as its tray icon would, and look at it before, meanwhile and after; JSON.
import { Client } from "ads-client";

const client = new Client({
  hideConsoleWarnings: true,
  allowHalfOpen: true,
  ...JSON.parse(process.argv[2]),
});
await client.connect();
const found = {};
const state = async () => (await client.readTcSystemState()).adsState;
const index = async () =>
  (await client.readRaw(0xf0, 0, 6, { adsPort: 10000 })).readUInt16LE(4);
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

found.before = await state();
found.indexBefore = await index();
await client.restartTcSystem(false);
for (let tries = 0; tries < 1000; tries++) {
  await pause(50);
  if ((await index()) > found.indexBefore) break;
}
found.after = await state();
found.index = await index();
found.value = (await client.readValue("GVL.sString")).value;
await client.disconnect();
console.log(JSON.stringify(found));
process.exit(0);
