/** The rows from one place of a ring to another as text: times and columns, gaps empty. */
export function csv(ring, titles, columns, from, to) {
  const lines = [["time in s", ...titles].map(quoted).join(",")];
  const parts = [0, ...columns].map((column) => ring.part(column, from, to));
  for (let n = 0; n < parts[0].length; n += 1) {
    lines.push(parts.map((part) => (Number.isNaN(part[n]) ? "" : String(part[n]))).join(","));
  }
  return `${lines.join("\r\n")}\r\n`;
}

/** Names that a spreadsheet would take for a formula stay texts. */
function quoted(text) {
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

/** Let the browser save it. */
export function save(name, blob) {
  const address = URL.createObjectURL(blob);
  follow(address, name);
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

export function follow(address, name = "") {
  const a = document.createElement("a");
  a.href = address;
  a.download = name;
  document.body.append(a);
  a.click();
  a.remove();
}

/** The charts below each other as one picture. */
export function picture(canvases, ground) {
  const all = document.createElement("canvas");
  all.width = Math.max(...canvases.map(({ width }) => width));
  all.height = canvases.reduce((sum, { height }) => sum + height, 0);
  const ctx = all.getContext("2d");
  ctx.fillStyle = ground;
  ctx.fillRect(0, 0, all.width, all.height);
  let top = 0;
  for (const canvas of canvases) {
    ctx.drawImage(canvas, 0, top);
    top += canvas.height;
  }
  return new Promise((resolve) => all.toBlob(resolve, "image/png"));
}
