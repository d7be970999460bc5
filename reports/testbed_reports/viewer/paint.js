// Drawing with WebGL: one context for all surfaces of the page, into a canvas that nobody sees and everybody copies.

const SURFACE_VERTEX = `#version 300 es
precision highp float;
in vec3 place; in vec2 fold; in float code;
uniform vec3 extent, centre, span; uniform mat3 axes; uniform vec4 lens;
out vec3 normal; out float value; out float missing;
void main() {
  vec3 seen = axes * ((place * (65535.0 / 65534.0) - 0.5) * extent - centre);
  gl_Position = vec4(seen * lens.xyz, 1.0);
  vec2 f = 2.0 * fold * (65535.0 / 65534.0) - 1.0;
  vec3 n = vec3(f, 1.0 - abs(f.x) - abs(f.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(f.yx)) * vec2(f.x < 0.0 ? -1.0 : 1.0, f.y < 0.0 ? -1.0 : 1.0);
  normal = axes * normalize(n);
  missing = fold.x > 0.999995 || code > 65534.5 ? 1.0 : 0.0;
  value = code > 65534.5 ? 0.0 : span.z * sinh(span.x + code / 65534.0 * (span.y - span.x));
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 normal; in float value; in float missing;
uniform int style; uniform vec2 limits; uniform float row, hatch, bands;
uniform sampler2D palettes; uniform vec3 outer, inner, absent, light;
out vec4 colour;
const float PI = 3.14159265358979;
float dark(float phase) {  // 1 in bands of even number, blurred over a pixel
  float wide = max(fwidth(phase), 1e-6), place = mod(phase, 2.0);
  float away = place < 0.5 ? place : place < 1.5 ? 1.0 - place : place - 2.0;
  return clamp(0.5 + away / wide, 0.0, 1.0);
}
void main() {
  vec3 n = normalize(normal);
  bool behind = n.z < 0.0;
  if (behind) n = -n;
  vec3 shown;
  if (style == 1) {
    float t = (value - limits.x) / (limits.y - limits.x);
    shown = texture(palettes, vec2((clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0, row)).rgb;
    shown *= 0.86 + 0.14 * max(dot(n, light), 0.0);
    bool beyond = t < -1e-4 || t > 1.0001;
    if (beyond && mod(floor(gl_FragCoord.x) + floor(gl_FragCoord.y), 6.0 * hatch) < hatch) shown *= 0.35;
  } else if (style >= 2) {
    float phase = style == 2
      ? degrees(acos(clamp(dot(n, light), -1.0, 1.0))) / bands
      : bands * (asin(clamp(2.0 * n.z * n.y, -1.0, 1.0)) / PI + 0.5);
    shown = mix(behind ? inner : vec3(0.88, 0.89, 0.9), vec3(0.13, 0.15, 0.2), dark(phase));
  } else {
    float shine = pow(max(dot(n, normalize(light + vec3(0.0, 0.0, 1.0))), 0.0), 40.0);
    shown = (behind ? inner : outer) * (0.32 + 0.72 * max(dot(n, light), 0.0)) + 0.25 * shine;
  }
  colour = vec4(missing > 0.01 ? absent : shown, 1.0);
}`;

const LINE_VERTEX = `#version 300 es
precision highp float;
in vec2 corner; in vec3 start, end; in vec2 angles;
uniform vec3 centre; uniform mat3 axes; uniform vec4 lens; uniform vec2 widths, pixel;
uniform float widest, smooth_deg, row; uniform sampler2D palettes; uniform vec3 plain; uniform int jumps;
out vec3 tint;
void main() {
  vec3 a = axes * (start - centre) * lens.xyz, b = axes * (end - centre) * lens.xyz;
  float angle = max(angles.x, angles.y);
  bool bent = jumps == 1 && angle > smooth_deg;
  vec2 along = (b.xy - a.xy) / pixel;
  float size = max(length(along), 1e-6);
  vec2 across = vec2(-along.y, along.x) / size;
  vec3 here = mix(a, b, corner.x);
  float wide = bent ? widths.y : widths.x;
  here.xy += (across * corner.y + along / size * (corner.x - 0.5) * 0.6) * wide * pixel;
  here.z -= 2e-4 * lens.w;
  gl_Position = vec4(here, 1.0);
  tint = bent ? textureLod(palettes, vec2((clamp(angle / widest, 0.0, 1.0) * 255.0 + 0.5) / 256.0, row), 0.0).rgb : plain;
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 tint; out vec4 colour;
void main() { colour = vec4(tint, 1.0); }`;

