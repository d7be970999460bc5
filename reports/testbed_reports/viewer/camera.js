// Where surfaces are seen from, as in rendering/camera.py: an orthographic camera, z upwards; and what a place shows.

class Camera {
  constructor({ azimuth, elevation, centre, width, radius }) {
    Object.assign(this, { azimuth, elevation, centre: [...centre], width, radius });
    this.home = { azimuth, elevation, centre, width };
  }

  reset() {
    Object.assign(this, this.home, { centre: [...this.home.centre] });
  }

  /** Directions to the right, upwards and towards the viewer. */
  get axes() {
    const [a, e] = [this.azimuth, this.elevation].map((angle) => (angle * Math.PI) / 180);
    const [ca, sa, ce, se] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)];
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  }

  turn(right, up) {
    this.azimuth = (this.azimuth + right) % 360;
    this.elevation = Math.max(-90, Math.min(90, this.elevation + up));
  }

  /** Move by a share of the picture. */
  move(right, up) {
    const { axes, width } = this;
    this.centre = this.centre.map((value, k) => value - width * (right * axes[0][k] + up * axes[1][k]));
  }

  /** Make everything larger by a factor; the place at (x, y), from -1 to 1, stays. */
  zoom(factor, x = 0, y = 0) {
    const width = Math.max(this.home.width / 200, Math.min(this.home.width * 5, this.width / factor));
    const share = (this.width / width - 1) / 2;
    this.width = width;
    this.move(-x * share, -y * share);
  }
}

/** The triangle nearest to the viewer at (x, y), from -1 to 1, and the weights of its corners; or null. */
function pick(surface, camera, x, y) {
  const { points, triangles } = surface;
  const [right, up, towards] = camera.axes;
  const [cx, cy, cz] = relative(surface, camera.centre);
  const along = (axis, k) => axis[0] * (points[k] - cx) + axis[1] * (points[k + 1] - cy) + axis[2] * (points[k + 2] - cz);
  const px = (x * camera.width) / 2 / surface.size;
  const py = (y * camera.width) / 2 / surface.size;
  const count = points.length / 3;
  const sx = new Float32Array(count);
  const sy = new Float32Array(count);
  for (let k = 0; k < count; k++) {
    sx[k] = along(right, 3 * k) - px;
    sy[k] = along(up, 3 * k) - py;
  }
  let best = null;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const wa = sx[b] * sy[c] - sx[c] * sy[b];
    const wb = sx[c] * sy[a] - sx[a] * sy[c];
    const wc = sx[a] * sy[b] - sx[b] * sy[a];
    if (!((wa >= 0 && wb >= 0 && wc >= 0) || (wa <= 0 && wb <= 0 && wc <= 0))) continue;
    const sum = wa + wb + wc;
    if (sum === 0) continue;
    const weights = [wa / sum, wb / sum, wc / sum];
    const depth = weights[0] * along(towards, 3 * a) + weights[1] * along(towards, 3 * b) + weights[2] * along(towards, 3 * c);
    if (!best || depth > best.depth) best = { corners: [a, b, c], weights, depth };
  }
  return best;
}

/** What is known at a place that was picked: point, normal, values, face and place in it. */
function probe(surface, { corners, weights }) {
  const blend = (values) => values[0].map((_, k) => weights.reduce((sum, weight, corner) => sum + weight * values[corner][k], 0));
  const point = blend(corners.map((k) => [...surface.points.subarray(3 * k, 3 * k + 3)]));
  const normal = blend(corners.map((k) => normalOf(surface, k)));
  const length = Math.hypot(...normal);
  const values = Object.fromEntries(Object.entries(surface.codes).map(([name, codes]) =>
    [name, blend(corners.map((k) => [decoded(codes[k], surface.about.ranges[name])]))[0]]));
  const part = surface.parts.findLast(({ firstPoint }) => firstPoint <= corners[0]);
  const { lattice, firstPoint } = part;
  const patch = Math.floor((corners[0] - firstPoint) / lattice.places.length);
  const [u, v] = blend(corners.map((k) => lattice.places[(k - firstPoint) % lattice.places.length])).map((value) => value / lattice.steps);
  const around = part.corners(part.which[patch]);
  const shares = lattice.sides === 3 ? [1 - u - v, u, v] : [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v];
  const at = [0, 1].map((axis) => shares.reduce((sum, share, k) => sum + share * around[k][axis], 0));
  const triangular = surface.about.sides === 3;
  return {
    point: point.map((value, axis) => surface.origin[axis] + surface.size * value),
    normal: normal.map((value) => value / length),
    values,
    face: part.faces[patch],
    place: triangular ? [1 - at[0] - at[1], ...at] : at,
  };
}
