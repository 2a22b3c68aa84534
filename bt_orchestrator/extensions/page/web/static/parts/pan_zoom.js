// Zoom and pan of a picture, by its view box: pointers, keys and calls do the same thing.

const CLOSEST = 6; // pixels a point of the picture
const READABLE = 1.1; // below, its smallest text cannot be read
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
    this.frame = frame;
    this.svg = null;
    this.area = null; // of the whole picture: {x, y, width, height}
    this.centre = { x: 0, y: 0 }; // of what is seen
    this.scale = 1; // pixels a point
    this.isMoved = false; // by a person, from where it began
    this.pointers = new Map();
    frame.addEventListener('keydown', (event) => this.#key(event));
    frame.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    frame.addEventListener('pointerdown', (event) => this.#down(event));
    frame.addEventListener('pointermove', (event) => this.#moved(event));
    for (const name of /** @type {const} */ ([
      'pointerup',
      'pointercancel',
      'lostpointercapture',
    ])) {
      frame.addEventListener(name, ({ pointerId }) => this.pointers.delete(pointerId));
    }
  }

  /**
   * Take a picture; one of the same size is seen as the one before it.
   * @param {SVGGraphicsElement} [start] what to begin with where the whole cannot be read
   */
  show(svg, start) {
    const { x, y, width, height } = svg.viewBox.baseVal;
    const isSame = this.area?.width === width && this.area?.height === height;
    this.svg = svg;
    this.area = { x, y, width, height };
    if (isSame) this.#look(this.centre, this.scale);
    else this.#begin(start);
  }

  /** The frame has another size: begin anew, unless a person has chosen what is seen. */
  resized(start) {
    if (!this.svg || !this.frame.checkVisibility()) return;
    if (this.isMoved) this.#look(this.centre, this.scale);
    else this.#begin(start);
  }

  whole() {
    if (!this.svg) return;
    this.isMoved = true;
    const { x, y, width, height } = this.area;
    this.#look({ x: x + width / 2, y: y + height / 2 }, this.#least());
  }

  /** @param {{x: number, y: number}} [at] what stays where it is; else the middle */
  zoom(times, at = this.centre) {
    if (!this.svg) return;
    this.isMoved = true;
    const scale = Math.min(Math.max(this.scale * times, this.#least()), CLOSEST);
    const share = this.scale / scale;
    const { x, y } = this.centre;
    this.#look({ x: at.x - (at.x - x) * share, y: at.y - (at.y - y) * share }, scale);
  }

  /** Move by parts of what is seen. */
  move(right, down) {
    if (!this.svg) return;
    const { clientWidth, clientHeight } = this.frame;
    this.#moveBy((right * clientWidth) / this.scale, (down * clientHeight) / this.scale);
  }

  /** Bring a part of the picture into view, large enough to be read. */
  lookAt(part) {
    if (!this.svg) return;
    const { x, y, width, height } = part.getBBox();
    const centre = { x: x + width / 2, y: y + height / 2 };
    if (this.scale < READABLE) this.#look(centre, READABLE);
    else if (this.scale > this.#least()) this.#look(centre, this.scale);
  }

  /** What cannot be read as a whole begins as large as it has to be, at its start or upper left. */
  #begin(start) {
    this.whole();
    if (this.scale < READABLE) {
      const { x, y, width } = this.area;
      this.#look({ x, y }, Math.max(this.frame.clientWidth / width, READABLE));
      if (start) this.lookAt(start);
    }
    this.isMoved = false;
  }

  /** The scale at which the whole is seen. */
  #least() {
    const { clientWidth, clientHeight } = this.frame;
    return Math.min(clientWidth / this.area.width, clientHeight / this.area.height) || 1;
  }

  #moveBy(right, down) {
    this.isMoved = true;
    this.#look({ x: this.centre.x + right, y: this.centre.y + down }, this.scale);
  }

  #look(centre, scale) {
    const { x, y, width, height } = this.area;
    const seen = { width: this.frame.clientWidth / scale, height: this.frame.clientHeight / scale };
    this.scale = scale;
    this.centre = {
      x: within(centre.x, x, width, seen.width),
      y: within(centre.y, y, height, seen.height),
    };
    const left = this.centre.x - seen.width / 2;
    const top = this.centre.y - seen.height / 2;
    this.svg.setAttribute('viewBox', `${left} ${top} ${seen.width} ${seen.height}`);
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
      this.#moveBy((before.x - now.x) / this.scale, (before.y - now.y) / this.scale);
    }
    this.pointers.set(event.pointerId, now);
  }
}

/** The middle of what is seen: never beside the picture. */
function within(middle, from, size, seen) {
  if (seen >= size) return from + size / 2;
  return Math.min(Math.max(middle, from + seen / 2), from + size - seen / 2);
}
