/**
 * What is shown, in the URL's fragment: `#axes?axis=2&group=limits`. A colleague who gets the
 * address sees the same.
 */

/** @returns {{page: string, values: URLSearchParams}} */
export function parse(fragment) {
  const text = fragment.replace(/^#/, "");
  const mark = text.indexOf("?");
  let page = mark < 0 ? text : text.slice(0, mark);
  try {
    page = decodeURIComponent(page);
  } catch {
    page = ""; // a broken % sequence names no page
  }
  return { page, values: new URLSearchParams(mark < 0 ? "" : text.slice(mark + 1)) };
}

/** The fragment of a page with these values; empty ones are left out. */
export function fragment(page, values = {}) {
  const kept = new URLSearchParams();
  for (const [key, value] of Object.entries(values)) {
    if (value !== null && value !== undefined && value !== "") kept.set(key, String(value));
  }
  const text = kept.toString();
  return `#${encodeURIComponent(page)}${text ? `?${text}` : ""}`;
}

/** The view of one page; reading and changing it does not mount the page anew. */
export class View {
  constructor(place = globalThis.location, past = globalThis.history) {
    this._place = place;
    this._past = past;
  }

  get page() {
    return parse(this._place.hash).page;
  }

  /** The value of a key, or `otherwise`. */
  get(key, otherwise = "") {
    return parse(this._place.hash).values.get(key) ?? otherwise;
  }

  /** Change values in place: `view.set({search: "fPos", axis: null})`. */
  set(changes) {
    const { page, values } = parse(this._place.hash);
    const next = fragment(page, { ...Object.fromEntries(values), ...changes });
    if (next !== this._place.hash) this._past.replaceState(null, "", next);
  }

  /** Go to a page: a new entry in the browser's history. */
  go(page, values = {}) {
    this._place.hash = fragment(page, values);
  }
}