const MARK_VERTEX = `#version 300 es
precision highp float;
in vec4 spot;
uniform vec3 centre; uniform mat3 axes; uniform vec4 lens; uniform float size;
out float kind;
void main() {
  vec3 here = axes * (spot.xyz - centre) * lens.xyz;
  here.z -= 6e-3 * lens.w;
  gl_Position = vec4(here, 1.0);
  gl_PointSize = size;
  kind = spot.w;
}`;

const MARK_FRAGMENT = `#version 300 es
precision highp float;
in float kind; uniform float alpha; out vec4 colour;
void main() {  // kind 1: a triangle upwards, -1: downwards
  vec2 p = 2.0 * gl_PointCoord - 1.0;
  float y = kind < 0.0 ? -p.y : p.y;
  float inside = min((y + 0.7) * 0.45 - abs(p.x) + 0.1, 0.62 - y);
  if (inside < 0.0) discard;
  colour = vec4(inside < 0.22 ? vec3(1.0) : vec3(0.07, 0.08, 0.12), alpha);
}`;

class Painter {
  /** Null, not a painter, where the browser cannot draw. */
  static make(settings) {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl || gl.isContextLost()) return null;
    try {
      return new Painter(canvas, gl, settings);
    } catch (error) {
      console.warn(String(error));
      return null;
    }
  }

  constructor(canvas, gl, settings) {
    Object.assign(this, { canvas, gl, settings });
    this.begin();
  }

  /** Make what the context holds; again after a context was lost. */
  begin() {
    const { gl, settings } = this;
    this.kept = new Map();
    this.surface = this.program(SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.line = this.program(LINE_VERTEX, LINE_FRAGMENT);
    this.mark = this.program(MARK_VERTEX, MARK_FRAGMENT);
    this.quad = this.buffer(new Float32Array([0, -0.5, 1, -0.5, 0, 0.5, 1, 0.5]));
    this.rows = settings.palettes.length;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, this.rows, 0, gl.RGB, gl.UNSIGNED_BYTE, settings.texels);
    for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.NEAREST);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(1, 1, 1, 1);
  }

  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "no program");
    const found = { program, at: {}, in: {} };
    for (let k = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) - 1; k >= 0; k--) {
      const { name } = gl.getActiveUniform(program, k);
      found.at[name] = gl.getUniformLocation(program, name);
    }
    for (let k = gl.getProgramParameter(program, gl.ACTIVE_ATTRIBUTES) - 1; k >= 0; k--) {
      const { name } = gl.getActiveAttrib(program, k);
      found.in[name] = gl.getAttribLocation(program, name);
    }
    return found;
  }

  buffer(data, target = this.gl.ARRAY_BUFFER) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(target, buffer);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return buffer;
  }

  /** Buffers of a surface, made when it is first drawn. */
  buffers(surface) {
    if (!this.kept.has(surface)) {
      const { gl } = this;
      gl.bindVertexArray(null);
      this.kept.set(surface, {
        places: this.buffer(surface.places),
        normals: this.buffer(surface.normals),
        codes: Object.fromEntries(Object.entries(surface.codes).map(([name, codes]) => [name, this.buffer(codes)])),
        triangles: this.buffer(surface.triangles, gl.ELEMENT_ARRAY_BUFFER),
        segments: this.buffer(surface.segments),
        marks: this.buffer(new Float32Array(surface.about.marks.flatMap(
          ({ point, name }) => [...relative(surface, point), name.startsWith("smallest") ? -1 : 1]))),
      });
    }
    return this.kept.get(surface);
  }

  /** Give the buffers of a surface back. */
  forget(surface) {
    const { gl } = this;
    const own = this.kept.get(surface);
    if (!own) return;
    for (const buffer of Object.values(own)) {
      for (const one of buffer instanceof WebGLBuffer ? [buffer] : Object.values(buffer)) gl.deleteBuffer(one);
    }
    this.kept.delete(surface);
  }

  attribute(location, buffer, size, type, normalised, stride, offset, divisor = 0) {
    const { gl } = this;
    if (location === undefined) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, size, type, normalised, stride, offset);
    gl.vertexAttribDivisor(location, divisor);
  }

  /** Draw a surface as a camera sees it; the picture is in the lower left corner of this.canvas. */
  draw(surface, camera, look, width, height, ratio) {
    const { gl, canvas } = this;
    if (canvas.width < width || canvas.height < height) {
      canvas.width = Math.max(canvas.width, width);
      canvas.height = Math.max(canvas.height, height);
    }
    gl.viewport(0, 0, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const side = Math.min(width, height);
    const near = (2 * surface.size) / camera.width;
    const seen = {
      axes: new Float32Array([0, 1, 2].flatMap((axis) => camera.axes.map((row) => row[axis]))),
      centre: relative(surface, camera.centre),
      lens: [(near * side) / width, (near * side) / height, (-0.25 * surface.size) / camera.radius, Math.min(1, camera.width / camera.radius)],
    };
    const own = this.buffers(surface);
    this.drawSurface(surface, own, seen, look, ratio);
    if (look.edges || look.style === "jump") this.drawLines(surface, own, seen, look, width, height, ratio);
    if (look.marks) this.drawMarks(surface, own, seen, look, ratio);
  }

  use(program, values) {
    const { gl } = this;
    gl.useProgram(program.program);
    for (const [name, value] of Object.entries(values)) {
      const at = program.at[name];
      if (at === undefined) continue;
      if (name === "axes") gl.uniformMatrix3fv(at, false, value);
      else if (name === "style" || name === "jumps" || name === "palettes") gl.uniform1i(at, value);
      else if (typeof value === "number") gl.uniform1f(at, value);
      else gl[`uniform${value.length}fv`](at, value);
    }
  }

  drawSurface(surface, own, seen, look, ratio) {
    const { gl, settings, surface: program } = this;
    const field = look.field in own.codes ? look.field : null;
    const span = field ? surface.about.ranges[field] : [0, 0, 1];
    this.use(program, {
      ...seen,
      extent: surface.extent,
      span,
      style: look.field ? 1 : { isophotes: 2, zebra: 3 }[look.style] || 0,
      limits: look.limits || [0, 1],
      row: this.row(look.palette),
      hatch: Math.max(1, Math.round(ratio)),
      bands: look.style === "zebra" ? settings.zebra : settings.isophoteDeg,
      palettes: 0,
      outer: look.style === "jump" ? settings.colours.pale : settings.colours.outer,
      inner: settings.colours.inner,
      absent: settings.colours.missing,
      light: settings.light,
    });
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    this.attribute(program.in.place, own.places, 3, gl.UNSIGNED_SHORT, true, 6, 0);
    this.attribute(program.in.fold, own.normals, 2, gl.UNSIGNED_SHORT, true, 4, 0);
    if (field) {
      this.attribute(program.in.code, own.codes[field], 1, gl.UNSIGNED_SHORT, false, 2, 0);
    } else {
      gl.disableVertexAttribArray(program.in.code);
      gl.vertexAttrib1f(program.in.code, look.field ? ABSENT : 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.triangles);
    gl.drawElements(gl.TRIANGLES, surface.triangles.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    this.release(program);
  }

  drawLines(surface, own, seen, look, width, height, ratio) {
    const { gl, settings, line: program } = this;
    this.use(program, {
      ...seen,
      widths: [1.1, 2.6].map((wide) => wide * ratio * Math.max(0.6, Math.min(1.2, Math.min(width, height) / ratio / 280))),
      pixel: [2 / width, 2 / height],
      widest: look.style === "jump" ? look.limits[1] : 1,
      smooth_deg: settings.smoothDeg,
      row: this.row("jump"),
      palettes: 0,
      plain: look.style === "jump" ? [0.6, 0.6, 0.62] : settings.colours.edge,
      jumps: look.style === "jump" ? 1 : 0,
    });
    this.attribute(program.in.corner, this.quad, 2, gl.FLOAT, false, 8, 0);
    this.attribute(program.in.start, own.segments, 3, gl.FLOAT, false, 32, 0, 1);
    this.attribute(program.in.end, own.segments, 3, gl.FLOAT, false, 32, 12, 1);
    this.attribute(program.in.angles, own.segments, 2, gl.FLOAT, false, 32, 24, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, surface.segments.length / 8);
    this.release(program);
  }

  /** Marks of the field that is shown: faint where the surface hides them. */
  drawMarks(surface, own, seen, look, ratio) {
    const { gl, mark: program } = this;
    const wanted = surface.about.marks.map(({ field }, k) => (field === look.extremes ? k : -1)).filter((k) => k >= 0);
    if (!wanted.length) return;
    this.use(program, { ...seen, size: 17 * ratio, alpha: 0.3 });
    this.attribute(program.in.spot, own.marks, 4, gl.FLOAT, false, 16, 0);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    for (const [test, alpha] of [[gl.GREATER, 0.3], [gl.LEQUAL, 1]]) {
      gl.depthFunc(test);
      gl.uniform1f(program.at.alpha, alpha);
      for (const k of wanted) gl.drawArrays(gl.POINTS, k, 1);
    }
    gl.depthFunc(gl.LESS);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    this.release(program);
  }

  row(palette) {
    return (Math.max(0, this.settings.palettes.indexOf(palette)) + 0.5) / this.rows;
  }

  release(program) {
    for (const location of Object.values(program.in)) {
      this.gl.disableVertexAttribArray(location);
      this.gl.vertexAttribDivisor(location, 0);
    }
  }
}
