// Makes the figures of a report interactive: zoom, pan, a cursor that reads values, harmonic and side-band cursors, the lines of a
// diagnosis in every figure, orbits and spectra of a chosen time. Without the script the page is complete, but static.
"use strict";
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const SVG = "http://www.w3.org/2000/svg";
// Largest distance between pointer and line at which a drag moves the line, pixels of the figure.
const NEAR = 7;
// Numbers of lines that the harmonic and the side-band cursor draw on each side.
const HARMONICS = 40, SIDE_BANDS = 6;
// Shortest time range, samples.
const MIN_SAMPLES = 64;

// ---- Elements and numbers

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "on") for (const [event, listener] of Object.entries(value)) made.addEventListener(event, listener);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

function drawn(name, attributes = {}, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const tenths = (x) => Math.round(x * 10) / 10;

// Formats a number with `digits` significant digits, a minus sign (U+2212) and no trailing zeros.
function shown(x, digits = 4) {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  const text = size > 0 && (size >= 1e6 || size < 1e-4) ? x.toExponential(digits - 1) : String(Number(x.toPrecision(digits)));
  return text.replace(/-/g, "−");
}

function bytes(text) {
  const raw = atob(text);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out;
}

const singles = (text) => new Float32Array(bytes(text).buffer);
const column = (packed) => typeof packed === "string" ? singles(packed)
  : Float64Array.from({ length: packed[2] }, (_, i) => packed[0] + i * packed[1]);

// Splits a title such as "Frequency, Hz" into name and unit.
function quantity(title) {
  const [, name, unit] = title.match(/^(.*?), ([^,]*)$/) || [null, title, ""];
  return { name, unit };
}

// Returns round values inside a range with their labels, about `most` at most.
function ticks(low, high, most, logarithmic) {
  if (logarithmic && high / low > 12) {
    const out = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++)
      for (let k = 1; k < 10; k++) {
        const value = k * 10 ** power;
        if (value >= low && value <= high) out.push({ value, label: k === 1 ? shown(value, 2) : "", fine: k > 1 });
      }
    return out;
  }
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((k) => k * power >= rough * 0.999) * power;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const out = [];
  for (let i = Math.ceil(low / step - 1e-6); i * step <= high + 1e-6 * step; i++) {
    const value = i * step;
    const label = (Math.abs(value) < step * 1e-6 ? 0 : value).toFixed(Math.min(digits, 12)).replace("-", "−");
    out.push({ value, label: Math.abs(value) >= 1e7 ? shown(value, 4) : label, fine: false });
  }
  return out;
}

// Returns the index of the value nearest to x; the values are sorted.
function nearest(values, x) {
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] > x) high = middle; else low = middle;
  }
  return Math.abs(values[low] - x) <= Math.abs(values[high] - x) ? low : high;
}

// ---- One axis: home range, present range, and limits of the present range

class Axis {
  constructor({ low, high, log, title }) {
    Object.assign(this, { log, title }, quantity(title));
    this.home = [this.to(low), this.to(high)];
    this.limits = [...this.home];
    this.range = [...this.home];
  }
  // Maps a value to the coordinate in which the axis is linear; `from` is the inverse.
  to(value) { return this.log ? Math.log10(Math.max(value, Number.MIN_VALUE)) : value; }
  from(place) { return this.log ? 10 ** place : place; }
  share(value) { return (this.to(value) - this.range[0]) / (this.range[1] - this.range[0]); }
  value(share) { return this.from(this.range[0] + share * (this.range[1] - this.range[0])); }
  get isHome() { return this.range[0] === this.home[0] && this.range[1] === this.home[1]; }
  set(low, high) {
    const whole = this.limits[1] - this.limits[0];
    const length = clamp(high - low, 1e-6 * whole, whole);
    const start = clamp(low, this.limits[0], this.limits[1] - length);
    this.range = [start, start + length];
  }
  // Zooms about a share of the range; a factor below 1 magnifies.
  zoom(share, factor) {
    const [low, high] = this.range, fixed = low + share * (high - low);
    this.set(fixed - (fixed - low) * factor, fixed + (high - fixed) * factor);
  }
  move(share) {
    const length = this.range[1] - this.range[0];
    this.set(this.range[0] + share * length, this.range[1] + share * length);
  }
  reset() { this.range = [...this.home]; }
}

// ---- One frame of a figure

let clips = 0;

class Plot {
  constructor(figure, number, spec) {
    this.figure = figure;
    this.below = spec.below;
    [this.left, this.top, this.right, this.bottom] = spec.box;
    this.x = new Axis(spec.x);
    this.y = new Axis(spec.y);
    this.curves = spec.curves.map((curve) => ({ ...curve, packed: curve }));
    this.curves.forEach((curve) => { delete curve.x; delete curve.y; });
    const all = (name) => [...figure.svg.querySelectorAll(`[data-${name}="${number}"]`)];
    this.axes = all("axes")[0];
    this.still = [...this.axes.childNodes];
    this.curves.forEach((curve, i) => {
      const group = curve.group = figure.svg.querySelector(`[data-curve="${number}.${i}"]`);
      curve.still = group ? [...group.childNodes] : [];
    });
    this.inside = all("inside");
    this.along = all("along");
    this.items = [...this.inside.flatMap((g) => places(g, true)), ...this.along.flatMap((g) => places(g, false))];
    this.homePixels = null;
    this.isEqual = this.curves.some((curve) => curve.kind === "path") && this.x.unit === this.y.unit;
    this.isOfFrequency = this.x.unit === "Hz" || this.x.unit === "X";
    this.isCascade = this.curves.some((curve) => curve.kind === "ridge");
    this.replaced = false;
    if (this.isOfFrequency && !this.isCascade) this.widen();
  }

  // Extends the limits of the X axis to all values of the spectra.
  widen() {
    for (const curve of this.curves) {
      const x = column(curve.packed.x);
      if (!x.length) continue;
      this.x.limits[0] = Math.min(this.x.limits[0], x[0]);
      this.x.limits[1] = Math.max(this.x.limits[1], x[x.length - 1]);
    }
  }

  values(curve) {
    if (!curve.x) {
      curve.y = singles(curve.packed.y);
      curve.x = column(curve.packed.x);
    }
    return curve;
  }

  px(value) { return this.left + this.x.share(value) * (this.right - this.left); }
  py(value) { return this.bottom - this.y.share(value) * (this.bottom - this.top); }
  holds([x, y]) { return x >= this.left && x <= this.right && y >= this.top && y <= this.bottom; }
  shares([x, y]) { return [(x - this.left) / (this.right - this.left), (this.bottom - y) / (this.bottom - this.top)]; }
  order(value) { return this.x.unit === "X" ? value : value / data.speed_hz; }
  get isHome() { return this.x.isHome && this.y.isHome && !this.replaced; }

