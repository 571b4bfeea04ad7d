// Subscribe and go on through a restart of the station: one line for each sample.
import { Client } from "ads-client";

const client = new Client({
  hideConsoleWarnings: true,
  connectionCheckInterval: 200,
  connectionDownDelay: 5000,
  reconnectInterval: 200,
  timeoutDelay: 600000,
  ...JSON.parse(process.argv[2]),
});
await client.connect();
client.on("reconnect", () => console.log("reconnected"));
let count = 0;
await client.subscribeValue(
  "GVL.aStations[0].sName",
  (data) => console.log(`sample ${data.value}`),
  10,
);
process.stdin.on("data", async () => {
  await client.writeValue("GVL.aStations[0].sName", `changed ${++count}`);
});
process.stdin.on("end", async () => {
  await client.disconnect();
  process.exit(0);
});
