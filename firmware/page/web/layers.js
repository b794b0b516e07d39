// The masks, layer by layer, as finely as somebody looks: what the printer sends is the part of a mask that is shown, a square of its pixels a pixel.
"use strict";

// @param canvas  where it is drawn; takes mouse, touch and keys
// @param address of a part of a layer's mask, counted from 0: address(layer, x, y, step)
// @param told    called with true when the layer is shown, with false when the printer does not show it
// @param tapped  called with the pixel of the mask that somebody taps, from its corner
function makeLayerView(canvas, address, told, tapped) {
  const to = canvas.getContext("2d"), most = 640, kept = new Map();
  let pixels = [1, 1], layer = 0, middle = [0, 0], scale = 1, least = 1, ghost = true, marks = [], asked = null, missing = null, shown = null, dirty = false;

  // Mask pixels that are in sight, and how many of them a pixel of the picture stands for.
  function windowNow() {
    const across = [canvas.clientWidth / scale, canvas.clientHeight / scale].map((wide, axis) => Math.min(wide, pixels[axis]));
    const step = Math.min(64, Math.max(1, Math.floor(1 / scale), Math.ceil(Math.max(...across) / (most - 1))));
    const [x, y] = [0, 1].map((axis) => Math.min(pixels[axis] - 1, Math.max(0, Math.floor((middle[axis] - across[axis] / 2) / step) * step)));
    return {x, y, step};
  }
  const keyOf = (n, {x, y, step}) => `${n} ${x} ${y} ${step}`;
  async function fetchPart(n, part) {
    const reply = await fetch(address(n, part.x, part.y, part.step));
    if (!reply.ok) throw new Error(`status ${reply.status}`);
    const bitmap = await createImageBitmap(await reply.blob()), scratch = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    scratch.drawImage(bitmap, 0, 0);
    return scratch.getImageData(0, 0, bitmap.width, bitmap.height);
  }
  // One request at a time, and then for what is in sight by now: the layer, then the one below it.
  async function load() {
    if (asked) return;
    const part = windowNow();
    const wanted = [layer, ghost ? layer - 1 : -1].find((n) => n >= 0 && !kept.has(keyOf(n, part)) && keyOf(n, part) !== missing);
    if (wanted === undefined) return;
    const mine = asked = {};
    try {
      const data = await fetchPart(wanted, part);
      if (asked !== mine) return;
      kept.set(keyOf(wanted, part), {data, n: wanted, part});
      if (kept.size > 80) kept.delete(kept.keys().next().value);
      missing = null;
    } catch {
      if (asked !== mine) return;
      missing = keyOf(wanted, part);
      if (wanted === layer) told(false);
    }
    asked = null;
    draw();
    load();
  }
  // White cures, orange only for supports, blue is the layer below where nothing cures above it.
  function paint(top, below) {
    const {data, width, height} = top.data, image = new ImageData(width, height), out = image.data;
    const under = below && below.data.width === width && below.data.height === height ? below.data.data : null;
    for (let i = 0; i < data.length; i += 4) {
      const light = data[i], support = data[i + 1], ghostly = under ? Math.max(0, under[i] - light) : 0;
      out[i] = light + 0.16 * ghostly;
      out[i + 1] = light - 0.32 * support + 0.3 * ghostly;
      out[i + 2] = light - 0.75 * support + 0.6 * ghostly;
      out[i + 3] = 255;
    }
    const sheet = new OffscreenCanvas(width, height);
    sheet.getContext("2d").putImageData(image, 0, 0);
    return sheet;
  }
  function draw() {
    if (dirty) return;
    dirty = true;
    requestAnimationFrame(() => { dirty = false; drawNow(); });
  }
  function drawNow() {
    const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, tall = canvas.clientHeight;
    if (!wide || !pixels[0]) return;
    const fits = Math.min(wide / pixels[0], tall / pixels[1]);
    if (least !== fits) [scale, least] = [scale === least ? fits : scale, fits];
    if (canvas.width !== Math.round(wide * ratio) || canvas.height !== Math.round(tall * ratio)) Object.assign(canvas, {width: Math.round(wide * ratio), height: Math.round(tall * ratio)});
    to.setTransform(ratio, 0, 0, ratio, 0, 0);
    to.fillStyle = "#141a21";
    to.fillRect(0, 0, wide, tall);
    const at = (x, y) => [(x - middle[0]) * scale + wide / 2, (y - middle[1]) * scale + tall / 2];
    to.fillStyle = "#000";
    to.fillRect(...at(0, 0), pixels[0] * scale, pixels[1] * scale);
    const part = windowNow(), now = kept.get(keyOf(layer, part)), below = ghost ? kept.get(keyOf(layer - 1, part)) : null;
    if (now) shown = {sheet: paint(now, below), ...now};
    to.imageSmoothingEnabled = false;
    if (shown) {
      const {x, y, step} = shown.part, [left, top] = at(x, y);
      to.drawImage(shown.sheet, left, top, shown.sheet.width * step * scale, shown.sheet.height * step * scale);
    }
    if (now) told(true);
    to.lineWidth = 2;
    for (const mark of marks) {
      to.strokeStyle = mark.layer === layer ? "#ff5b4d" : "#ff5b4d66";
      const [x, y] = at(mark.x, mark.y);
      if (Math.abs(mark.layer - layer) > 20) continue;
      to.beginPath();
      to.arc(x, y, 14, 0, 2 * Math.PI);
      to.stroke();
    }
    load();
  }
  function zoomBy(factor, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
    const next = Math.max(least, Math.min(40, scale * factor));
    const from = [x - canvas.clientWidth / 2, y - canvas.clientHeight / 2];
    middle = [0, 1].map((axis) => middle[axis] + from[axis] / scale - from[axis] / next);
    scale = next;
    keepInside();
  }
  function keepInside() {
    middle = [0, 1].map((axis) => Math.max(0, Math.min(pixels[axis], middle[axis])));
    if (scale === least) middle = pixels.map((side) => side / 2);
    draw();
  }
  const fingers = new Map();
  let moved = 0;
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    moved = 0;
  };
  canvas.onpointerup = canvas.onpointercancel = (event) => {
    fingers.delete(event.pointerId);
    if (event.type !== "pointerup" || moved > 6 || fingers.size) return;
    const place = [event.offsetX - canvas.clientWidth / 2, event.offsetY - canvas.clientHeight / 2].map((by, axis) => middle[axis] + by / scale);
    if (place.every((value, axis) => value >= 0 && value < pixels[axis])) tapped(place);
  };
  canvas.onpointermove = (event) => {
    const from = fingers.get(event.pointerId);
    if (!from) return;
    const now = [event.offsetX, event.offsetY], by = [now[0] - from[0], now[1] - from[1]], other = [...fingers].find(([id]) => id !== event.pointerId);
    moved += Math.hypot(...by);
    fingers.set(event.pointerId, now);
    if (other) {
      const apart = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]) || 1;
      zoomBy(apart(now) / apart(from), (now[0] + other[1][0]) / 2, (now[1] + other[1][1]) / 2);
    }
    middle = [0, 1].map((axis) => middle[axis] - by[axis] / scale / (other ? 2 : 1));
    keepInside();
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(Math.exp(-event.deltaY * 0.002), event.offsetX, event.offsetY);
  }, {passive: false});
  canvas.onkeydown = (event) => {
    const [x, y] = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key] || [0, 0];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (x || y) middle = [middle[0] + 40 * x / scale, middle[1] + 40 * y / scale];
    else if (event.key === "+" || event.key === "=") zoomBy(1.5);
    else if (event.key === "-") zoomBy(1 / 1.5);
    else if (event.key === "Home") scale = least;
    else return;
    event.preventDefault();
    keepInside();
  };
  new ResizeObserver(draw).observe(canvas);

  return {
    // Another job's masks. Nothing of the one before stays, nor may what is on its way come in its place.
    begin(of) {
      kept.clear();
      asked = shown = missing = null;
      pixels = of;
      scale = least;
      middle = pixels.map((side) => side / 2);
      draw();
    },
    show(n) {
      layer = n;
      missing = null;
      draw();
    },
    // Looks at a part of the panel, [first, end] across and along, unless somebody has looked closer.
    fit(box) {
      if (scale !== least || !canvas.clientWidth) return;
      const room = box.map(([first, end], axis) => [canvas.clientWidth, canvas.clientHeight][axis] / (1.2 * (end - first)));
      scale = Math.max(least * 1.001, Math.min(40, ...room));
      middle = box.map(([first, end]) => (first + end) / 2);
      keepInside();
    },
    // Looks closely at a pixel.
    lookAt(x, y) {
      scale = Math.max(scale, 2);
      middle = [x, y];
      keepInside();
    },
    ghost(on) { ghost = on; draw(); },
    marks(list) { marks = list; draw(); },
    // What of the layer is in sight, for tests: its number, light and the share of supports.
    facts() {
      const now = kept.get(keyOf(layer, windowNow()));
      if (!now) return null;
      let light = 0, supports = 0;
      for (let i = 0; i < now.data.data.length; i += 4) [light, supports] = [light + now.data.data[i], supports + now.data.data[i + 1]];
      return {layer, light, supports, scale, ...now.part};
    },
  };
}
