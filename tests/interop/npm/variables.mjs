// Connect, read, write and subscribe; print what was found as JSON.
import { once, EventEmitter } from "node:events";
import { Client } from "ads-client";

const client = new Client({ hideConsoleWarnings: true, ...JSON.parse(process.argv[2]) });
const found = {};
const connection = await client.connect();
found.local = `${connection.localAmsNetId}:${connection.localAdsPort}`;
found.device = (await client.readDeviceInfo()).deviceName;
found.state = (await client.readPlcRuntimeState()).adsStateStr;
found.symbols = Object.values(await client.getSymbols()).map((symbol) => symbol.name);

await client.writeValue("GVL.nDint", -123456);
found.DINT = (await client.readValue("GVL.nDint")).value;
await client.writeValue("GVL.fLreal", 0.125);
found.LREAL = (await client.readValue("GVL.fLreal")).value;
await client.writeValue("GVL.sString", "Vorschub");
found.STRING = (await client.readValue("GVL.sString")).value;
await client.writeValue("GVL.wsString", "Größe µ");
found.WSTRING = (await client.readValue("GVL.wsString")).value;
await client.writeValue("GVL.aInt", [9, 8, 7, 6, 5, 4, 3, 2, 1, 0]);
found.array = (await client.readValue("GVL.aInt")).value;
found.element = (await client.readValue("GVL.aInt[9]")).value;
await client.writeValue("GVL.stPoint", { fX: 1.5, fY: -2.5, sName: "corner", bValid: true });
found.structure = (await client.readValue("GVL.stPoint")).value;
await client.writeValue("GVL.stPoint", { fX: 4.5 }, true);
found.member = (await client.readValue("GVL.stPoint.fX")).value;
await client.writeValue("GVL.eColour", "BLUE");
found.enumeration = (await client.readValue("GVL.eColour")).value;

const symbol = await client.getSymbol("GVL.nDint");
const raw = await client.readRaw(symbol.indexGroup, symbol.indexOffset, symbol.size);
found.raw = raw.toString("hex");

const samples = new EventEmitter();
found.samples = [];
const subscription = await client.subscribeValue(
  "GVL.nDint",
  (data) => {
    found.samples.push(data.value);
    samples.emit("sample");
  },
  10,
);
if (!found.samples.length) await once(samples, "sample");
const next = once(samples, "sample");
await client.writeValue("GVL.nDint", 7);
await next;
await subscription.unsubscribe();

try {
  await client.readValue("GVL.nowhere");
} catch (failure) {
  found.unknown = failure.adsError?.errorCode ?? String(failure);
}
await client.disconnect();
console.log(JSON.stringify(found));