  clip() {
    if (!this.clipId) {
      this.clipId = `clip${clips++}`;
      const { left: x, top: y, right, bottom } = this;
      const path = drawn("clipPath", { id: this.clipId });
      path.append(drawn("rect", { x, y, width: right - x, height: bottom - y }));
      this.figure.svg.prepend(path);
    }
    return `url(#${this.clipId})`;
  }

  draw() {
    const home = this.isHome;
    for (const group of [...this.inside, ...this.curves.map((curve) => curve.group)].filter(Boolean)) {
      if (home) group.removeAttribute("clip-path"); else group.setAttribute("clip-path", this.clip());
    }
    this.axes.replaceChildren(...home ? this.still : this.scale());
    const map = this.mapping();
    for (const item of this.items) item.set(map, this);
    // Marks that belong to the readings of the static figure are hidden where other readings are shown.
    for (const group of this.replaced ? this.inside : []) group.setAttribute("visibility", "hidden");
    if (!this.replaced) for (const group of this.inside) group.removeAttribute("visibility");
    for (const group of this.along)
      if (this.replaced && !this.isOfFrequency) group.setAttribute("visibility", "hidden");
      else group.removeAttribute("visibility");
    for (const curve of this.curves.filter((c) => c.group))
      curve.group.replaceChildren(...home ? curve.still : this.lines(curve));
  }

  // Returns the functions from pixels of the static figure to pixels of the present ranges.
  mapping() {
    const along = (axis, from, to) => {
      const [low, high] = axis.home, [now, end] = axis.range, size = to - from;
      return (p) => from + size * ((low + (p - from) / size * (high - low)) - now) / (end - now);
    };
    return { x: along(this.x, this.left, this.right), y: along(this.y, this.bottom, this.top) };
  }

  // Returns grid and labels of the present ranges.
  scale() {
    const out = [], line = (x1, y1, x2, y2, fine) => out.push(drawn("line", {
      x1, y1, x2, y2, stroke: "var(--grid)", "stroke-width": fine ? 0.25 : 0.75 }));
    const text = (x, y, anchor, label) => out.push(drawn("text", {
      x, y, dy: ".35em", fill: "var(--ink)", "text-anchor": anchor }, label));
    const [wide, high] = [this.right - this.left, this.bottom - this.top];
    for (const tick of ticks(this.y.value(0), this.y.value(1), clamp(high / 32, 3, 8), this.y.log)) {
      const y = tenths(this.py(tick.value));
      line(this.left, y, this.right, y, tick.fine);
      if (tick.label && this.figure.hasLabels(this)) text(this.left - 5, y, "end", tick.label);
    }
    for (const tick of ticks(this.x.value(0), this.x.value(1), clamp(wide / 62, 2, 9), this.x.log)) {
      const x = tenths(this.px(tick.value));
      line(x, this.top, x, this.bottom, tick.fine);
      if (tick.label && this.below) text(x, this.bottom + 10, "middle", tick.label);
    }
    return out;
  }

  // Returns a curve as polylines. With many values per pixel, only the lowest and the highest are drawn.
  lines(curve) {
    const { x, y, kind } = this.values(curve), pieces = [];
    let piece = [];
    const end = () => { if (piece.length > 1) pieces.push(piece); piece = []; };
    const [low, high] = [this.x.value(0), this.x.value(1)];
    let first = 0, last = x.length - 1;
    if (kind === "function" && x.length > 2 && x[0] < x[x.length - 1]) {
      first = Math.max(nearest(x, low) - 1, 0);
      last = Math.min(nearest(x, high) + 1, x.length - 1);
    }
    const point = (i) => [clamp(this.px(x[i]), -9e3, 9e3), clamp(this.py(y[i]), -9e3, 9e3)];
    const run = kind === "function" ? Math.ceil((last - first + 1) / (4 * (this.right - this.left))) : 1;
    for (let i = first; i <= last; i += run) {
      let least = -1, most = -1;
      for (let k = i; k < Math.min(i + run, last + 1); k++) {
        if (!Number.isFinite(y[k]) || !Number.isFinite(x[k])) { least = -2; break; }
        if (least < 0 || y[k] < y[least]) least = k;
        if (most < 0 || y[k] > y[most]) most = k;
      }
      if (least === -2) { end(); continue; }
      piece.push(point(Math.min(least, most)));
      if (least !== most) piece.push(point(Math.max(least, most)));
    }
    end();
    return pieces.map((points) => drawn("polyline", { points: points.map(([a, b]) => `${tenths(a)},${tenths(b)}`).join(" ") }));
  }

  // Returns the reading nearest to a point of the figure: curve and index of the value.
  find([x, y]) {
    const at = this.x.value(this.shares([x, y])[0]);
    let best = null;
    for (const curve of this.curves) {
      this.values(curve);
      if (!curve.x.length) continue;
      if (curve.kind === "function") {
        if (!best) best = { curve, i: nearest(curve.x, at), distance: 0 };
      } else if (curve.kind === "ridge") {
        const distance = Math.abs(this.py(curve.along) - y);
        if (!best || distance < best.distance) best = { curve, i: nearest(curve.x, at), distance };
      } else {
        for (let i = 0; i < curve.x.length; i++) {
          const distance = Math.hypot(this.px(curve.x[i]) - x, this.py(curve.y[i]) - y);
          if (distance < (best ? best.distance : Infinity)) best = { curve, i, distance };
        }
      }
    }
    return best && { plot: this, ...best };
  }

  // Returns the highest value of a curve within one and a half steps of x; NaN outside the curve.
  amplitude(curve, at) {
    const { x, y } = this.values(curve), middle = nearest(x, at);
    let best = NaN;
    for (let i = Math.max(0, middle - 1); i <= Math.min(x.length - 1, middle + 1); i++)
      if (!(y[i] <= best)) best = y[i];
    return at >= x[0] && at <= x[x.length - 1] ? best : NaN;
  }

  step() {
    const curve = this.curves.find((c) => c.kind !== "scatter");
    if (!curve) return (this.x.value(1) - this.x.value(0)) / 200;
    const { x } = this.values(curve);
    return Math.abs(x[1] - x[0]);
  }
}

