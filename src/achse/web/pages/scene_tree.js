/** The scene of a machine: what its file may hold, and where its parts are. Lengths are free, angles in degrees. */

export const MOST_PARTS = 500;
const MOST_POINTS = 2000;
const LARGEST = 1e9;
const ROUND = 20;
const COLOURS = ["raised", "accent", "good", "warn", "bad", "dim"];

/** What is wrong with a scene: where, what was expected. */
export class SceneError extends Error {}

/** The parts of a scene, parents before children. Throws SceneError. */
export function partsOf(scene) {
  const parts = scene?.parts;
  if (!Array.isArray(parts)) throw new SceneError("scene: expected an object with a list \"parts\"");
  if (parts.length > MOST_PARTS) throw new SceneError(`scene: expected up to ${MOST_PARTS} parts, got ${parts.length}`);
  const known = new Map();
  parts.forEach((given, n) => {
    const part = checked(given, `parts[${n}]`);
    if (known.has(part.name)) throw new SceneError(`parts[${n}].name: expected each name once, got ${part.name}`);
    known.set(part.name, part);
  });
  const ordered = [];
  const states = new Map();
  for (let part of known.values()) {
    const way = [];
    while (part && !states.has(part.name)) {
      states.set(part.name, "open");
      way.push(part);
      if (part.parent === null) break;
      const parent = known.get(part.parent);
      if (!parent) throw new SceneError(`${part.name}.parent: expected the name of a part, got ${part.parent}`);
      if (states.get(parent.name) === "open") throw new SceneError(`${part.name}.parent: ${parent.name} hangs on itself`);
      part = parent;
    }
    for (const each of way.reverse()) {
      states.set(each.name, "done");
      ordered.push(each);
    }
  }
  return ordered;
}

function checked(given, where) {
  if (typeof given !== "object" || given === null) throw new SceneError(`${where}: expected an object`);
  const { name, parent = null, at = [0, 0, 0], turn = [0, 0, 0], joint = null, shape = null, colour = "raised", lamp = null } = given;
  if (typeof name !== "string" || !name || name.length > 80) throw new SceneError(`${where}.name: expected a text of 1 to 80 characters`);
  if (parent !== null && typeof parent !== "string") throw new SceneError(`${where}.parent: expected the name of a part`);
  if (!COLOURS.includes(colour)) throw new SceneError(`${where}.colour: expected one of ${COLOURS.join(", ")}`);
  if (lamp !== null && (typeof lamp !== "string" || !lamp || lamp.length > 250)) throw new SceneError(`${where}.lamp: expected the name of a symbol`);
  const part = { name, parent, colour, lamp, at: vector(at, `${where}.at`), turn: vector(turn, `${where}.turn`), joint: null, lines: [] };
  if (joint !== null) {
    const { kind, axis, along = [0, 0, 1], scale = 1, limits = null } = joint;
    if (kind !== "linear" && kind !== "rotary") throw new SceneError(`${where}.joint.kind: expected linear or rotary`);
    if (typeof axis !== "string" && !Number.isInteger(axis)) throw new SceneError(`${where}.joint.axis: expected the name or id of an axis`);
    const direction = vector(along, `${where}.joint.along`);
    const length = Math.hypot(...direction);
    if (length === 0) throw new SceneError(`${where}.joint.along: expected a direction`);
    part.joint = {
      kind, axis, along: direction.map((value) => value / length), scale: finite(scale, `${where}.joint.scale`),
      limits: limits === null ? null : pair(limits, `${where}.joint.limits`),
    };
  }
  if (shape !== null) part.lines = linesOf(shape, `${where}.shape`);
  return part;
}

function finite(value, where) {
  if (typeof value !== "number" || !(Math.abs(value) <= LARGEST)) throw new SceneError(`${where}: expected a number of at most ${LARGEST}`);
  return value;
}

function vector(value, where) {
  if (!Array.isArray(value) || value.length !== 3) throw new SceneError(`${where}: expected three numbers`);
  return value.map((each, n) => finite(each, `${where}[${n}]`));
}

function pair(value, where) {
  if (!Array.isArray(value) || value.length !== 2) throw new SceneError(`${where}: expected two numbers`);
  const [least, greatest] = value.map((each, n) => finite(each, `${where}[${n}]`));
  if (!(least < greatest)) throw new SceneError(`${where}: expected the lower one first`);
  return [least, greatest];
}

