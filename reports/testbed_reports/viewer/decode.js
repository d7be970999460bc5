// Surfaces as encoding.py packs them, read again: whole numbers of 16 bits on lattices in patches.

const LARGEST = 65534;
const ABSENT = 65535;

/** Bytes of a gzip file given as base 64. */
async function inflate(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Points of a lattice, row by row: for each the whole coordinates i, j; and the number of point i, j. */
function latticeOf(sides, steps) {
  const places = [];
  const first = [];
  for (let i = 0; i <= steps; i++) {
    first.push(places.length);
    for (let j = 0; j <= (sides === 3 ? steps - i : steps); j++) places.push([i, j]);
  }
  return { sides, steps, places, number: (i, j) => first[i] + j };
}

/** Triangles of a lattice, counterclockwise, as in rendering/facets.py. */
function latticeTriangles({ sides, steps, number }) {
  const corners = [];
  for (let i = 0; i < steps; i++) {
    for (let j = 0; j < (sides === 3 ? steps - i : steps); j++) {
      corners.push(number(i, j), number(i + 1, j), number(i, j + 1));
      if (sides === 4 || i + j < steps - 1) corners.push(number(i + 1, j), number(i + 1, j + 1), number(i, j + 1));
    }
  }
  return corners;
}

/** Points of a lattice along side 0, 1, ... of the patch, as the side runs. */
function latticeSide({ sides, steps, number }, side) {
  const along = sides === 3
    ? [(k) => [k, 0], (k) => [steps - k, k], (k) => [0, steps - k]]
    : [(k) => [k, 0], (k) => [steps, k], (k) => [steps - k, steps], (k) => [0, steps - k]];
  return Array.from({ length: steps + 1 }, (_, k) => number(...along[side](k)));
}

/** Reads differences one after the other. */
class Words {
  constructor(bytes) {
    this.bytes = bytes;
    this.count = bytes.length / 2;
    this.next = 0;
  }

  difference() {
    const small = this.bytes[this.next] | (this.bytes[this.next + this.count] << 8);
    this.next += 1;
    return (small >> 1) ^ -(small & 1);
  }

  /** Numbers stored as differences from those before them. */
  row(length) {
    const codes = new Uint16Array(length);
    let last = 0;
    for (let k = 0; k < length; k++) {
      last = (last + this.difference()) & 0xffff;
      codes[k] = last;
    }
    return codes;
  }

  /** Numbers of 32 bits: a row of low and a row of high halves. */
  long(length) {
    const low = this.row(length);
    const high = this.row(length);
    return Uint32Array.from(low, (value, k) => value + high[k] * 65536);
  }

  /** Numbers on the lattices of patches, into codes[start + stride * number]. */
  lattices(lattice, patches, codes, start, stride) {
    const { places, number } = lattice;
    const recipes = places.map(([i, j]) => {
      if (i && j) return [number(i - 1, j), number(i, j - 1), number(i - 1, j - 1)];
      if (i + j > 1) {
        const last = number(Math.max(i - 1, 0), Math.max(j - 1, 0));
        return [last, last, number(Math.max(i - 2, 0), Math.max(j - 2, 0))];
      }
      return i + j ? [0, 0, 0] : null;
    });
    let corner = 0;
    for (let patch = 0; patch < patches; patch++) {
      const at = (k) => codes[start + stride * (patch * places.length + k)];
      for (let k = 0; k < places.length; k++) {
        const recipe = recipes[k];
        const predicted = recipe ? at(recipe[0]) + at(recipe[1]) - at(recipe[2]) : corner;
        codes[start + stride * (patch * places.length + k)] = (predicted + this.difference()) & 0xffff;
      }
      corner = at(0);
    }
  }
}

/** A surface from its text and what is known about it: arrays over all points, triangles, edges. */
async function unpack(text, about) {
  const words = new Words(await inflate(text));
  const parts = about.parts.map(([sides, patches, places]) => ({ patches, places, lattice: latticeOf(sides, about.steps) }));
  const total = parts.reduce((sum, part) => sum + part.patches * part.lattice.places.length, 0);
  const fields = ["gauss", "mean", "distance"].filter((name) => name in about.ranges);
  const surface = {
    about,
    parts,
    places: new Uint16Array(3 * total),
    normals: new Uint16Array(2 * total),
    codes: Object.fromEntries(fields.map((name) => [name, new Uint16Array(total)])),
  };
  let point = 0;
  let patch = 0;
  for (const part of parts) {
    const { lattice, patches } = part;
    const sides = lattice.sides;
    part.firstPoint = point;
    part.firstPatch = patch;
    for (let axis = 0; axis < 3; axis++) words.lattices(lattice, patches, surface.places, 3 * point + axis, 3);
    for (let axis = 0; axis < 2; axis++) words.lattices(lattice, patches, surface.normals, 2 * point + axis, 2);
    for (const name of fields) words.lattices(lattice, patches, surface.codes[name], point, 1);
    part.faces = words.long(patches);
    part.which = words.long(patches);
    const corners = words.row(2 * sides * part.places);
    part.corners = (kind) => Array.from({ length: sides }, (_, corner) =>
      [0, 1].map((axis) => corners[(2 * corner + axis) * part.places + kind] / LARGEST));
    point += patches * lattice.places.length;
    patch += patches;
  }
  const [low, high] = about.box;
  surface.size = Math.max(...high.map((value, axis) => value - low[axis])) || 1;
  surface.origin = low.map((value, axis) => value + (high[axis] - value) / 2);
  surface.extent = high.map((value, axis) => (value - low[axis]) / surface.size);
  surface.points = points(surface);
  surface.triangles = triangles(surface);
  readEdges(surface, words);
  return surface;
}

/** Coordinates of points from the middle of the surface, in its size, so that 32 bits are enough; NaN for those without. */
function points({ places, extent }) {
  return Float32Array.from(places, (code, k) => (code === ABSENT ? NaN : (code / LARGEST - 0.5) * extent[k % 3]));
}

/** Coordinates of a point as points() has them. */
function relative(surface, point) {
  return point.map((value, axis) => (value - surface.origin[axis]) / surface.size);
}

/** Corners of all triangles whose points are known. */
function triangles({ parts, points }) {
  const corners = [];
  for (const { lattice, patches, firstPoint } of parts) {
    const own = latticeTriangles(lattice);
    for (let patch = 0; patch < patches; patch++) {
      const first = firstPoint + patch * lattice.places.length;
      for (let k = 0; k < own.length; k += 3) {
        const three = [first + own[k], first + own[k + 1], first + own[k + 2]];
        if (three.every((corner) => !Number.isNaN(points[3 * corner]))) corners.push(...three);
      }
    }
  }
  return Uint32Array.from(corners);
}

/** Pieces of edges: surface.segments has both ends and the normal angles there, -1 on the boundary, 8 numbers each. */
function readEdges(surface, words) {
  const { parts, about } = surface;
  const { steps } = about;
  const patches = words.long(about.edges);
  const sides = words.row(about.edges);
  const angles = "jump" in about.ranges ? words.row(about.edges * (steps + 1)) : null;
  const runs = parts.map(({ lattice }) => Array.from({ length: lattice.sides }, (_, side) => latticeSide(lattice, side)));
  const angle = (k) => (angles && angles[k] !== ABSENT ? decoded(angles[k], about.ranges.jump) : -1);
  const pieces = new Float32Array(about.edges * steps * 8);
  for (let edge = 0; edge < about.edges; edge++) {
    const which = parts.findLastIndex((part) => part.firstPatch <= patches[edge]);
    const { firstPoint, firstPatch, lattice } = parts[which];
    const first = firstPoint + (patches[edge] - firstPatch) * lattice.places.length;
    const run = runs[which][sides[edge]];
    for (let k = 0; k < steps; k++) {
      const start = 3 * (first + run[k]);
      const end = 3 * (first + run[k + 1]);
      const at = edge * (steps + 1) + k;
      pieces.set(surface.points.subarray(start, start + 3), (edge * steps + k) * 8);
      pieces.set(surface.points.subarray(end, end + 3), (edge * steps + k) * 8 + 3);
      pieces.set([angle(at), angle(at + 1)], (edge * steps + k) * 8 + 6);
    }
  }
  surface.segments = pieces;
}

/** The value that a code of a field stands for. */
function decoded(code, [low, high, unit]) {
  return code === ABSENT ? NaN : unit * Math.sinh(low + (code / LARGEST) * (high - low));
}

/** The unit normal at a point. */
function normalOf(surface, point) {
  const [a, b] = [surface.normals[2 * point], surface.normals[2 * point + 1]];
  if (a === ABSENT || b === ABSENT) return [NaN, NaN, NaN];
  let [x, y] = [(2 * a) / LARGEST - 1, (2 * b) / LARGEST - 1];
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}
