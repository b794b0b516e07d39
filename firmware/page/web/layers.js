// The masks, layer by layer, as finely as somebody looks: what the printer sends is the part of a mask that is shown, a square of its pixels a pixel.
"use strict";

// @param canvas  where it is drawn; takes mouse, touch and keys
// @param address of a part of a layer's mask, counted from 0: address(layer, x, y, step)
// @param told    called with true when the layer is shown, with false when the printer does not show it
// @param tapped  called with the pixel of the mask that somebody taps, from its corner
function makeLayerView(canvas, address, told, tapped) {
  const to = canvas.getContext("2d"), most = 640, kept = new Map();
  let pixels = [1, 1], layer = 0, ghost = true, marks = [], asked = null, missing = null, shown = null;
  let middle = [0, 0], scale = 1, near = false;  // near: somebody looks at a part, and not at all of it

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
  const least = () => Math.min(canvas.clientWidth / pixels[0], canvas.clientHeight / pixels[1]);
  const draw = onceAFrame(drawNow);
  function drawNow() {
    const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, tall = canvas.clientHeight;
    if (!wide) return;
    near = near && scale > least();
    if (!near) [scale, middle] = [least(), pixels.map((side) => side / 2)];
    if (canvas.width !== Math.round(wide * ratio) || canvas.height !== Math.round(tall * ratio)) Object.assign(canvas, {width: Math.round(wide * ratio), height: Math.round(tall * ratio)});
    to.setTransform(ratio, 0, 0, ratio, 0, 0);
    to.fillStyle = "#141a21";
    to.fillRect(0, 0, wide, tall);
    const at = (x, y) => [(x - middle[0]) * scale + wide / 2, (y - middle[1]) * scale + tall / 2];
    to.fillStyle = "#000";
    to.fillRect(...at(0, 0), pixels[0] * scale, pixels[1] * scale);
    const part = windowNow(), now = kept.get(keyOf(layer, part)), below = ghost ? kept.get(keyOf(layer - 1, part)) : null;
    if (now && (!shown || shown.now !== now || shown.below !== below)) shown = {now, below, sheet: paint(now, below)};
    to.imageSmoothingEnabled = false;
    if (shown) {
      const {x, y, step} = shown.now.part, [left, top] = at(x, y);
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
  function lookAt(place, closer) {
    middle = place.map((value, axis) => Math.max(0, Math.min(pixels[axis], value)));
    scale = Math.min(40, closer);
    near = true;
    draw();
  }
  function zoomBy(factor, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
    const next = Math.max(least(), Math.min(40, scale * factor)), from = [x - canvas.clientWidth / 2, y - canvas.clientHeight / 2];
    lookAt(middle.map((value, axis) => value + from[axis] / scale - from[axis] / next), next);
  }
  const moveBy = (by) => lookAt(middle.map((value, axis) => value - by[axis] / scale), scale);
  function tap(x, y) {
    const place = [x - canvas.clientWidth / 2, y - canvas.clientHeight / 2].map((by, axis) => middle[axis] + by / scale);
    if (place.every((value, axis) => value >= 0 && value < pixels[axis])) tapped(place);
  }
  const showAll = () => { near = false; draw(); };
  listenToGestures(canvas, {drag: moveBy, move: moveBy, zoom: zoomBy, tap});
  canvas.onkeydown = (event) => {
    const {by, factor, home} = keyGesture(event) || {};
    if (by) moveBy([-40 * by[0], 40 * by[1]]);
    else if (factor) zoomBy(factor * factor);
    else if (home) showAll();
    else return;
    event.preventDefault();
  };
  new ResizeObserver(draw).observe(canvas);

  return {
    // Another job's masks. Nothing of the one before stays, nor may what is on its way come in its place.
    begin(of) {
      kept.clear();
      asked = shown = missing = null;
      pixels = of;
      showAll();
    },
    show(n) {
      layer = n;
      missing = null;
      draw();
    },
    // Looks at a part of the panel, [first, end] across and along, unless somebody has looked closer.
    fit(box) {
      if (near || !canvas.clientWidth) return;
      const room = box.map(([first, end], axis) => [canvas.clientWidth, canvas.clientHeight][axis] / (1.2 * (end - first)));
      lookAt(box.map(([first, end]) => (first + end) / 2), Math.min(...room));
    },
    // Looks closely at a pixel.
    lookAt(x, y) { lookAt([x, y], Math.max(scale, 2)); },
    ghost(on) { ghost = on; draw(); },
    marks(list) { marks = list; draw(); },
    // What of the layer is in sight; null: it has not come yet.
    now() {
      const found = kept.get(keyOf(layer, windowNow()));
      return found ? {layer, scale, ...found.part, data: found.data.data} : null;
    },
  };
}
