// Run flow.json without Node-RED: node run-flow.mjs HOST NETID [debug messages until the end]
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";

const { Client } = createRequire(import.meta.url)("ads-client");
const [host, netId, wanted = "Infinity"] = process.argv.slice(2);
const flow = JSON.parse(await readFile(new URL("flow.json", import.meta.url), "utf8"));
const byId = new Map(flow.map((node) => [node.id, node]));

// Settings that are left empty in the node are the package's own.
const settings = Object.fromEntries(
  Object.entries(flow.find((node) => node.type === "ads-client-connection")).filter(
    ([key, value]) => value !== "" && !["id", "type", "name"].includes(key),
  ),
);
const client = new Client({
  ...settings,
  routerAddress: host ?? settings.routerAddress,
  targetAmsNetId: netId ?? settings.targetAmsNetId,
});

let shown = 0;
let end;
const ended = new Promise((resolve) => (end = resolve));

const kinds = {
  async function(node, msg, send) {
    const result = new Function("msg", node.func)(msg);
    if (result) send(result);
  },
  async "ads-client-write-value"(node, msg, send) {
    const { value } = await client.writeValue(node.path, msg.payload, node.autoFill);
    send({ ...msg, payload: value });
  },
  async "ads-client-read-value"(node, msg, send) {
    send({ ...msg, payload: (await client.readValue(node.path)).value });
  },
  async debug(node, msg) {
    console.log(JSON.stringify({ node: node.name, payload: msg.payload }));
    if (++shown >= Number(wanted)) end();
  },
};

function from(node) {
  return (msg) => {
    for (const id of node.wires.flat()) {
      const next = byId.get(id);
      kinds[next.type](next, { ...msg }, from(next)).catch((failure) => end(failure));
    }
  };
}

await client.connect();
for (const node of flow) {
  if (node.type === "ads-client-subscribe-value") {
    await client.subscribe({
      target: node.path,
      callback: (data) => from(node)({ payload: data.value }),
      cycleTime: Number(node.cycleTime),
      sendOnChange: node.mode === "onchange",
      maxDelay: node.maxDelay,
    });
  } else if (node.type === "inject" && node.once) {
    from(node)({ payload: Date.now() });
  }
}
const failure = await ended;
await client.disconnect();
if (failure) throw failure;
