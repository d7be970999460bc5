// The viewers of a page: cards with a canvas for each surface, the controls they share, and what the mouse does.

const FIELDS = { gauss: "gauss", mean: "mean", distance: "distance", thesis: "gauss" };
const DRAG = 0.45; // degrees a pixel
const FRAME = 30; // milliseconds that drawing may take before the browser has its turn
const tell = (text) => document.documentElement.setAttribute("data-viewer", text);

class Scene {
  constructor(element, about, painter, settings) {
    Object.assign(this, { element, about, painter, settings });
    this.camera = new Camera(about.view);
    this.linked = true;
    this.factor = 1;
    this.look = { style: "gauss" in about.scales ? "gauss" : "shaded", edges: false, marks: true };
    this.tip = make("div", { class: "tip", role: "status", hidden: true });
    this.cards = [...element.querySelectorAll(".card")].map((card) => new Card(this, card, about.surfaces[card.dataset.surface]));
    this.controls();
    const grid = element.querySelector(".cards");
    grid.after(this.tip);
    grid.tabIndex = 0;
    grid.addEventListener("keydown", (event) => this.key(event));
    this.show();
  }

  controls() {
    const { settings, about } = this;
    const styles = settings.styles.filter(({ name }) => !(name in FIELDS || name === "jump") || (FIELDS[name] || name) in about.scales);
    this.style = make("select", { name: "style", change: () => this.set({ style: this.style.value }) });
    for (const { name, title } of styles) this.style.append(make("option", { value: name, selected: name === this.look.style }, title));
    const box = (name, title, checked, change) =>
      make("label", {}, make("input", { type: "checkbox", name, checked, change: (event) => change(event.target.checked) }), ` ${title}`);
    const button = (name, title, hint, click) => make("button", { type: "button", name, title: hint, click }, title);
    this.bar = make("canvas", { width: 256, height: 1, "aria-hidden": "true" });
    this.ticks = make("span", { class: "ticks" });
    this.legend = make("div", { class: "legend-bar" }, this.bar, this.ticks);
    this.caption = make("p", { class: "caption", "aria-live": "polite" });
    const filter = make("input", { type: "search", name: "schemes", placeholder: "scheme", "aria-label": "Show schemes whose name holds",
      input: () => this.filter(filter.value) });
    this.element.querySelector(".controls").append(
      make("label", {}, "Colour ", this.style),
      box("edges", "patch edges", false, (edges) => this.set({ edges })),
      box("marks", "extremes", true, (marks) => this.set({ marks })),
      box("linked", "linked views", true, (linked) => this.link(linked)),
      button("reset", "Reset view", "The view it began with (0)", () => this.reset()),
      make("span", { class: "limits" }, button("narrow", "limits ÷ 2", "Halve the limits of the colours, on all surfaces", () => this.scale(0.5)),
        button("wide", "× 2", "Double the limits of the colours, on all surfaces", () => this.scale(2))),
      filter,
      this.legend,
      this.caption,
    );
  }

  /** Limits of the style that is shown, with the factor that was chosen; null without any. */
  limits() {
    const { style } = this.look;
    if (style === "thesis") return this.settings.thesis;
    const field = FIELDS[style] || style;
    return field in this.about.scales ? this.about.scales[field].map((limit) => limit * this.factor) : null;
  }

  set(changed) {
    if ("style" in changed && changed.style !== this.look.style) this.factor = 1;
    Object.assign(this.look, changed);
    this.show();
  }

  scale(factor) {
    this.factor *= factor;
    this.show();
  }

  show() {
    const { style } = this.look;
    const field = FIELDS[style] || null;
    const limits = this.limits();
    Object.assign(this.look, { field, limits, palette: style, extremes: field || (style === "jump" ? "jump" : "gauss") });
    const about = this.settings.styles.find(({ name }) => name === style);
    this.legend.classList.toggle("off", !limits);
    this.element.querySelector(".limits").classList.toggle("off", !limits || style === "thesis");
    if (limits) {
      const row = this.settings.palettes.indexOf(style);
      const context = this.bar.getContext("2d");
      const pixels = context.createImageData(256, 1);
      for (let k = 0; k < 256; k++) {
        for (let channel = 0; channel < 3; channel++) pixels.data[4 * k + channel] = this.settings.texels[3 * (256 * row + k) + channel];
        pixels.data[4 * k + 3] = 255;
      }
      context.putImageData(pixels, 0, 0);
      const middle = (limits[0] + limits[1]) / 2;
      this.ticks.replaceChildren(...[limits[0], middle, limits[1]].map((value) => make("span", {}, short(value, 3))));
    }
    const beyond = limits && style !== "jump" ? " The same limits on all surfaces; striped: beyond them." : "";
    const names = new Set(this.cards.flatMap((card) => card.about.marks).filter((mark) => mark.field === this.look.extremes).map((mark) => mark.name));
    const marks = this.look.marks && names.size
      ? ` ${[...names].map((name) => `${name.startsWith("smallest") ? "▼" : "▲"} ${name}`).join(", ")} of the results, pale where hidden.` : "";
    for (const card of this.cards) card.say(this.look.extremes);
    this.caption.textContent = about.caption + beyond + marks;
    this.redraw();
  }

