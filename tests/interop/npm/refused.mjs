// Ask a station that may have no room for us; print the ADS error it answers with, 0 if none.
import { Client } from "ads-client";

const settings = JSON.parse(process.argv[2]);
const client = new Client({ hideConsoleWarnings: true, rawClient: true, ...settings });
let outcome = 0;
try {
  await client.connect();
  await client.readRaw(0xf100, 0, 4);
} catch (failure) {
  outcome = failure.adsError?.errorCode ?? String(failure.message);
}
await client.disconnect(true).catch(() => {});
console.log(JSON.stringify(outcome));
