// Ask several things at once while the station misbehaves; print what came of each as JSON.
import { Client } from "ads-client";

const { requests, timeLimit, ...settings } = JSON.parse(process.argv[2]);
const client = new Client({ hideConsoleWarnings: true, timeoutDelay: 600000, ...settings });
await client.connect();
client.settings.timeoutDelay = timeLimit;
const arrived = [];
const outcomes = await Promise.all(
  requests.map(async ([group, offset]) => {
    try {
      const data = await client.readRaw(group, offset, 4);
      arrived.push(offset);
      return data.readUInt32LE(0);
    } catch (failure) {
      return failure.adsError?.errorCode ?? String(failure.message).split("\n")[0];
    }
  }),
);
await client.disconnect().catch(() => {});
console.log(JSON.stringify({ outcomes, arrived }));