/** A shape as lines of points: a box stands on its middle, a cylinder along Z from its foot. */
function linesOf(shape, where) {
  const { kind } = shape;
  if (kind === "box") {
    const [x, y, z] = vector(shape.size, `${where}.size`).map((value) => value / 2);
    const ring = (height) => [[-x, -y, height], [x, -y, height], [x, y, height], [-x, y, height], [-x, -y, height]];
    return [ring(-z), ring(z), ...ring(z).slice(1).map(([right, away]) => [[right, away, -z], [right, away, z]])];
  }
  if (kind === "cylinder") {
    const radius = finite(shape.radius, `${where}.radius`);
    const length = finite(shape.length, `${where}.length`);
    const ring = (height) => Array.from({ length: ROUND + 1 }, (_, n) =>
      [radius * Math.cos((2 * Math.PI * n) / ROUND), radius * Math.sin((2 * Math.PI * n) / ROUND), height]);
    return [ring(0), ring(length), ...[0, 5, 10, 15].map((n) => [ring(0)[n], ring(length)[n]])];
  }
  if (kind === "line") {
    if (!Array.isArray(shape.points) || shape.points.length > MOST_POINTS) throw new SceneError(`${where}.points: expected up to ${MOST_POINTS} points`);
    return [shape.points.map((point, n) => vector(point, `${where}.points[${n}]`))];
  }
  throw new SceneError(`${where}.kind: expected box, cylinder or line`);
}

/** Is an axis at a limit of a joint, or beyond it? */
export function atLimit({ limits }, position) {
  return limits !== null && Number.isFinite(position) && !(position > limits[0] && position < limits[1]);
}

/** The way of a joint from limit to limit, as its origin goes: a line, for a rotary one two spokes of `radius`. */
function wayOf(joint, radius) {
  const { kind, along, limits } = joint;
  if (kind === "linear") return [limits.map((value) => motion(joint, value)([0, 0, 0]))];
  const [x, y, z] = along;
  // any direction across the one that it turns about
  const across = Math.abs(z) < 0.9 ? [y, -x, 0] : [0, z, -y];
  const long = radius / Math.hypot(...across);
  const spoke = across.map((value) => value * long);
  return limits.map((value) => [[0, 0, 0], motion(joint, value)(spoke)]);
}

/** Lines in space of all parts, and of their ways between limits; `position(axis)` gives a number. */
export function placed(parts, position) {
  const places = new Map();
  return parts.map((part) => {
    const above = places.get(part.parent) ?? ((point) => point);
    const mounted = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis, n) => turning(axis, (part.turn[n] * Math.PI) / 180));
    const moved = part.joint === null ? (point) => point : motion(part.joint, position(part.joint.axis));
    const place = (point) => above(mounted.reduce((at, turn) => turn(at), moved(point)).map((value, n) => value + part.at[n]));
    places.set(part.name, place);
    const still = (point) => above(mounted.reduce((at, turn) => turn(at), point).map((value, n) => value + part.at[n]));
    const ways = part.joint?.limits ? wayOf(part.joint, reach(part.lines)) : [];
    return { part, lines: part.lines.map((line) => line.map(place)), ways: ways.map((line) => line.map(still)) };
  });
}

/** The distance of the farthest point of some lines. */
function reach(lines) {
  return lines.flat().reduce((most, point) => Math.max(most, Math.hypot(...point)), 0) || 1;
}

function motion({ kind, along, scale }, position) {
  const way = (Number.isFinite(position) ? position : 0) * scale;
  if (kind === "linear") return (point) => point.map((value, n) => value + way * along[n]);
  return turning(along, (way * Math.PI) / 180);
}

/** Turn about a direction of length 1 (Rodrigues). */
function turning([x, y, z], angle) {
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  return ([a, b, c]) => {
    const share = (x * a + y * b + z * c) * (1 - cosine);
    return [
      a * cosine + (y * c - z * b) * sine + x * share,
      b * cosine + (z * a - x * c) * sine + y * share,
      c * cosine + (x * b - y * a) * sine + z * share,
    ];
  };
}