  link(linked) {
    this.linked = linked;
    if (linked) for (const card of this.cards) card.own = null;
    this.redraw();
  }

  reset() {
    this.camera.reset();
    for (const card of this.cards) card.own = null;
    this.redraw();
  }

  filter(text) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    for (const card of this.cards) card.element.hidden = !words.every((word) => card.about.scheme.toLowerCase().includes(word));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const turns = { ArrowLeft: [10, 0], ArrowRight: [-10, 0], ArrowUp: [0, -10], ArrowDown: [0, 10] };
    if (event.key in turns) this.camera.turn(...turns[event.key]);
    else if (event.key === "+" || event.key === "=") this.camera.zoom(1.25);
    else if (event.key === "-") this.camera.zoom(0.8);
    else if (event.key === "0") this.reset();
    else return;
    event.preventDefault();
    this.redraw();
  }

  redraw(cards = this.cards) {
    for (const card of cards) card.stale = true;
    this.frame ||= requestAnimationFrame(() => this.paint());
  }

  /** Draw cards in the window, the one under the mouse first, then those that wait longest; the rest a frame later. */
  paint() {
    this.frame = null;
    const began = performance.now();
    const waiting = this.cards.filter((card) => card.stale && card.surface && card.inWindow());
    waiting.sort((a, b) => (b === this.held) - (a === this.held) || a.drawn - b.drawn);
    for (const card of waiting) {
      card.draw();
      if (performance.now() - began > FRAME) break;
    }
    if (waiting.some((card) => card.stale)) {
      this.redraw([]);
      return;
    }
    const near = this.cards.filter((card) => card.visible && !card.failed);
    if (near.length && near.every((card) => card.surface)) {
      this.element.setAttribute("data-ready", "");
      tell("ready");
    }
  }
}

class Card {
  constructor(scene, element, about) {
    Object.assign(this, { scene, element, about, own: null, surface: null, visible: false, stale: true, drawn: 0 });
    this.canvas = make("canvas", { role: "img", "aria-label": element.querySelector("img").alt, hidden: true });
    element.querySelector(".picture").append(this.canvas);
    element.querySelector("figcaption").append(
      make("button", { type: "button", class: "enlarge", "aria-pressed": "false", "aria-label": `Enlarge ${about.scheme}`, title: "Enlarge",
        click: (event) => event.currentTarget.setAttribute("aria-pressed", String(element.classList.toggle("large"))) }, "⤢"));
    this.line = make("span", { class: "extremes now" });
    element.querySelector(".name").after(this.line);
    element.classList.add("live");
    this.mouse();
    new ResizeObserver(() => scene.redraw([this])).observe(element.querySelector(".picture"));
    new IntersectionObserver((entries) => this.see(entries.at(-1).isIntersecting), { rootMargin: "250px" }).observe(element);
  }

  /** Say how far a field goes in the results. */
  say(field) {
    this.line.textContent = this.about.extremes[field] || "";
  }

  get camera() {
    return this.own || this.scene.camera;
  }

  /** Unpack when it comes near the window; give the buffers back when it leaves. */
  async see(visible) {
    this.visible = visible;
    if (!visible) {
      if (this.surface) this.scene.painter.forget(this.surface);
      return;
    }
    if (!this.surface && !this.opening) {
      this.opening = true;
      try {
        this.surface = await unpack(document.getElementById(this.about.data).textContent, this.about);
      } catch (error) {
        this.failed = true;
        console.warn(String(error));
        return;
      }
    }
    this.scene.redraw([this]);
  }

  inWindow() {
    const { top, bottom, height } = this.element.getBoundingClientRect();
    return height > 0 && bottom > -50 && top < window.innerHeight + 50;
  }

