/** Calling methods of function blocks: a dialog with a field for each input. */

import { field, h } from "./dom.js";

/** Ask for the methods of an instance and let the user call them. */
export async function callMethod(session, name) {
  const methods = await session.do("symbols.methods", { name });
  if (methods === undefined) return;
  const dialog = h("dialog", { "aria-labelledby": "methods-title" },
    h("h2", { id: "methods-title" }, `Methods of ${name}`),
    methods.length ? null : h("p", { class: "dim" }, "It has no method that may be called."),
    methods.map((method) => form(session, name, method)));
  const close = h("button", { type: "button" }, "Close");
  close.addEventListener("click", () => dialog.close());
  dialog.append(close);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

function form(session, name, { name: method, returns, parameters = [] }) {
  const inputs = parameters.filter(({ direction }) => direction !== "out");
  const fields = inputs.map(({ name: key, type, comment }) => {
    const input = h("input", { type: "text", class: "mono", name: key, title: comment ?? null });
    return field(`${key} : ${type}`, input);
  });
  const result = h("p", { class: "mono", role: "status" });
  const element = h("form", { class: "panel" },
    h("h3", {}, `${method}${returns ? ` : ${returns}` : ""}`), fields,
    h("div", { class: "row" },
      h("button", { type: "submit", class: "small main", disabled: !session.control }, "Call"), result));
  element.addEventListener("submit", async (event) => {
    event.preventDefault();
    const given = Object.fromEntries(new FormData(element));
    result.textContent = "";
    const answer = await session.do("symbols.call", { name: `${name}#${method}`, arguments: given });
    if (answer === undefined) return;
    const outputs = Object.entries(answer.outputs ?? {}).map(([key, text]) => `${key} = ${text}`);
    result.textContent = [answer.result ?? "done", ...outputs].join(", ");
  });
  return element;
}