// Returns the elements of a group with their positions in the static figure. With `both` they follow both axes, else only X.
function places(group, both) {
  const number = (e, name) => Number(e.getAttribute(name));
  const put = (e, attributes) => { for (const key in attributes) e.setAttribute(key, tenths(attributes[key])); };
  const hide = (e, is) => { if (is) e.setAttribute("visibility", "hidden"); else e.removeAttribute("visibility"); };
  return [...group.children].flatMap((e) => {
    const inFrame = (x, plot) => x >= plot.left - 0.5 && x <= plot.right + 0.5;
    switch (e.localName) {
      case "g": return places(e, both);
      case "circle": {
        const [cx, cy] = [number(e, "cx"), number(e, "cy")];
        return [{ set: (map, plot) => {
          put(e, { cx: map.x(cx), cy: both ? map.y(cy) : cy });
          if (!both) hide(e, !inFrame(map.x(cx), plot));
        } }];
      }
      case "text": {
        const [x, y] = [number(e, "x"), number(e, "y")];
        const line = e.previousElementSibling;
        // The name of a line moves with the line and keeps its distance from it.
        const from = !both && line && line.localName === "line" ? number(line, "x1") : x;
        return [{ set: (map, plot) => {
          put(e, { x: map.x(from) + x - from, y: both ? map.y(y) : y });
          if (!both) hide(e, !inFrame(map.x(from), plot));
        } }];
      }
      case "line": {
        const [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map((name) => number(e, name));
        return [{ set: (map, plot) => {
          put(e, { x1: map.x(x1), x2: map.x(x2) });
          if (both) put(e, { y1: map.y(y1), y2: map.y(y2) });
          else hide(e, !inFrame(map.x(x1), plot));
        } }];
      }
      case "polyline":
      case "polygon": {
        const points = e.getAttribute("points").split(" ").map((pair) => pair.split(",").map(Number));
        return [{ set: (map, plot) => {
          const [tip] = points, rigid = points.length === 3;
          const x = rigid ? (p) => map.x(tip[0]) + p - tip[0] : map.x;
          const y = !both ? (p) => p : rigid ? (p) => map.y(tip[1]) + p - tip[1] : map.y;
          const edge = (p) => both ? p : clamp(p, plot.left, plot.right);
          e.setAttribute("points", points.map(([a, b]) => `${tenths(rigid ? x(a) : edge(x(a)))},${tenths(y(b))}`).join(" "));
          if (!both) hide(e, rigid && !inFrame(map.x(tip[0]), plot));
        } }];
      }
      default: return [];
    }
  });
}

// ---- One figure

class Figure {
  constructor(root, spec) {
    this.root = root;
    this.source = spec.source;
    this.title = root.querySelector("figcaption").textContent;
    this.area = root.querySelector(".plot");
    this.svg = root.querySelector("svg");
    this.plots = spec.plots.map((plot, number) => new Plot(this, number, plot));
    this.cursor = this.comb = this.box = null;
    this.marked = [];
    this.svg.append(this.highlights = drawn("g", { class: "overlay highlights" }), this.overlay = drawn("g", { class: "overlay" }));
    this.readout = element("output", { class: "readout", "aria-live": "polite" });
    const button = (label, name, click, attributes = {}) =>
      element("button", { type: "button", title: name, "aria-label": `${name}: ${this.title}`, ...attributes, on: { click } }, label);
    this.panButton = button("Pan", "Drag moves the view instead of choosing a box", () => this.setPan(!this.isPan), { "aria-pressed": "false" });
    const tools = [
      button("+", "Zoom in", () => this.zoomAll(0.5)),
      button("−", "Zoom out", () => this.zoomAll(2)),
      this.panButton,
      button("Reset", "Whole figure", () => this.reset()),
    ];
    if (this.plots.some((plot) => plot.isOfFrequency && !plot.isCascade)) {
      this.combButtons = ["harmonics", "side bands"].map((kind) =>
        button(kind[0].toUpperCase() + kind.slice(1), kind === "harmonics"
          ? "Harmonic cursor: drag the first line, its multiples follow"
          : "Side-band cursor: drag the middle line, or a side band to set the spacing",
        () => this.setComb(this.comb && this.comb.kind === kind ? null : kind), { "aria-pressed": "false" }));
      tools.push(...this.combButtons);
    }
    this.area.before(element("div", { class: "tools", role: "toolbar", "aria-label": `Tools of ${this.title}` }, ...tools));
    this.area.after(this.readout);
    this.area.tabIndex = 0;
    this.area.setAttribute("role", "group");
    this.area.setAttribute("aria-label", `${this.title}. Left and right move the cursor, shift with them moves the view, plus and minus zoom, ` +
      "0 shows all, h harmonics, s side bands, escape ends.");
    this.pointers = new Map();
    this.listen();
  }

  // Tick labels of Y are absent in a frame that shares them with the one to its left.
  hasLabels(plot) { return plot.y.name !== "" || this.plots.length === 1; }
  // Returns the frames with the same X axis.
  linked(plot) { return this.plots.filter((other) => other.x.title === plot.x.title && other.x.home[0] === plot.x.home[0] && other.x.home[1] === plot.x.home[1]); }
  point(event) {
    const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [p.x, p.y];
  }
  plotAt(point) { return this.plots.find((plot) => plot.holds(point)); }

  draw() {
    this.plots.forEach((plot) => plot.draw());
    this.drawMarks();
  }

  listen() {
    const on = (name, listener, options) => this.area.addEventListener(name, listener, options);
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.move(event));
    on("pointerup", (event) => this.up(event));
    on("pointercancel", (event) => this.up(event));
    on("pointerleave", () => {
      if (this.pointers.size === 0 && document.activeElement !== this.area && !this.comb) this.setCursor(null);
    });
    on("dblclick", () => this.reset());
    // The wheel scrolls the page unless the figure has the focus.
    on("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== this.area) return;
      const point = this.point(event), plot = this.plotAt(point);
      if (!plot) return;
      event.preventDefault();
      this.zoom(plot, plot.shares(point), 1.2 ** clamp(event.deltaY / 50, -3, 3), event.shiftKey);
    }, { passive: false });
    on("keydown", (event) => this.key(event));
  }

  down(event) {
    if (event.button > 0) return;
    this.area.focus({ preventScroll: true });
    const point = this.point(event), plot = this.plotAt(point);
    this.pointers.set(event.pointerId, point);
    if (this.pointers.size === 2) { this.pinch = [...this.pointers.values()]; this.drag = this.box = null; return; }
    if (!plot) return;
    this.area.setPointerCapture(event.pointerId);
    const held = this.grabbed(plot, point);
    const kind = held !== null ? "comb" : this.isPan || event.shiftKey ? "pan" : event.pointerType === "touch" ? "read" : "box";
    this.drag = { kind, plot, start: point, last: point, held };
    if (kind === "comb" || kind === "pan") this.area.classList.add("held");
  }

  move(event) {
    const point = this.point(event);
    if (this.pointers.has(event.pointerId)) this.pointers.set(event.pointerId, point);
    if (this.pointers.size === 2 && this.pinch) { this.pinched(); return; }
    const drag = this.drag;
    if (!drag) {
      const plot = this.plotAt(point);
      if (plot) this.setCursor(plot.find(point));
      return;
    }
    const { plot, last } = drag;
    if (drag.kind === "pan") {
      const [a, b] = [plot.shares(last), plot.shares(point)];
      this.pan(plot, a[0] - b[0], a[1] - b[1]);
    } else if (drag.kind === "comb") {
      this.pull(plot.x.value(plot.shares(point)[0]), drag.held);
    } else if (drag.kind === "box") {
      const inside = [clamp(point[0], plot.left, plot.right), clamp(point[1], plot.top, plot.bottom)];
      this.box = [drag.start, inside];
      this.drawMarks();
    } else {
      this.setCursor(plot.find(point));
    }
    drag.last = point;
  }

  up(event) {
    this.pointers.delete(event.pointerId);
    this.pinch = null;
    this.area.classList.remove("held");
    const { drag, box } = this;
    this.drag = this.box = null;
    if (!drag) return;
    if (drag.kind === "box" && box) this.zoomBox(drag.plot, box);
    else if (drag.kind === "box" || drag.kind === "read") this.setCursor(drag.plot.find(drag.last));
    this.drawMarks();
  }

  // Pans and zooms with two pointers: their middle is the fixed point, their distance sets the scale.
  pinched() {
    const [a, b] = this.pinch, [c, d] = this.pointers.values();
    const middle = (p, q) => [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
    const distance = (p, q) => Math.max(Math.hypot(p[0] - q[0], p[1] - q[1]), 1);
    const plot = this.plotAt(middle(a, b));
    if (plot) {
      const [before, now] = [plot.shares(middle(a, b)), plot.shares(middle(c, d))];
      this.pan(plot, before[0] - now[0], before[1] - now[1]);
      this.zoom(plot, now, distance(a, b) / distance(c, d), false);
    }
    this.pinch = [c, d];
  }

  // Zooms along X in all frames that share it; along both axes where the scales are equal, or along Y with shift.
  zoom(plot, [x, y], factor, isAlongY) {
    if (plot.isEqual) { plot.x.zoom(x, factor); plot.y.zoom(y, factor); }
    else if (isAlongY) plot.y.zoom(y, factor);
    else for (const one of this.linked(plot)) one.x.zoom(x, factor);
    this.draw();
  }

  zoomAll(factor) {
    const at = this.cursor && this.cursor.plot;
    for (const plot of this.plots) {
      const share = at && plot.x.title === at.x.title ? clamp(at.x.share(this.cursor.x), 0, 1) : 0.5;
      plot.x.zoom(share, factor);
      if (plot.isEqual) plot.y.zoom(0.5, factor);
    }
    this.draw();
  }

  zoomBox(plot, [[x1, y1], [x2, y2]]) {
    if (Math.abs(x2 - x1) < 5 && Math.abs(y2 - y1) < 5) { this.setCursor(plot.find([x2, y2])); return; }
    const [a, b] = [plot.shares([Math.min(x1, x2), Math.max(y1, y2)]), plot.shares([Math.max(x1, x2), Math.min(y1, y2)])];
    const part = (axis, from, to) => {
      const [low, high] = axis.range;
      axis.set(low + from * (high - low), low + to * (high - low));
    };
    if (plot.isEqual) {
      const half = Math.max(b[0] - a[0], b[1] - a[1]) / 2, x = (a[0] + b[0]) / 2, y = (a[1] + b[1]) / 2;
      part(plot.x, x - half, x + half);
      part(plot.y, y - half, y + half);
    } else {
      // A flat or narrow box zooms along one axis only.
      const others = this.linked(plot).filter((one) => one !== plot);
      if (Math.abs(x2 - x1) >= 5) for (const one of [plot, ...others]) part(one.x, a[0], b[0]);
      if (Math.abs(y2 - y1) >= 12) part(plot.y, a[1], b[1]);
    }
    this.draw();
  }

  pan(plot, x, y) {
    for (const one of plot.isEqual ? [plot] : this.linked(plot)) one.x.move(x);
    plot.y.move(y);
    this.draw();
  }

  reset() {
    for (const plot of this.plots) { plot.x.reset(); plot.y.reset(); }
    this.draw();
  }

  setPan(is) {
    this.isPan = is;
    this.panButton.setAttribute("aria-pressed", is);
    this.area.classList.toggle("pan", is);
  }

  // ---- The cursor

  setCursor(found) {
    this.cursor = found && { ...found, x: found.curve.x[found.i] };
    this.drawMarks();
  }

  key(event) {
    const plot = this.cursor ? this.cursor.plot : this.comb ? this.comb.plot : this.plots[0];
    if (!plot || event.ctrlKey || event.metaKey || event.altKey) return;
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (by && this.comb) this.comb.shift(by, event.shiftKey);
    else if (by && event.shiftKey) this.pan(plot, 0.1 * by, 0);
    else if (by) this.stepCursor(plot, by);
    else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
      if (event.shiftKey) this.pan(plot, 0, event.key === "ArrowUp" ? 0.1 : -0.1);
      else this.nextPlot(event.key === "ArrowUp" ? -1 : 1);
    } else if (event.key === "+" || event.key === "=") this.zoomAll(0.5);
    else if (event.key === "-") this.zoomAll(2);
    else if (event.key === "0" || event.key === "Home") this.reset();
    else if (event.key === "h" && this.combButtons) this.setComb(this.comb && this.comb.kind === "harmonics" ? null : "harmonics");
    else if (event.key === "s" && this.combButtons) this.setComb(this.comb && this.comb.kind === "side bands" ? null : "side bands");
    else if (event.key === "Escape") { this.setComb(null); this.setCursor(null); }
    else return;
    event.preventDefault();
    this.drawMarks();
  }

  stepCursor(plot, by) {
    if (!this.cursor) { this.setCursor(plot.find([(plot.left + plot.right) / 2, (plot.top + plot.bottom) / 2])); return; }
    const { curve } = this.cursor, i = clamp(this.cursor.i + by, 0, curve.x.length - 1);
    this.setCursor({ ...this.cursor, i });
    const share = plot.x.share(this.cursor.x);
    if (share < 0 || share > 1) this.pan(plot, share < 0 ? share : share - 1, 0);
  }

  // Moves the cursor to the same X in the next frame, or on the next spectrum of a cascade.
  nextPlot(by) {
    if (!this.cursor) { this.stepCursor(this.plots[0], 0); return; }
    const { plot, curve } = this.cursor;
    const all = curve.kind === "ridge"
      ? [...plot.curves].sort((a, b) => b.along - a.along).map((c) => ({ plot, curve: c }))
      : this.plots.map((p) => ({ plot: p, curve: p.curves.find((c) => c.kind !== "scatter") || p.curves[0] }));
    const here = all.findIndex((one) => curve.kind === "ridge" ? one.curve === curve : one.plot === plot);
    const next = all[clamp(here + by, 0, all.length - 1)];
    if (!next.curve) return;
    next.plot.values(next.curve);
    this.setCursor({ ...next, i: nearest(next.curve.x, this.cursor.x) });
  }

  // Returns name, value and unit of each reading at the cursor.
  reading() {
    const { plot, curve, i, x } = this.cursor;
    const out = [];
    const add = (name, value, unit, digits) => out.push({ name, value, unit, digits });
    if (curve.kind === "ridge") add(plot.y.name, curve.along, plot.y.unit, 5);
    add(plot.x.name, x, plot.x.unit, 6);
    if (plot.x.unit === "Hz" && data.speed_hz > 0) add("order", plot.order(x), "X", 5);
    if (plot.x.unit === "X" && data.speed_hz > 0) add("frequency", x * data.speed_hz, "Hz", 6);
    if (curve.kind === "ridge") {
      const { name, unit } = quantity(curve.name);
      add(name, curve.y[i], unit, 4);
    } else if (curve.kind === "function") {
      for (const one of this.linked(plot).filter((p) => !p.isCascade))
        for (const c of one.curves.filter((other) => other.kind === "function")) {
          const { x: xs, y } = one.values(c), k = nearest(xs, x);
          const isSame = Math.abs(xs[k] - x) <= 0.51 * one.step() || xs.length === curve.x.length;
          const several = this.plots.length > 1 && one.curves.length === 1 && one.y.name;
          if (isSame) add(several ? one.y.name : c.name, y[k], one.y.unit, 4);
        }
    } else {
      add(plot.y.name, curve.y[i], plot.y.unit, 5);
      add("on", NaN, curve.name);
    }
    return out;
  }

  // ---- Harmonic and side-band cursors

  setComb(kind) {
    const plot = this.cursor && this.cursor.plot.isOfFrequency ? this.cursor.plot : this.plots.find((p) => p.isOfFrequency);
    this.comb = kind && new Comb(kind, plot, this.cursor && this.cursor.plot === plot ? this.cursor.x : undefined);
    if (this.combButtons) ["harmonics", "side bands"].forEach((name, i) =>
      this.combButtons[i].setAttribute("aria-pressed", Boolean(this.comb && this.comb.kind === name)));
    this.drawMarks();
  }

  // Returns the number of the comb line within `NEAR` of a point, or null.
  grabbed(plot, [x]) {
    if (!this.comb || this.comb.plot.x.title !== plot.x.title) return null;
    const lines = this.comb.lines().map(({ k, at }) => ({ k, distance: Math.abs(plot.px(at) - x) }));
    const line = lines.filter((one) => one.distance < NEAR).sort((a, b) => a.distance - b.distance)[0];
    return line ? line.k : null;
  }

  pull(x, k) {
    this.comb.pull(x, k);
    this.drawMarks();
  }

  // ---- Overlay of the figure

  drawMarks() {
    const out = [];
    const upright = (plot, at, classes) => {
      const x = tenths(plot.px(at));
      if (x < plot.left - 0.05 || x > plot.right + 0.05) return false;
      out.push(drawn("line", { class: classes, x1: x, x2: x, y1: plot.top, y2: plot.bottom }));
      return true;
    };
    if (this.comb) {
      const isBase = (k) => k === this.comb.base;
      for (const plot of this.plots.filter((p) => p.x.title === this.comb.plot.x.title))
        for (const { k, at, label } of this.comb.lines())
          if (upright(plot, at, isBase(k) ? "multiple base" : "multiple"))
            out.push(drawn("text", { class: "multiple", x: tenths(plot.px(at)) + 2, y: plot.top + 9 }, label));
    }
    if (this.cursor) {
      const { plot, curve, i, x } = this.cursor;
      const dot = (one, at, value) => {
        const point = [one.px(at), one.py(value)];
        if (one.holds(point)) out.push(drawn("circle", { class: "hit", cx: tenths(point[0]), cy: tenths(point[1]), r: 2.6 }));
      };
      if (curve.kind === "path" || curve.kind === "scatter") dot(plot, x, curve.y[i]);
      else for (const one of this.linked(plot)) {
        upright(one, x, "cursor");
        for (const c of one.curves.filter((other) => other.kind === "function")) {
          const { x: xs, y } = one.values(c), k = nearest(xs, x);
          if (Number.isFinite(y[k])) dot(one, xs[k], y[k]);
        }
      }
      if (curve.kind === "ridge") dot(plot, x, curve.along);
    }
    if (this.box) {
      const [[x1, y1], [x2, y2]] = this.box;
      out.push(drawn("rect", { class: "box", x: Math.min(x1, x2), y: Math.min(y1, y2), width: Math.abs(x2 - x1), height: Math.abs(y2 - y1) }));
    }
    this.overlay.replaceChildren(...this.extra || [], ...out);
    this.drawHighlights();
    this.say();
  }

  say() {
    const parts = this.comb ? this.comb.reading() : this.cursor ? this.reading() : [];
    const texts = parts.flatMap(({ name, value, unit, digits }, n) => [
      n ? " · " : "", `${name} `, element("b", {}, Number.isNaN(value) && digits === undefined ? unit : `${shown(value, digits)}${unit ? ` ${unit}` : ""}`)]);
    this.readout.replaceChildren(...texts);
    // For programs that read the page.
    this.readout.dataset.values = JSON.stringify(parts.map(({ name, value, unit }) => [name, value, unit]));
  }

  // Draws the lines of the selected diagnosis.
  drawHighlights() {
    const out = [];
    for (const plot of this.marked.length ? this.plots.filter((p) => p.isOfFrequency) : [])
      for (const order of this.marked.flatMap((o) => [o, -o])) {
        const at = plot.x.unit === "X" ? order : order * data.speed_hz;
        const line = (x1, y1, x2, y2) => out.push(drawn("line", { x1: tenths(x1), y1: tenths(y1), x2: tenths(x2), y2: tenths(y2) }));
        if (plot.isCascade && plot.y.unit === "rpm") {
          // An order is a ray through the origin; its part inside the frame is drawn.
          const speeds = [0, 1].map((share) => plot.y.value(share)), ends = [plot.x.value(0), plot.x.value(1)];
          const limit = ends.map((hz) => hz * 60 / order).sort((a, b) => a - b);
          const [low, high] = [Math.max(speeds[0], limit[0]), Math.min(speeds[1], limit[1])];
          if (low < high) line(plot.px(order * low / 60), plot.py(low), plot.px(order * high / 60), plot.py(high));
        } else {
          const x = plot.px(at);
          if (x >= plot.left && x <= plot.right) line(x, plot.top, x, plot.bottom);
        }
      }
    this.highlights.replaceChildren(...out);
  }

  highlight(orders, names) {
    this.marked = orders;
    this.root.classList.toggle("highlighted", names.some((name) => this.title.split(/[^\w.-]+/).includes(name)));
    this.drawHighlights();
  }
}