  draw() {
    const { painter, look } = this.scene;
    this.stale = false;
    this.drawn = performance.now();
    if (painter.lost) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const box = this.canvas.parentElement.getBoundingClientRect();
    const [width, height] = [Math.round(box.width * ratio), Math.round(box.height * ratio)];
    if (!width || !height) return;
    painter.draw(this.surface, this.camera, look, width, height, ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.canvas.getContext("2d").drawImage(painter.canvas, 0, painter.canvas.height - height, width, height, 0, 0, width, height);
    this.canvas.hidden = false;
    this.element.classList.add("drawn");
  }

  /** Drag to turn, with shift or the right button to move; two fingers to enlarge and move; wheel to enlarge. */
  mouse() {
    const { canvas, scene } = this;
    const fingers = new Map();
    let moved = 0;
    const place = ({ clientX, clientY }) => {
      const box = canvas.getBoundingClientRect();
      const side = Math.min(box.width, box.height);
      return [(2 * (clientX - box.left) - box.width) / side, (box.height - 2 * (clientY - box.top)) / side];
    };
    const grasp = () => {
      scene.held = this;
      if (!scene.linked && !this.own) {
        this.own = new Camera(scene.about.view);
        Object.assign(this.own, { azimuth: scene.camera.azimuth, elevation: scene.camera.elevation, centre: [...scene.camera.centre], width: scene.camera.width });
      }
      return this.camera;
    };
    const changed = () => scene.redraw(this.own ? [this] : scene.cards);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      lastMove = performance.now();
      const before = fingers.get(event.pointerId);
      if (!before) {
        if (event.pointerType !== "touch") this.tell(event, place(event));
        return;
      }
      const camera = grasp();
      const side = Math.min(canvas.clientWidth, canvas.clientHeight);
      const [right, down] = [event.clientX - before.clientX, event.clientY - before.clientY];
      moved += Math.hypot(right, down);
      if (fingers.size === 2) {
        const other = [...fingers.entries()].find(([id]) => id !== event.pointerId)[1];
        const apart = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY) || 1;
        camera.zoom(apart(event) / apart(before), ...place(other));
        camera.move(right / side / 2, -down / side / 2);
      } else if (event.shiftKey || event.buttons === 2) {
        camera.move(right / side, -down / side);
      } else {
        camera.turn(-right * DRAG, down * DRAG);
      }
      fingers.set(event.pointerId, event);
      scene.tip.hidden = true;
      changed();
    });
    const release = (event) => {
      if (fingers.delete(event.pointerId) && event.type === "pointerup" && moved < 4) this.tell(event, place(event));
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType !== "touch") scene.tip.hidden = true;
    });
    canvas.addEventListener("wheel", (event) => {
      // whoever scrolls the page scrolls on when a surface comes under the mouse
      if (!event.ctrlKey && performance.now() - lastScroll < 400 && lastScroll > lastMove - 50) return;
      event.preventDefault();
      grasp().zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...place(event));
      scene.tip.hidden = true;
      changed();
    }, { passive: false });
  }

  /** Show what is known at a place of the picture. */
  tell(event, [x, y]) {
    const { tip } = this.scene;
    const found = this.surface && pick(this.surface, this.camera, x, y);
    tip.hidden = !found;
    if (!found) return;
    const { point, normal, values, face, place } = probe(this.surface, found);
    const near = this.near(x, y);
    const lines = [
      ["point", point.map((value) => fixed(value, this.surface.size)).join(", ")],
      ["normal", normal.map((value) => short(value, 3)).join(", ")],
      ["K", short(values.gauss)],
      ["H", short(values.mean)],
      ["distance", "distance" in values ? short(values.distance) : "no exact surface"],
      [`face ${face}`, `(${place.map((value) => Math.abs(value).toFixed(3)).join(", ")})`],
      ...near.map((mark) => [mark.name, `${short(mark.value)} on face ${mark.face}`]),
    ];
    tip.replaceChildren(make("b", {}, this.about.scheme), make("dl", {}, ...lines.flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, text)])));
    const [width, height] = [tip.offsetWidth, tip.offsetHeight];
    const left = event.clientX + 16 + width < document.documentElement.clientWidth ? event.clientX + 16 : Math.max(4, event.clientX - width - 12);
    const top = event.clientY + 16 + height < window.innerHeight ? event.clientY + 16 : Math.max(4, event.clientY - height - 12);
    tip.style.left = `${left}px`;
    tip.style.top = `${top}px`;
  }

  /** Marks that are shown near a place of the picture. */
  near(x, y) {
    const { camera, scene } = this;
    if (!scene.look.marks) return [];
    const [right, up] = camera.axes;
    const on = (axis, point) => axis.reduce((sum, value, k) => sum + value * (point[k] - camera.centre[k]), 0) * (2 / camera.width);
    const reach = 22 / this.canvas.clientWidth;
    return this.about.marks.filter(({ field, point }) =>
      field === scene.look.extremes && Math.hypot(on(right, point) - x, on(up, point) - y) < reach);
  }
}

let lastScroll = -1e9;
let lastMove = -1e9;

/** Begin: a viewer for each dataset, where the browser can draw; else the pictures that are there stay. */
function startViewers() {
  const data = document.getElementById("viewer-settings");
  if (!data) return;
  const settings = JSON.parse(data.textContent);
  settings.texels = Uint8Array.from(atob(settings.texels), (letter) => letter.charCodeAt(0));
  const painter = "DecompressionStream" in window && "IntersectionObserver" in window ? Painter.make(settings) : null;
  if (!painter) {
    tell("pictures");
    return;
  }
  tell("starting");
  const scenes = [];
  window.addEventListener("scroll", () => {
    lastScroll = performance.now();
    for (const scene of scenes) if (scene.cards.some((card) => card.stale)) scene.redraw([]);
  }, { passive: true, capture: true });
  painter.canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    painter.lost = true;
  });
  painter.canvas.addEventListener("webglcontextrestored", () => {
    painter.begin();
    painter.lost = false;
    for (const scene of scenes) scene.redraw();
  });
  const begin = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      begin.unobserve(target);
      const about = JSON.parse(document.getElementById(target.dataset.scene).textContent);
      scenes.push(new Scene(target, about, painter, settings));
    }
  }, { rootMargin: "600px" });
  for (const element of document.querySelectorAll(".viewer")) begin.observe(element);
}
