// What mouse, touch and wheel do to a canvas, and drawing that waits for the next frame.
"use strict";

// @returns a function that has drawNow() called before the next frame, once
function onceAFrame(drawNow) {
  let waits = false;
  return () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      drawNow();
    });
  };
}

// @param drag  called with how far a finger or the mouse went, and the event
// @param move  the same of two fingers together
// @param zoom  called with a factor and the place that stays where it is
// @param tap   called with the place of a short touch
function listenToGestures(canvas, {drag, move, zoom, tap}) {
  const fingers = new Map();
  let way = 0;
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    way = 0;
  };
  canvas.onpointerup = canvas.onpointercancel = (event) => {
    fingers.delete(event.pointerId);
    if (tap && event.type === "pointerup" && way <= 6 && !fingers.size) tap(event.offsetX, event.offsetY);
  };
  canvas.onpointermove = (event) => {
    const from = fingers.get(event.pointerId);
    if (!from) return;
    const to = [event.offsetX, event.offsetY], by = [to[0] - from[0], to[1] - from[1]], other = [...fingers].find(([id]) => id !== event.pointerId);
    fingers.set(event.pointerId, to);
    way += Math.hypot(...by);
    if (!other) return drag(by, event);
    const apart = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]) || 1;
    zoom(apart(to) / apart(from), (to[0] + other[1][0]) / 2, (to[1] + other[1][1]) / 2);
    move(by.map((far) => far / 2));
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
  }, {passive: false});
}

// What a key asks for: {by: [x, y], 1 up and right} of an arrow, {factor} of plus and minus, {home: true}; null: nothing.
function keyGesture({key, ctrlKey, metaKey, altKey}) {
  if (ctrlKey || metaKey || altKey) return null;
  const by = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[key];
  if (by) return {by};
  if (key === "Home") return {home: true};
  const factor = {"+": 1.25, "=": 1.25, "-": 0.8}[key];
  return factor ? {factor} : null;
}