// Cursor lines at the multiples of a frequency (harmonics), or at equal distances about a frequency (side bands).
class Comb {
  constructor(kind, plot, at) {
    this.kind = kind;
    this.plot = plot;
    const unit = plot.x.unit === "X" ? 1 : data.speed_hz || plot.step();
    this.centre = Math.abs(at === undefined ? this.strongest() : at) || unit;
    this.spacing = unit;
    this.base = kind === "harmonics" ? 1 : 0;
  }
  curve() { return this.plot.curves.find((curve) => curve.name === "measured") || this.plot.curves[this.plot.curves.length - 1]; }
  // Returns the frequency of the highest peak above 0 and below the upper end of the present range.
  strongest() {
    const { x, y } = this.plot.values(this.curve());
    let best = 0, high = -Infinity;
    for (let i = 0; i < x.length; i++) if (x[i] > 0 && this.plot.x.share(x[i]) <= 1 && y[i] > high) [best, high] = [x[i], y[i]];
    return best;
  }
  lines() {
    const out = [];
    if (this.kind === "harmonics") {
      for (let k = 1; k <= HARMONICS; k++) out.push({ k, at: k * this.centre, label: String(k) });
      if (this.plot.x.range[0] < 0) for (let k = 1; k <= HARMONICS; k++) out.push({ k: -k, at: -k * this.centre, label: String(-k) });
    } else for (let k = -SIDE_BANDS; k <= SIDE_BANDS; k++)
      out.push({ k, at: this.centre + k * this.spacing, label: k === 0 ? "0" : k > 0 ? `+${k}` : `−${-k}` });
    return out;
  }
  pull(x, k) {
    const least = 0.05 * this.plot.step();
    if (this.kind === "harmonics") this.centre = Math.max(x / k, least);
    else if (k === 0) this.centre = x;
    else this.spacing = Math.max((x - this.centre) / k, least);
  }
  // Shifts the lines by a tenth of the line spacing of the spectrum, so that high multiples can be set accurately.
  shift(by, isSpacing) {
    const step = 0.1 * this.plot.step() * by;
    if (this.kind === "side bands" && isSpacing) this.spacing = Math.max(this.spacing + step, Math.abs(step));
    else this.centre += isSpacing ? 10 * step : step;
  }
  reading() {
    const { plot } = this, { unit } = plot.x, out = [];
    const place = (name, value) => {
      out.push({ name, value, unit, digits: 6 });
      if (unit === "Hz" && data.speed_hz > 0) out.push({ name: "order", value: plot.order(value), unit: "X", digits: 5 });
    };
    place(this.kind === "harmonics" ? "Fundamental" : "Centre", this.centre);
    if (this.kind === "side bands") place("spacing", this.spacing);
    const shownLines = this.lines().filter(({ k, at }) => Math.abs(k) <= 6 && plot.x.share(at) <= 1 && plot.x.share(at) >= 0);
    for (const { label, at } of shownLines) {
      const value = plot.amplitude(this.curve(), at);
      if (Number.isFinite(value)) out.push({ name: label, value, unit: plot.y.unit, digits: 3 });
    }
    return out;
  }
}

