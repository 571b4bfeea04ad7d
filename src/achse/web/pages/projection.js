/**
 * From space to the picture: a camera that turns about the middle of what is shown. Parallel
 * projection, so that lengths can be compared. X is to the right, Y away from us, Z upwards.
 */

const STEP = Math.PI / 24;
const [NEAREST, FARTHEST] = [50, 0.05];

/** Ways to look, by their names. */
export const VIEWS = {
  "3D": { turn: -Math.PI / 6, tilt: Math.PI / 6 },
  XY: { turn: 0, tilt: Math.PI / 2 },
  XZ: { turn: 0, tilt: 0 },
  YZ: { turn: -Math.PI / 2, tilt: 0 },
};

export class Camera {
  constructor(view = "3D") {
    this.look(view);
  }

  /** Look from that side, at all of it. */
  look(view) {
    this.view = Object.hasOwn(VIEWS, view) ? view : "3D";
    Object.assign(this, VIEWS[this.view], { zoom: 1 });
  }

  /** Turn about the upright axis and tilt, in radians. */
  move(turn, tilt) {
    this.turn = (this.turn + turn) % (2 * Math.PI);
    this.tilt = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.tilt + tilt));
  }

  magnify(factor) {
    this.zoom = Math.min(NEAREST, Math.max(FARTHEST, this.zoom * factor));
  }

  /** What a key does: arrows turn, + and - zoom, 0 shows all as at first. False: none of these. */
  key(name) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (Object.hasOwn(turns, name)) this.move(turns[name][0] * STEP, turns[name][1] * STEP);
    else if (name === "+" || name === "=") this.magnify(1.25);
    else if (name === "-") this.magnify(0.8);
    else if (name === "0") this.look(this.view);
    else return false;
    return true;
  }

  /** A function from [x, y, z] to [right, up, away], in the units of the points. */
  turned() {
    const [cosine, sine] = [Math.cos(this.turn), Math.sin(this.turn)];
    const [flat, steep] = [Math.cos(this.tilt), Math.sin(this.tilt)];
    return ([x, y, z]) => {
      const right = cosine * x - sine * y;
      const away = sine * x + cosine * y;
      return [right, away * steep + z * flat, away * flat - z * steep];
    };
  }

  /**
   * A function from a point to [x, y, depth] in pixels; the ball about `bounds` just fits, so that
   * turning does not change the size.
   */
  onto(width, height, bounds) {
    const { middle, radius } = ball(bounds);
    const scale = (this.zoom * 0.45 * Math.min(width, height)) / radius;
    const turned = this.turned();
    return (point) => {
      const [right, up, away] = turned([
        point[0] - middle[0], point[1] - middle[1], point[2] - middle[2],
      ]);
      return [width / 2 + scale * right, height / 2 - scale * up, away];
    };
  }
}

/** The least box that holds the finite points: {least, greatest}; null without one. */
export function boundsOf(points) {
  const least = [Infinity, Infinity, Infinity];
  const greatest = [-Infinity, -Infinity, -Infinity];
  let any = false;
  for (const point of points) {
    if (!(Number.isFinite(point[0]) && Number.isFinite(point[1]) && Number.isFinite(point[2]))) continue;
    any = true;
    for (let n = 0; n < 3; n += 1) {
      if (point[n] < least[n]) least[n] = point[n];
      if (point[n] > greatest[n]) greatest[n] = point[n];
    }
  }
  return any ? { least, greatest } : null;
}

function ball(bounds) {
  if (bounds === null) return { middle: [0, 0, 0], radius: 1 };
  const { least, greatest } = bounds;
  const middle = least.map((value, n) => (value + greatest[n]) / 2);
  const radius = Math.hypot(...greatest.map((value, n) => (value - least[n]) / 2));
  return { middle, radius: radius > 0 && Number.isFinite(radius) ? radius : 1 };
}
