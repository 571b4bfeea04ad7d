// Read a structure by name, and write it with another X.
import { Client } from "ads-client";

const client = new Client({ hideConsoleWarnings: true, ...JSON.parse(process.argv[2]) });
await client.connect();
const { value } = await client.readValue("GVL.stPoint");
await client.writeValue("GVL.stPoint", { ...value, fX: 4.5 });
await client.disconnect();
console.log(JSON.stringify(value));
