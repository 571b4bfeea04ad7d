/** Texts of the code page: offsets of places, units whose values are shown. */

/** The number of lines of a text. */
export function lines(text) {
  return text.split("\n").length;
}

/** The offset of a line and column, both from 1; places outside are the nearest inside. */
export function jump(text, line, column) {
  const all = text.split("\n");
  const row = Math.min(Math.max(line, 1), all.length) - 1;
  const before = all.slice(0, row).reduce((sum, each) => sum + each.length + 1, 0);
  // columns count characters, offsets UTF-16 units
  return before + [...all[row]].slice(0, Math.max(column, 1) - 1).join("").length;
}

/** Has one of the texts changed? */
export function drafted(saved, current) {
  return saved.length !== current.length || saved.some((text, n) => text !== current[n]);
}

/**
 * Names of programs and lists of global variables that a file declares: a text file names them in its code, the others
 * in their sections.
 */
export function valuesOf(sections) {
  const names = new Set();
  for (const { name, kind, text } of sections) {
    if (kind === "implementation") continue;
    const code = text.replace(/\(\*[\s\S]*?\*\)|\/\/.*|'(?:[^'$\n]|\$.)*'/g, " ");
    for (const found of code.matchAll(/^\s*PROGRAM\s+(\w+)/gim)) names.add(found[1]);
    if (name && /^\s*(?:\{[^}]*\}\s*)*VAR_GLOBAL\b/i.test(code)) names.add(name);
  }
  return [...names];
}
