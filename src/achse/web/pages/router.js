/** Router: the targets that programs reach through it, and these programs. */

import { h, panel } from "./dom.js";
import { count, word } from "./format.js";
import { Facts, LiveTable, column, lamp } from "./table.js";
import { fragment } from "./view.js";

export function mount(element, session) {
  const router = new Facts();
  const targets = new LiveTable({
    caption: "Targets", key: ({ name }) => name, empty: ["No target is configured."],
    columns: [
      column("Target", ({ name }) => name, { head: true }),
      column("NetId", ({ net_id: netId }) => netId || "–", { quiet: true }),
      { title: "State", make: stateLamp },
      column("Programs", ({ clients }) => count(clients), { numeric: true }),
      column("Subscriptions", ({ subscriptions }) => count(subscriptions), { numeric: true }),
      column("Handles", ({ handles }) => count(handles), { numeric: true }),
      column("Files", ({ files }) => count(files), { numeric: true, quiet: true }),
      column("Pending", ({ pending }) => count(pending), { numeric: true }),
      column("Waiting", ({ waiting }) => count(waiting), { numeric: true, quiet: true }),
      column("Losses", ({ losses }) => count(losses),
        { numeric: true, kind: ({ losses }) => (losses > 0 ? "warn" : "") }),
      column("Refused", ({ refused }) => count(refused),
        { numeric: true, kind: ({ refused }) => (refused > 0 ? "warn" : "") }),
      column("50 %", ({ latency_50: half }) => milliseconds(half), { numeric: true }),
      column("99 %", ({ latency_99: most }) => milliseconds(most), { numeric: true }),
      column("What to do", ({ advice }) => advice || "–", { quiet: true }),
    ],
  });
  const programs = new LiveTable({
    caption: "Programs", key: ({ address, peer }) => `${address}|${peer}`,
    empty: ["No program has asked for anything yet. It connects to this computer and asks for the NetId of a target."],
    columns: [
      column("Program", ({ address }) => address, { head: true }),
      column("From", ({ peer }) => peer ?? "–", { quiet: true }),
      column("Requests", ({ requests }) => count(requests), { numeric: true }),
      column("Errors", ({ errors }) => count(errors),
        { numeric: true, kind: ({ errors }) => (errors > 0 ? "warn" : "") }),
    ],
  });
  element.append(
    h("div", { class: "grid" },
      panel("Router", router.element,
        h("p", {}, h("a", { href: fragment("log", { show: "traffic" }) }, "Show the traffic"))),
      panel("Programs", programs.element),
      h("div", { class: "wide" }, panel("Targets", targets.element))),
  );
  session.draw("router", { every: 0.5 }, (now) => {
    router.update([
      ["NetId", session.hello.target || "–"],
      ["Version", session.hello.version || "–"],
      ["Connections", count(now.connections)],
      ["Connections refused", count(now.connections_refused), now.connections_refused > 0 ? "warn" : ""],
      ["Connections cut off", count(now.connections_cut_off), now.connections_cut_off > 0 ? "warn" : ""],
      ["Lost frames", count(now.lost_frames), now.lost_frames > 0 ? "warn" : ""],
      ["Requests without a right", count(now.requests_denied), now.requests_denied > 0 ? "warn" : ""],
    ]);
    targets.update(now.targets ?? []);
    programs.update(now.clients ?? []);
  });
}

function milliseconds(time) {
  return time > 0 ? `${(1e3 * time).toFixed(2)} ms` : "–";
}

function stateLamp() {
  const [element, show] = lamp();
  return [element, ({ state }) => show(KINDS[state] ?? "off", word(state))];
}

const KINDS = { ready: "on", searching: "warn", refused: "bad", unreachable: "bad" };
