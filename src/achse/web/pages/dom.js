/** Elements made in code. Text is always text: nothing here takes HTML. */

const REFUSED = /^(style|srcdoc|innerhtml|outerhtml|on.*)$/i;

/**
 * `h("button", {class: "plain", onclick: f}, "Reset")`. Functions under `on…` are listeners, true
 * and false switch attributes, null leaves one out; children are nodes, texts or lists of them.
 */
export function h(tag, values = {}, ...children) {
  return fill(document.createElement(tag), values, children);
}

/** The same for a picture: `svg("path", {d: "…"})`. */
export function svg(tag, values = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), values, children);
}

function fill(element, values, children) {
  for (const [name, value] of Object.entries(values)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on") && typeof value === "function") {
      element.addEventListener(name.slice(2), value);
    } else if (REFUSED.test(name)) {
      throw new TypeError(`${name}: set classes and listeners, not texts that are run`);
    } else if (name === "value") {
      element.value = value;
    } else {
      element.setAttribute(name, value === true ? "" : String(value));
    }
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== false));
  return element;
}

/** A text changes only when it is another one: this keeps live tables cheap. */
export function show(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** An attribute, or none of it for null and false. */
export function mark(element, name, value) {
  if (value === null || value === undefined || value === false) element.removeAttribute(name);
  else if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
}

/** A link to an explanation; addresses that are not of the web become text. */
export function link(address, text) {
  const safe = web(address);
  if (safe === null) return document.createTextNode(text);
  return h("a", { href: safe, target: "_blank", rel: "noopener noreferrer" }, text);
}

/** The address if it is of the web or of this server, else null. */
export function web(address) {
  if (!address) return null;
  try {
    const { protocol, href } = new URL(address, globalThis.location?.href ?? "http://localhost/");
    return protocol === "http:" || protocol === "https:" ? href : null;
  } catch {
    return null;
  }
}

/** A labelled input: the label is the text before it, the unit a node or nothing. */
export function field(label, input, unit = null) {
  return h("label", { class: "field" }, h("span", {}, label), input, unit);
}

/** A button within a sentence: `["No axis is like this. ", act("Show all", run)]`. */
export function act(text, run) {
  return h("button", { type: "button", class: "small", onclick: run }, text);
}

/** A command or a line of a file, to be copied. */
export function code(text) {
  return h("code", {}, text);
}

/** A part of a page with a heading of its own. */
export function panel(title, ...content) {
  return h("section", { class: "panel" }, h("h2", {}, title), ...content);
}

/** Run `f` once after the calls have been quiet for `ms`. */
export function quiet(f, ms = 200) {
  let timer = null;
  const call = (...values) => {
    clearTimeout(timer);
    timer = setTimeout(() => f(...values), ms);
  };
  call.cancel = () => clearTimeout(timer);
  return call;
}

/** Is the user typing? Then keys without Ctrl belong to the field. */
export function typing(target) {
  return (
    target instanceof HTMLElement &&
    (target.isContentEditable || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName))
  );
}