// ---- Orbits and spectra of a chosen time

// Computes the discrete Fourier transform of a complex signal in place; the number of samples is a power of two.
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) { [re[i], re[j]] = [re[j], re[i]]; [im[i], im[j]] = [im[j], im[i]]; }
  }
  for (let size = 2; size <= n; size *= 2) {
    const half = size / 2, angle = -2 * Math.PI / size;
    for (let k = 0; k < half; k++) {
      const c = Math.cos(angle * k), s = Math.sin(angle * k);
      for (let i = k; i < n; i += size) {
        const a = re[i + half] * c - im[i + half] * s, b = re[i + half] * s + im[i + half] * c;
        re[i + half] = re[i] - a; im[i + half] = im[i] - b;
        re[i] += a; im[i] += b;
      }
    }
  }
}

// Returns the amplitudes of x + jy, forward and reverse bins from 0 Hz: root of the mean power of segments that overlap by half, with
// a Hann window, without the mean. For a real signal (`y` null) both are half its amplitude.
function powers(x, y, length) {
  const forward = new Float64Array(length / 2 + 1), reverse = new Float64Array(length / 2 + 1);
  const mean = (values, from) => { let sum = 0; for (let i = from; i < from + length; i++) sum += values[i]; return sum / length; };
  let count = 0;
  for (let from = 0; from + length <= x.length; from += length / 2) {
    const re = new Float64Array(length), im = new Float64Array(length), [mx, my] = [mean(x, from), y ? mean(y, from) : 0];
    for (let i = 0; i < length; i++) {
      const window = (1 - Math.cos(2 * Math.PI * i / length)) / length;
      re[i] = (x[from + i] - mx) * window;
      if (y) im[i] = (y[from + i] - my) * window;
    }
    transform(re, im);
    for (let k = 0; k <= length / 2; k++) {
      const other = (length - k) % length;
      forward[k] += re[k] ** 2 + im[k] ** 2;
      reverse[k] += re[other] ** 2 + im[other] ** 2;
    }
    count++;
  }
  return { forward: forward.map((p) => Math.sqrt(p / count)), reverse: reverse.map((p) => Math.sqrt(p / count)), count };
}

