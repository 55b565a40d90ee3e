"use strict";
/* A picture that is zoomed and panned; places are those of the film: pixel centres at whole numbers, x to the right, y down. */
class View {
  constructor(canvas, width, height, paint) {
    Object.assign(this, { canvas, width, height, paint, picture: null, scale: 1, left: 0, top: 0, tool: null, pointers: new Map(), drag: null });
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); this.zoom(Math.exp(-e.deltaY / 400), e.offsetX, e.offsetY); }, { passive: false });
    for (const [name, does] of [["pointerdown", this.down], ["pointermove", this.move], ["pointerup", this.up], ["pointercancel", this.up]])
      canvas.addEventListener(name, does.bind(this));
    new ResizeObserver(() => this.resized()).observe(canvas);
    this.resized();
  }
  resized() {
    const ratio = window.devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
    if (!box.width) return;
    const narrower = this.canvas.width !== Math.round(box.width * ratio);
    this.canvas.width = Math.round(box.width * ratio); this.canvas.height = Math.round(box.height * ratio);
    if (narrower) this.fit(); else this.draw();  // a phone's bars come and go in height
  }
  fit() {
    const box = this.canvas.getBoundingClientRect();
    this.scale = Math.min(box.width / this.width, box.height / this.height);
    this.left = (box.width - this.scale * this.width) / 2; this.top = (box.height - this.scale * this.height) / 2;
    this.draw();
  }
  show(picture) { this.picture = picture; this.draw(); }
  zoom(times, x, y) {
    const scale = Math.min(Math.max(this.scale * times, 0.02), 80), box = this.canvas.getBoundingClientRect();
    x = x ?? box.width / 2; y = y ?? box.height / 2;
    this.left = x - (x - this.left) * scale / this.scale; this.top = y - (y - this.top) * scale / this.scale; this.scale = scale;
    this.draw();
  }
  pan(dx, dy) { this.left += dx; this.top += dy; this.draw(); }
  film(x, y) { return [(x - this.left) / this.scale - 0.5, (y - this.top) / this.scale - 0.5]; }
  screen([x, y]) { return [(x + 0.5) * this.scale + this.left, (y + 0.5) * this.scale + this.top]; }
  middle() { const box = this.canvas.getBoundingClientRect(); return this.film(box.width / 2, box.height / 2); }
  draw() {
    const ratio = window.devicePixelRatio || 1, c = this.canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0); c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.imageSmoothingEnabled = this.scale < 1;
    if (this.picture) c.drawImage(this.picture, this.left, this.top, this.width * this.scale, this.height * this.scale);
    this.paint(c, this);
  }
  down(e) {
    this.canvas.setPointerCapture(e.pointerId); this.pointers.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (this.pointers.size > 1) { this.drag = null; return; }
    const hold = this.tool && this.tool.down(this.film(e.offsetX, e.offsetY), [e.offsetX, e.offsetY]);
    this.drag = { hold, from: [e.offsetX, e.offsetY], moved: false };
  }
  move(e) {
    const before = this.pointers.get(e.pointerId);
    if (!before) return;
    const now = [e.offsetX, e.offsetY];
    if (this.pointers.size === 2) {
      const other = [...this.pointers].find(([id]) => id !== e.pointerId)[1], apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      this.zoom(apart(now) / Math.max(apart(before), 1), other[0], other[1]);
    } else if (this.drag) {
      this.drag.moved ||= Math.hypot(now[0] - this.drag.from[0], now[1] - this.drag.from[1]) > 3;
      if (this.drag.moved && this.drag.hold) this.drag.hold(this.film(...now));
      else if (this.drag.moved) this.pan(now[0] - before[0], now[1] - before[1]);
    }
    this.pointers.set(e.pointerId, now);
  }
  up(e) {
    this.pointers.delete(e.pointerId);
    const { drag } = this;
    this.drag = null;
    if (drag && !drag.moved && !drag.hold && this.tool && e.type === "pointerup") this.tool.click(this.film(e.offsetX, e.offsetY));
  }
}

function pictureOf(address) { return new Promise((done) => { const image = new Image(); image.onload = () => done(image); image.src = address; }); }

function element(name, given = {}, ...inside) {
  const svg = ["svg", "path", "line", "text", "rect"].includes(name);
  const made = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(given)) made.setAttribute(key, value);
  made.append(...inside);
  return made;
}
