/**
 * The pages, in the order of the navigation. To add one: a line here and a module beside this file.
 *
 * A page's module is loaded when it is first opened. It exports
 *
 *     export function mount(element, session) { …; return () => { … }; }
 *
 * `element` is an empty <div> for the page alone; `session` is what session.js describes (calls,
 * watches, the view in the URL, messages). The function that `mount` returns is called when the
 * page is left: it ends timers and listeners on `window`; its property `mayLeave`, if it has one, is
 * asked before that. Watches that the page made by `session.watch` end by themselves. Whatever comes
 * from the target is shown as text only: build elements by `h` of dom.js, never from strings of HTML.
 * No style attributes: the content policy refuses them (set classes, or `element.style.…` from code).
 *
 * - name: in the URL, `#name?key=value`; also the key of the page's title in the navigation
 * - title: in the navigation and as heading
 * - module: loaded on demand
 * - feature: one of `hello`'s features; without it the page is not offered
 *
 * @type {ReadonlyArray<{name: string, title: string, module: string, feature: string}>}
 */
export const PAGES = [
  { name: "overview", title: "Overview", module: "./overview.js", feature: "overview" },
  { name: "router", title: "Router", module: "./router.js", feature: "router" },
  { name: "axes", title: "Axes", module: "./axes.js", feature: "axes" },
  { name: "scope", title: "Scope", module: "./scope.js", feature: "scope" },
  { name: "symbols", title: "Symbols", module: "./symbols.js", feature: "symbols" },
  { name: "code", title: "Code", module: "./code.js", feature: "sources" },
  { name: "drives", title: "Drives and bus", module: "./drives.js", feature: "drives" },
  { name: "paths", title: "Cams and paths", module: "./paths.js", feature: "tables" },
  { name: "scene", title: "Machine", module: "./scene.js", feature: "scene" },
  { name: "log", title: "Log and traffic", module: "./log.js", feature: "log" },
  { name: "faults", title: "Faults", module: "./faults.js", feature: "faults" },
];

/** The features of each page that has parts of several: one of them is enough to show it. */
const ALSO = { drives: ["bus"], paths: ["channels"], log: ["traffic"] };

/** The pages that a target with these features has. */
export function offered(features) {
  const has = new Set(features);
  return PAGES.filter(
    ({ name, feature }) =>
      has.has(feature) || (ALSO[name] ?? []).some((other) => has.has(other)),
  );
}