class Excerpt {
  constructor({ rate_hz, segment, planes, stretches }) {
    Object.assign(this, { rate: rate_hz, segment, planes });
    this.stretches = stretches.map((s) => ({ ...s, end: s.start + s.count / rate_hz }));
  }
  // Returns the samples of a time range within one stretch; a longer range is shortened.
  window(start, length) {
    const s = this.stretches.find((one) => start < one.end - MIN_SAMPLES / this.rate) || this.stretches[this.stretches.length - 1];
    const most = Math.max(s.count - MIN_SAMPLES, 0);
    const first = clamp(Math.round((start - s.start) * this.rate), 0, most);
    const count = clamp(Math.round(length * this.rate), Math.min(MIN_SAMPLES, s.count), s.count - first);
    return { stretch: s, first, count, start: s.start + first / this.rate };
  }
  signal(kind, probe, { stretch, first, count }) {
    const packed = stretch[kind][probe];
    packed.numbers ||= new Int16Array(bytes(packed.values).buffer);
    return Float64Array.from(packed.numbers.subarray(first, first + count), (n) => n === -32768 ? NaN : packed.offset + n * packed.step);
  }
  plane(kind, number, window) {
    const { probes: [i, k], angles: [a, b] } = this.planes[number], det = Math.sin(b - a);
    const [p, q] = [this.signal(kind, i, window), this.signal(kind, k, window)];
    return [p.map((u, n) => (Math.sin(b) * u - Math.sin(a) * q[n]) / det), p.map((u, n) => (Math.cos(a) * q[n] - Math.cos(b) * u) / det)];
  }
  marks({ stretch, first, count }) { return stretch.keyphasor.map((at) => at - first).filter((at) => at >= 0 && at < count); }
  // Returns the length of the longest segment, a power of two of samples, at most that of the report.
  length(count) { return Math.min(2 ** Math.floor(Math.log2(count)), this.segment || 4096); }
}

