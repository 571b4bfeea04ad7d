// Whole structures by the uploaded types, a method, a subscription; print what was found as JSON.
import { once, EventEmitter } from "node:events";
import { Client } from "ads-client";

const client = new Client({ hideConsoleWarnings: true, ...JSON.parse(process.argv[2]) });
const found = {};
await client.connect();
found.symbols = Object.values(await client.getSymbols())
  .map((symbol) => symbol.name)
  .filter((name) => name.startsWith("GVL.") || name.startsWith("MAIN."));
found.before = (await client.readValue("GVL.aStations")).value;

const first = found.before[0];
const changed = {
  ...first,
  sName: "zweite",
  wsTitle: "Maß µ",
  eMode: "Fault",
  tWait: 250,
  bReady: true,
  aPoints: [
    { fX: 1.25, fY: -2.5 },
    { fX: 3, fY: 4 },
  ],
};
await client.writeValue("GVL.aStations[1]", changed);
found.after = (await client.readValue("GVL.aStations[1]")).value;
await client.writeValue("GVL.aStations[1]", { nId: 22 }, true);
found.member = (await client.readValue("GVL.aStations[1].nId")).value;

found.fed = await client.invokeRpcMethod("MAIN.fbFeeder", "Feed", {
  nParts: 4,
  fWeight: 2.5,
  sWhat: "Schrauben",
});
found.last = await client.invokeRpcMethod("MAIN.fbFeeder", "Last");
found.total = (await client.readValue("MAIN.fbFeeder.nFed")).value;
found.shifted = await client.invokeRpcMethod("MAIN", "Shift", { nTo: 3 });

const samples = new EventEmitter();
const seen = [];
const subscription = await client.subscribeValue(
  "GVL.aStations[2]",
  (data) => {
    seen.push([data.value.sName, data.value.aPoints[1].fY]);
    samples.emit("sample");
  },
  10,
);
if (!seen.length) await once(samples, "sample");
const next = once(samples, "sample");
await client.writeValue("GVL.aStations[2]", { sName: "dritte" }, true);
await next;
await subscription.unsubscribe();
found.samples = seen;
await client.disconnect();
console.log(JSON.stringify(found));
