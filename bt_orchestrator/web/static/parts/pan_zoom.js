// Zoom and pan of a picture, by its view box: pointers, keys and calls do the same thing.

const CLOSEST = 24; // times larger than the whole
const STEP = 1.4;
const PART = 0.15; // of what is seen, for one press of an arrow key

const KEYS = {
  '+': (one) => one.zoom(STEP),
  '=': (one) => one.zoom(STEP),
  '-': (one) => one.zoom(1 / STEP),
  0: (one) => one.whole(),
  ArrowLeft: (one) => one.move(-PART, 0),
  ArrowRight: (one) => one.move(PART, 0),
  ArrowUp: (one) => one.move(0, -PART),
  ArrowDown: (one) => one.move(0, PART),
};

export class PanZoom {
  /** @param {HTMLElement} frame holds the picture, and has the focus for the keys */
  constructor(frame) {
    this.svg = null;
    this.area = null; // of the whole picture: {x, y, width, height}
    this.view = null; // what is seen of it
    this.pointers = new Map();
    frame.addEventListener('keydown', (event) => this.#key(event));
    frame.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    frame.addEventListener('pointerdown', (event) => this.#down(event));
    frame.addEventListener('pointermove', (event) => this.#moved(event));
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      frame.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
  }

  /** Take a picture; one of the same size is seen as the one before it. */
  show(svg) {
    const { x, y, width, height } = svg.viewBox.baseVal;
    const isSame = this.area?.width === width && this.area?.height === height;
    this.svg = svg;
    this.area = { x, y, width, height };
    this.#look(isSame ? this.view : this.area);
  }

  whole() {
    this.#look(this.area);
  }

  /** @param {DOMPoint} [at] what stays where it is; else the middle */
  zoom(times, at) {
    if (!this.view) return;
    const { x, y, width, height } = this.view;
    const most = this.area.width / CLOSEST;
    const newWidth = Math.min(Math.max(width / times, most), this.area.width);
    const share = newWidth / width;
    const centre = at ?? { x: x + width / 2, y: y + height / 2 };
    this.#look({
      x: centre.x - (centre.x - x) * share,
      y: centre.y - (centre.y - y) * share,
      width: newWidth,
      height: height * share,
    });
  }

  /** Move by parts of what is seen. */
  move(right, down) {
    if (!this.view) return;
    const { x, y, width, height } = this.view;
    this.#look({ x: x + right * width, y: y + down * height, width, height });
  }

  /** Bring a part of the picture into view; where all of it is seen, nothing moves. */
  lookAt(part) {
    if (!this.view || this.view.width >= this.area.width) return;
    const box = part.getBBox();
    const { width, height } = this.view;
    const x = box.x + box.width / 2 - width / 2;
    this.#look({ x, y: box.y + box.height / 2 - height / 2, width, height });
  }

  #look(view) {
    const { x, y, width, height } = this.area;
    const within = (at, from, room, size) => Math.min(Math.max(at, from), from + room - size);
    this.view = {
      ...view,
      x: within(view.x, x, width, view.width),
      y: within(view.y, y, height, view.height),
    };
    const seen = this.view;
    this.svg.setAttribute('viewBox', `${seen.x} ${seen.y} ${seen.width} ${seen.height}`);
  }

  #point(event) {
    return new DOMPoint(event.clientX, event.clientY).matrixTransform(
      this.svg.getScreenCTM().inverse(),
    );
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
    KEYS[event.key](this);
    event.preventDefault();
  }

  #wheel(event) {
    if (!event.ctrlKey || !this.svg) return; // a plain wheel scrolls the page; a pinch has ctrlKey
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY / 200), this.#point(event));
  }

  #down(event) {
    if (!this.svg || event.button !== 0) return;
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  #moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId);
    if (others.length) {
      const other = others[0][1];
      const gap = (one) => Math.hypot(one.x - other.x, one.y - other.y) || 1;
      this.zoom(gap(now) / gap(before), this.#point(event));
    } else {
      if (Math.hypot(now.x - before.x, now.y - before.y) < 4) return; // a click, not a drag
      event.currentTarget.setPointerCapture(event.pointerId);
      const { a } = this.svg.getScreenCTM();
      const { x, y } = this.view;
      this.#look({ ...this.view, x: x - (now.x - before.x) / a, y: y - (now.y - before.y) / a });
    }
    this.pointers.set(event.pointerId, now);
  }
}