// Replaces each missing reading by the value before it: a single NaN would make every bin NaN.
function complete(values) {
  let last = values.find(Number.isFinite) || 0;
  return values.map((x) => last = Number.isFinite(x) ? x : last);
}

const less = (a, b) => a.map((x, i) => x - b[i]);
const spaced = (count, step, start = 0) => Float64Array.from({ length: count }, (_, i) => start + i * step);

// Curves of a figure over a time range, by their names.
const computed = {
  trace(figure, excerpt, window) {
    const scale = figure.plots[0].x.unit === "ms" ? 1e3 : 1;
    const x = spaced(window.count, scale / excerpt.rate, window.start * scale);
    const [measured, twin] = ["measured", "twin"].map((kind) => excerpt.signal(kind, figure.source.index, window));
    return { x, measured, twin, residual: less(measured, twin), range: [x[0], x[x.length - 1]],
      marks: excerpt.marks(window).map((at) => x[at]) };
  },
  spectrum(figure, excerpt, window) {
    const length = excerpt.length(window.count);
    const [measured, twin] = ["measured", "twin"].map((kind) => complete(excerpt.signal(kind, figure.source.index, window)));
    const of = (values) => powers(values, null, length);
    const spectra = [measured, twin, less(measured, twin)].map(of), [m, t, r] = spectra.map((s) => s.forward.map((a) => 2 * a));
    const cut = 3, part = (a) => a.subarray(cut);
    return { x: part(spaced(m.length, excerpt.rate / length)), measured: part(m), twin: part(t), residual: part(r), averages: spectra[0].count };
  },
  full(figure, excerpt, window) {
    const length = excerpt.length(window.count), out = {};
    for (const kind of ["measured", "twin"]) {
      const [x, y] = excerpt.plane(kind, figure.source.index, window).map(complete);
      const { forward, reverse, count } = powers(x, y, length);
      out.averages = count;
      // The bins about 0 Hz contain the mean, spread by the window.
      for (let k = 0; k < 3; k++) forward[k] = reverse[k] = NaN;
      out[kind] = Float64Array.from([...[...reverse].slice(1).reverse(), ...forward]);
    }
    out.x = spaced(length + 1, excerpt.rate / length, -excerpt.rate / 2);
    return out;
  },
  orbit(figure, excerpt, window) {
    const marks = excerpt.marks(window), turn = marks.length > 1 ? marks[1] - marks[0] : 0;
    const blank = turn ? 2 + Math.floor(0.035 * turn) : 0, out = { dots: {} };
    for (const kind of ["measured", "twin"]) {
      const [x, y] = excerpt.plane(kind, figure.source.index, window);
      out.dots[kind] = marks.map((at) => [x[at], y[at]]);
      for (const at of marks) for (let i = Math.max(0, at - blank + 1); i < at; i++) x[i] = NaN;
      out[kind] = { x, y };
    }
    return out;
  },
  // Computes the 1X orbit over whole revolutions between keyphasor pulses.
  filtered(figure, excerpt, window) {
    const marks = excerpt.marks(window), out = { dots: {} };
    if (marks.length < 2) return null;
    for (const kind of ["measured", "twin"]) {
      const parts = excerpt.plane(kind, figure.source.index, window).map((values) => {
        let [cos, sin, count] = [0, 0, 0];
        for (let n = 1; n < marks.length; n++) for (let i = marks[n - 1]; i < marks[n]; i++) {
          if (!Number.isFinite(values[i])) continue;
          const angle = 2 * Math.PI * (i - marks[n - 1]) / (marks[n] - marks[n - 1]);
          cos += values[i] * Math.cos(angle); sin += values[i] * Math.sin(angle); count++;
        }
        return [2 * cos / count, 2 * sin / count];
      });
      const [x, y] = parts.map(([c, s]) => spaced(181, 2 * Math.PI / 180).map((a) => c * Math.cos(a) + s * Math.sin(a)));
      out.dots[kind] = [[x[0], y[0]]];
      for (let i = 175; i < 180; i++) x[i] = NaN;
      out[kind] = { x, y };
    }
    return out;
  },
};

// Shows a time range in a figure, or the static figure without one.
function showRange(figure, excerpt, window) {
  const made = window && computed[figure.source.kind](figure, excerpt, window);
  figure.extra = [];
  for (const plot of figure.plots) {
    if (!plot.stillHome) {
      plot.stillHome = { x: [[...plot.x.home], [...plot.x.limits]], y: [[...plot.y.home], [...plot.y.limits]] };
      for (const curve of plot.curves) curve.stillPacked = curve.packed;
    }
    plot.replaced = Boolean(made);
    for (const [name, axis] of [["x", plot.x], ["y", plot.y]]) {
      [axis.home, axis.limits] = plot.stillHome[name].map((range) => [...range]);
    }
    for (const curve of plot.curves) {
      const values = made && made[curve.name];
      if (values) [curve.x, curve.y] = values.x ? [values.x, values.y] : [made.x, values];
      else delete curve.x;
    }
    if (made) fit(plot, made);
    plot.x.reset();
    plot.y.reset();
  }
  figure.cursor = null;
  if (made) figure.extra = extras(figure, made);
  figure.draw();
  return made;
}

