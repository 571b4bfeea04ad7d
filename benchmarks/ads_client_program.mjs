// A program with the npm package ads-client for many_programs.py; `.ci/run` installs it.
// It subscribes so many times to a counter, and prints what came behind each line of its standard
// input, and at its end.
// Arguments: NetId of the target, address of the router, number of the program, subscriptions.
import { createRequire } from "node:module";

const require = createRequire(new URL("../tests/interop/npm/package.json", import.meta.url));
const { Client } = require("ads-client");

const [targetAmsNetId, routerAddress, number, subscriptions] = process.argv.slice(2);
const counts = { samples: 0, missed: 0, gaps: 0, restarts: 0, foreign: 0, ends: 0 };
const last = new Map();

function came(subscription, value) {
  if (typeof value !== "number") {
    counts.ends += 1;
    return;
  }
  const count = Math.floor(value / 16);
  counts.samples += 1;
  counts.foreign += value > 0 && value % 16 !== Number(number);
  const before = last.get(subscription);
  if (before !== undefined) {
    counts.restarts += count < before;
    if (before > 0 && count > before + 1) {
      counts.missed += count - before - 1;
      counts.gaps += 1;
    }
  }
  last.set(subscription, count);
}

const client = new Client({
  targetAmsNetId, targetAdsPort: 851, routerAddress, routerTcpPort: 48898, hideConsoleWarnings: true,
});
client.on("error", () => {}); // what is lost is counted
client.on("client-error", () => {});
await client.connect();
for (let each = 0; each < Number(subscriptions); each += 1) {
  await client.subscribeValue(`MAIN.aCount[${number}]`, (data) => came(each, data.value), 0, true);
}
console.log("ready");
const report = () => console.log(JSON.stringify({ ...counts, subscriptions: last.size }));
process.stdin.on("data", report);
process.stdin.on("end", () => {
  report();
  process.kill(process.pid, "SIGKILL");
});
