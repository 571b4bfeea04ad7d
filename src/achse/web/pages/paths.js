/** Cams and paths: cam tables as curves, channels with the way of their tools. */

import { mountCams } from "./cams.js";
import { mountChannels } from "./channels.js";
import { h } from "./dom.js";

export function mount(element, session) {
  const ends = [];
  for (const [feature, label, begin] of [
    ["channels", "Channels", mountChannels], ["tables", "Cam tables", mountCams],
  ]) {
    if (!session.has(feature)) continue;
    const part = h("section", { class: "above", "aria-label": label });
    element.append(part);
    ends.push(begin(part, session));
  }
  return () => ends.forEach((end) => end());
}