// Sets the ranges of the axes for other values: those of the static figure where the values fit.
function fit(plot, made) {
  const extent = (name) => {
    let [low, high] = [Infinity, -Infinity];
    for (const curve of plot.curves) for (const value of curve[name]) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    return [low, high];
  };
  if (made.range) {
    plot.x.home = [...made.range];
    plot.x.limits = [...made.range];
  }
  if (plot.isEqual) {
    const half = Math.max(...["x", "y"].map((name) => { const [low, high] = extent(name); return (high - low) / 2; })) * 1.6 || 1;
    for (const name of ["x", "y"]) {
      const [low, high] = extent(name), middle = (low + high) / 2;
      plot[name].home = plot[name].limits = [middle - half, middle + half];
    }
  } else {
    const [low, high] = extent("y"), axis = plot.y, air = axis.log ? 0 : 0.05 * (high - low);
    const highest = axis.to(axis.log ? 1.6 * high : high + air), lowest = axis.log || axis.home[0] === 0 ? axis.home[0] : low - air;
    if (Number.isFinite(highest)) axis.home = [Math.min(axis.home[0], lowest), Math.max(axis.home[1], highest)];
    axis.limits = [...axis.home];
  }
}

// Returns the keyphasor marks of the time range.
function extras(figure, made) {
  const out = [], [plot] = figure.plots;
  const inFrame = ([x, y]) => plot.holds([x, y]);
  for (const [kind, points] of Object.entries(made.dots || {}))
    for (const [x, y] of points.map(([a, b]) => [plot.px(a), plot.py(b)]).filter(inFrame))
      out.push(drawn("circle", kind === "measured" ? { cx: tenths(x), cy: tenths(y), r: 3.6, fill: "var(--measured)" }
        : { cx: tenths(x), cy: tenths(y), r: 2.4, fill: "var(--paper)", stroke: "var(--twin)", "stroke-width": 1.4 }));
  for (const at of made.marks || [])
    for (const one of figure.plots) {
      const x = tenths(one.px(at));
      out.push(drawn("line", { x1: x, x2: x, y1: one.top, y2: one.bottom, stroke: "var(--faint)", "stroke-width": 0.6 }));
    }
  return out;
}

// Returns the control of the time range, one for all figures.
function rangeControl(figures, excerpt) {
  const last = excerpt.stretches[excerpt.stretches.length - 1].end, first = excerpt.stretches[0].start;
  const longest = Math.max(...excerpt.stretches.map((s) => s.end - s.start));
  const usual = Math.min(longest, excerpt.segment / excerpt.rate || longest);
  const number = (value, label) => element("input", {
    type: "number", min: label === "start" ? first : 0, max: last, step: "any", value: Number(value.toPrecision(4)), "aria-label": `${label} of the time range, s` });
  const start = number(first, "start"), length = number(usual, "length");
  const slider = element("input", { type: "range", min: first, max: last, step: "any", value: first, "aria-label": "start of the time range" });
  const state = element("output", { "aria-live": "polite" }, "whole recording");
  let pending = 0;
  const apply = () => {
    clearTimeout(pending);
    pending = setTimeout(() => {
      const window = excerpt.window(Number(start.value) || 0, Number(length.value) || usual);
      slider.value = window.start;
      const made = figures.map((figure) => showRange(figure, excerpt, window));
      const averages = made.map((one) => one && one.averages).find(Boolean);
      const end = window.start + window.count / excerpt.rate;
      state.textContent = `${shown(window.start, 6)} to ${shown(end, 6)} s, ${window.count} samples` +
        (averages ? `, ${averages} ${averages === 1 ? "average" : "averages"}` : "");
      state.dataset.window = JSON.stringify([window.start, end, window.count]);
    }, 60);
  };
  start.addEventListener("change", apply);
  length.addEventListener("change", apply);
  slider.addEventListener("input", () => { start.value = Number(Number(slider.value).toPrecision(5)); apply(); });
  const whole = element("button", { type: "button", on: { click: () => {
    clearTimeout(pending);
    figures.forEach((figure) => showRange(figure, excerpt, null));
    state.textContent = "whole recording";
    delete state.dataset.window;
  } } }, "Whole recording");
  const gaps = excerpt.stretches.length > 1 ? ` (${excerpt.stretches.length} stretches of the recording)` : "";
  return element("form", { class: "range", "aria-label": "Time range of orbits and spectra", on: { submit: (event) => { event.preventDefault(); apply(); } } },
    element("strong", {}, `Time range of orbits, traces and spectra${gaps}`),
    element("label", {}, "start, s", start), element("label", {}, "length, s", length), slider, whole, state);
}

// ---- The page

const roots = document.querySelectorAll("figure");
const figures = data.figures.map((spec, n) => spec.plots.length ? new Figure(roots[n], spec) : null).filter(Boolean);

if (data.excerpt && data.excerpt.stretches.length) {
  const chosen = figures.filter((figure) => figure.source);
  const excerpt = new Excerpt(data.excerpt);
  if (chosen.length) chosen[0].root.closest("section").before(rangeControl(chosen, excerpt));
}

// A click on a diagnosis marks its lines, and the figures and rows of its bearing.
(data.diagnoses || []).forEach((diagnosis, n) => {
  const row = document.querySelector(`tr[data-diagnosis="${n}"]`), cell = row && row.firstElementChild;
  if (!cell) return;
  const button = element("button", { type: "button", "aria-pressed": "false", title: "Marks the lines of this diagnosis in every figure" }, cell.textContent);
  button.addEventListener("click", () => {
    const is = button.getAttribute("aria-pressed") !== "true";
    document.querySelectorAll("tr[data-diagnosis] button").forEach((other) => other.setAttribute("aria-pressed", "false"));
    button.setAttribute("aria-pressed", is);
    const [orders, names] = is ? [diagnosis.orders, diagnosis.names] : [[], []];
    figures.forEach((figure) => figure.highlight(orders, names));
    document.querySelectorAll("tbody tr").forEach((other) => other.classList.toggle("highlighted",
      is && (other === row || [...other.children].some((one) => names.includes(one.textContent)))));
  });
  cell.replaceChildren(button);
});
})();
