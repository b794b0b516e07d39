// The part in 3D: WebGL 2, without a library. The printer sends the print as cells, each a share of its volume (firmware/pictures/part_model.hpp);
// here they become a surface by surface nets: a vertex in each cube of eight cells that it passes, a quad across each edge.
"use strict";

const fullCell = 63;

// The cells with a border of empty ones, so that no neighbour needs a check. What the surface rests on is in their upper two bits.
function decodeModel(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const [nx, ny, nz, flags] = [4, 6, 8, 10].map((at) => view.getUint16(at, true));
  const numbers = [12, 16, 20, 24, 28, 32].map((at) => view.getFloat32(at, true));
  if (view.getUint32(0, true) !== 0x314d4c50 || !nx || !ny || !nz || Math.max(nx, ny, nz) > 256) throw new Error("no model");
  const dx = nx + 2, dy = ny + 2, layer = dx * dy, size = layer * (nz + 2);
  const object = new Uint8Array(size), supports = flags & 1 ? new Uint8Array(size) : null;
  let at = 36, count = 0, value = 0;
  const byte = () => {
    if (at >= bytes.length) throw new Error("the model is cut");
    return bytes[at++];
  };
  const readLayer = (cells, z) => {
    for (let y = 1; y <= ny; ++y) {
      for (let x = 1, to = (z * dy + y) * dx + 1; x <= nx; ++x, ++to) {
        if (count === 0) {
          const token = byte();
          value = token < 0x40 ? token : token < 0x80 || (token >= 0xc0 && token < 0xe0) ? 0 : fullCell;
          count = token < 0x40 ? 1 : token < 0xc0 ? (token & 0x3f) + 1 : ((token & 0x1f) << 8 | byte()) + 1;
        }
        --count;
        cells[to] = value;
      }
    }
  };
  const readEvidence = (z) => {
    let left = 0, evidence = 0;
    const share = (i) => object[i] & fullCell;
    for (let y = 1; y <= ny; ++y) {
      for (let x = 1, i = (z * dy + y) * dx + 1; x <= nx; ++x, ++i) {
        if (share(i) === 0 || (share(i) === fullCell && [1, -1, dx, -dx, layer, -layer].every((step) => share(i + step) === fullCell))) continue;
        if (left === 0) {
          const token = byte();
          evidence = token >> 6;
          left = (token & 0x3f) + 1;
        }
        --left;
        object[i] |= evidence << 6;
      }
    }
  };
  for (let z = 1; z <= nz + 1; ++z) {
    if (z <= nz) readLayer(object, z);
    if (z <= nz && supports) readLayer(supports, z);
    if (z > 1 && flags & 2) readEvidence(z - 1);
  }
  return {dims: [dx, dy, nz + 2], low: numbers.slice(0, 3), cell: numbers.slice(3), object, supports, evidence: Boolean(flags & 2)};
}

// Cells of twice the size, for a view that moves on a slow device.
function coarser({dims, low, cell}, cells) {
  const of = dims.map((side) => Math.ceil((side - 2) / 2) + 2), out = new Uint8Array(of[0] * of[1] * of[2]), sums = new Uint16Array(out.length);
  for (let z = 1; z < dims[2] - 1; ++z) {
    for (let y = 1; y < dims[1] - 1; ++y) {
      const to = ((z + 1 >> 1) * of[1] + (y + 1 >> 1)) * of[0];
      for (let x = 1, from = (z * dims[1] + y) * dims[0] + 1; x < dims[0] - 1; ++x, ++from) {
        sums[to + (x + 1 >> 1)] += cells[from] & fullCell;
        out[to + (x + 1 >> 1)] = Math.max(out[to + (x + 1 >> 1)], cells[from] & ~fullCell);  // the worst that any of it rests on
      }
    }
  }
  for (let i = 0; i < out.length; ++i) out[i] |= sums[i] >> 3;
  return [{dims: of, low, cell: cell.map((side) => 2 * side)}, out];
}

class Growing {
  constructor(Type, room) {
    this.data = new Type(room);
    this.size = 0;
  }
  reserve(more) {
    if (this.size + more <= this.data.length) return;
    const larger = new this.data.constructor(2 * this.data.length + more);
    larger.set(this.data);
    this.data = larger;
  }
}

// Places in mm, and with each a normal of three bytes and what it rests on; triangles of three indices, counterclockwise from outside. Gives way to
// the page now and then.
async function surfaceOf(model, cells, level) {
  const [dx, dy, dz] = model.dims;
  const places = new Growing(Float32Array, 1 << 18), rests = new Growing(Uint8Array, 1 << 16), corners = new Growing(Uint32Array, 1 << 19);
  const steps = [0, 1, dx, dx + 1, dx * dy, dx * dy + 1, dx * dy + dx, dx * dy + dx + 1];
  let below = new Int32Array(dx * dy), here = new Int32Array(dx * dy), vertices = 0, pausedAt = performance.now();
  const v = new Float32Array(8);
  const quad = (a, b, c, d, flip) => {
    corners.reserve(6);
    corners.data.set(flip ? [a, c, b, b, c, d] : [a, b, c, b, d, c], corners.size);
    corners.size += 6;
  };
  for (let z = 0; z + 1 < dz; ++z) {
    if (performance.now() - pausedAt > 12) {
      await new Promise((go) => setTimeout(go));
      pausedAt = performance.now();
    }
    for (let y = 0; y + 1 < dy; ++y) {
      const row = (z * dy + y) * dx;
      const bits = (x) => {
        const i = row + x;
        return ((cells[i] & fullCell) > level ? 1 : 0) | ((cells[i + dx] & fullCell) > level ? 4 : 0) |
               ((cells[i + steps[4]] & fullCell) > level ? 16 : 0) | ((cells[i + steps[6]] & fullCell) > level ? 64 : 0);
      };
      let right = bits(0);
      for (let x = 0; x + 1 < dx; ++x) {
        const left = right;
        right = bits(x + 1);
        const inside = left | right << 1;
        if (inside === 0 || inside === 255) continue;
        let worst = 0;
        for (let k = 0; k < 8; ++k) {
          const one = cells[row + x + steps[k]];
          v[k] = one & fullCell;
          worst = Math.max(worst, one >> 6);
        }
        let sx = 0, sy = 0, sz = 0, cut = 0;
        for (let k = 0; k < 8; ++k) {
          for (let axis = 1; axis < 8; axis <<= 1) {
            if (k & axis || !((inside >> k ^ inside >> (k | axis)) & 1)) continue;
            const t = (level + 0.5 - v[k]) / (v[k | axis] - v[k]);
            sx += (k & 1) + (axis === 1 ? t : 0);
            sy += (k >> 1 & 1) + (axis === 2 ? t : 0);
            sz += (k >> 2 & 1) + (axis === 4 ? t : 0);
            ++cut;
          }
        }
        places.reserve(3);
        rests.reserve(1);
        // Shares stand for the middles of cells, and the border is one cell wide.
        places.data[places.size++] = x - 0.5 + sx / cut;
        places.data[places.size++] = y - 0.5 + sy / cut;
        places.data[places.size++] = z - 0.5 + sz / cut;
        rests.data[rests.size++] = worst;
        const at = y * dx + x;
        here[at] = vertices++;
        const solid = inside & 1;
        if (solid !== (inside >> 1 & 1)) quad(below[at - dx], below[at], here[at - dx], here[at], !solid);
        if (solid !== (inside >> 2 & 1)) quad(below[at - 1], here[at - 1], below[at], here[at], !solid);
        if (solid !== (inside >> 4 & 1)) quad(here[at - dx - 1], here[at - dx], here[at - 1], here[at], !solid);
      }
    }
    [below, here] = [here, below];
  }
  return smoothed(model, places.data.subarray(0, places.size), rests.data, corners.data.subarray(0, corners.size));
}

// Cells of single pixels are full or empty, which makes stairs of slopes. Each vertex moves to the middle of its neighbours, by half a cell at
// most. Then places become mm, and normals those of the triangles around.
function smoothed({low, cell}, places, rests, corners) {
  const count = places.length / 3, sums = new Float32Array(places.length), degree = new Uint16Array(count), was = places.slice();
  for (let pass = 0; pass < 4; ++pass) {
    sums.fill(0);
    degree.fill(0);
    for (let i = 0; i < corners.length; i += 3) {
      for (let k = 0; k < 3; ++k) {
        const to = corners[i + k], from = corners[i + (k + 1) % 3];
        ++degree[to];
        for (let axis = 0; axis < 3; ++axis) sums[3 * to + axis] += places[3 * from + axis];
      }
    }
    for (let i = 0; i < places.length; ++i) {
      const d = degree[i / 3 | 0];
      if (d) places[i] = Math.max(was[i] - 0.5, Math.min(was[i] + 0.5, (places[i] + sums[i] / d) / 2));
    }
  }
  for (let i = 0; i < places.length; ++i) places[i] = low[i % 3] + places[i] * cell[i % 3];
  sums.fill(0);
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = [3 * corners[i], 3 * corners[i + 1], 3 * corners[i + 2]];
    const [ux, uy, uz] = [places[b] - places[a], places[b + 1] - places[a + 1], places[b + 2] - places[a + 2]];
    const [vx, vy, vz] = [places[c] - places[a], places[c + 1] - places[a + 1], places[c + 2] - places[a + 2]];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const at of [a, b, c]) {
      sums[at] += x;
      sums[at + 1] += y;
      sums[at + 2] += z;
    }
  }
  const normals = new Int8Array(4 * count);
  for (let i = 0; i < count; ++i) {
    const long = 127 / (Math.hypot(sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]) || 1);
    for (let axis = 0; axis < 3; ++axis) normals[4 * i + axis] = sums[3 * i + axis] * long;
    normals[4 * i + 3] = rests[i];
  }
  return {places, normals, corners};
}

const partShaders = [`#version 300 es
in vec3 place; in vec4 normal;
uniform mat3 turn; uniform vec3 middle; uniform vec2 scale, pan; uniform float deep;
out vec3 at, facing; flat out float rests;
void main() {
  vec3 p = turn * (place - middle);
  at = place; facing = turn * normal.xyz; rests = normal.w * 127.0;
  gl_Position = vec4(p.xy * scale + pan, -p.z * deep, 1);
}`, `#version 300 es
precision mediump float;
in highp vec3 at; in vec3 facing; flat in float rests;
uniform highp float top; uniform vec4 colour; uniform bool shows;
out vec4 seen;
void main() {
  if (at.z > top) discard;
  vec3 n = normalize(facing + vec3(0, 0, 1e-4));
  vec3 c = shows && rests > 1.5 ? vec3(.29, .54, .91) : shows && rests > .5 ? vec3(.91, .31, .22) : colour.rgb;
  float light = .28 + .55 * max(dot(n, normalize(vec3(-.4, .6, .7))), 0.) + .22 * max(dot(n, normalize(vec3(.7, .1, .5))), 0.);
  seen = colour.a < 1. ? colour : vec4(gl_FrontFacing ? c * light : c * .35, 1);
}`];

// @param canvas  where it is drawn; takes mouse, touch and keys
// @param say     called with a text while the model comes, and with "" when it is there
function makePartView(canvas, say) {
  const gl = canvas.getContext("webgl2", {antialias: true});
  if (!gl) return null;
  let meshes = [], model = null, wanted = null, plane = null, withSupports = true, colours = false, spots = [];
  let yaw, pitch, zoom, pan;
  const program = gl.createProgram(), place = {};
  for (const [i, type] of [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].entries()) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, partShaders[i]);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.bindAttribLocation(program, 0, "place");
  gl.bindAttribLocation(program, 1, "normal");
  gl.linkProgram(program);
  gl.useProgram(program);
  for (const name of ["turn", "middle", "scale", "pan", "deep", "top", "colour", "shows"]) place[name] = gl.getUniformLocation(program, name);
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);

  const draw = onceAFrame(drawNow);
  const look = (toYaw, toPitch) => { [yaw, pitch] = [toYaw, toPitch]; draw(); };
  const reset = () => { zoom = 1; pan = [0, 0]; look(0.5, 0.35); };
  function meshOf({places, normals, corners}) {
    const array = gl.createVertexArray(), buffers = [], buffer = (target, data) => {
      buffers.push(gl.createBuffer());
      gl.bindBuffer(target, buffers.at(-1));
      gl.bufferData(target, data, gl.STATIC_DRAW);
    };
    gl.bindVertexArray(array);
    buffer(gl.ARRAY_BUFFER, places);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    buffer(gl.ARRAY_BUFFER, normals);
    gl.vertexAttribPointer(1, 4, gl.BYTE, true, 0, 0);
    buffer(gl.ELEMENT_ARRAY_BUFFER, corners);
    gl.enableVertexAttribArray(0);
    gl.enableVertexAttribArray(1);
    return {array, buffers, count: corners.length};
  }
  // A sheet at the height of the layer that is looked at.
  function sheet() {
    const [x, y] = model.low, [far, deep] = [0, 1].map((axis) => model.low[axis] + (model.dims[axis] - 2) * model.cell[axis]);
    return new Float32Array([x, y, plane, far, y, plane, x, deep, plane, far, deep, plane]);
  }
  const axes = () => {
    const [c, s, ce, se] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return [[c, s, 0], [-s * se, c * se, ce], [s * ce, -c * ce, se]];  // right, up, towards the viewer
  };
  const middle = () => [0, 1, 2].map((axis) => model.low[axis] + (model.dims[axis] - 2) * model.cell[axis] / 2);
  const radius = () => Math.hypot(...[0, 1, 2].map((axis) => (model.dims[axis] - 2) * model.cell[axis])) / 2;
  // Pixels of the canvas. However it is turned, the part fits in when it is seen from beside; from above it does if it is higher than deep.
  const perMm = () => {
    const [wide, deep, tall] = model.cell.map((side, axis) => side * (model.dims[axis] - 2)), across = Math.hypot(wide, deep);
    return zoom * Math.min(canvas.width / across, canvas.height / Math.max(0.94 * tall + 0.34 * across, deep)) / 1.06;
  };
  function drawNow() {
    const rough = performance.now() < movesUntil && slow, ratio = Math.min(window.devicePixelRatio || 1, 2) * (rough ? 0.5 : 1);
    const [wide, tall] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== wide || canvas.height !== tall) Object.assign(canvas, {width: wide, height: tall});
    gl.viewport(0, 0, wide, tall);
    gl.clearColor(0.08, 0.1, 0.13, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!model) return;
    const [right, up, toward] = axes(), scale = perMm();
    gl.uniformMatrix3fv(place.turn, true, [...right, ...up, ...toward]);
    gl.uniform3fv(place.middle, middle());
    gl.uniform2f(place.scale, 2 * scale / wide, 2 * scale / tall);
    gl.uniform2f(place.pan, 2 * pan[0] * ratio / wide, -2 * pan[1] * ratio / tall);
    gl.uniform1f(place.deep, 0.95 / (radius() * Math.max(1, zoom)));
    gl.uniform1f(place.top, plane === null ? 1e9 : plane);
    for (const {array, count, colour, supports, coarse} of meshes) {
      if ((supports && !withSupports) || coarse !== rough) continue;
      gl.bindVertexArray(array);
      gl.uniform4fv(place.colour, colour);
      gl.uniform1i(place.shows, colours && !supports ? 1 : 0);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    }
    if (plane !== null) {
      gl.bindVertexArray(null);
      gl.bindBuffer(gl.ARRAY_BUFFER, sheetBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, sheet(), gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      gl.disableVertexAttribArray(1);
      gl.enable(gl.BLEND);
      gl.uniform1f(place.top, 1e9);
      gl.uniform4f(place.colour, 0.5, 0.76, 1, 0.22);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
      gl.disable(gl.BLEND);
    }
    for (const {node, at} of spots) {
      const [x, y] = placeOf(at);
      Object.assign(node.style, {left: `${x}px`, top: `${y}px`});
      node.hidden = plane !== null && at[2] > plane + 1e-6;
    }
    ++view.frames;
    if (rough) setTimeout(draw, movesUntil - performance.now() + 20);
  }
  // Where a place of the part is on the canvas, CSS pixels.
  function placeOf(mm) {
    const [right, up] = axes(), p = mm.map((value, axis) => value - middle()[axis]), scale = perMm() * canvas.clientWidth / canvas.width;
    const along = (axis) => axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    return [canvas.clientWidth / 2 + along(right) * scale + pan[0], canvas.clientHeight / 2 - along(up) * scale + pan[1]];
  }
  // A device that needs longer than 1/30 s for a frame gets larger cells while the view moves.
  let movesUntil = 0, slow = false, drawnAt = 0;
  function moved() {
    const now = performance.now();
    if (now < movesUntil && now - drawnAt > 34) slow = true;
    [drawnAt, movesUntil] = [now, now + 600];
  }
  const sheetBuffer = gl.createBuffer();

  function clear() {
    for (const {array, buffers} of meshes) {
      gl.deleteVertexArray(array);
      buffers.forEach((buffer) => gl.deleteBuffer(buffer));
    }
    meshes = [];
    model = null;
    draw();
  }
  async function load(url) {
    const reply = await fetch(url);
    if (!reply.ok) throw new Error(`status ${reply.status}`);
    const size = Number(reply.headers.get("Content-Length")), bytes = new Uint8Array(size), reader = reply.body.getReader();
    for (let at = 0; ;) {
      const {done, value} = await reader.read();
      if (done) break;
      bytes.set(value, at);
      at += value.length;
      say(`${Math.round(100 * at / size)} %`);
    }
    const next = decodeModel(bytes), surfaces = [];
    for (const [cells, level, colour] of [[next.object, 31, [.87, .87, .83, 1]], ...next.supports ? [[next.supports, 12, [.93, .68, .36, 1]]] : []]) {
      const of = {colour, supports: cells === next.supports};
      surfaces.push({...of, coarse: false, surface: await surfaceOf(next, cells, level)});
      surfaces.push({...of, coarse: true, surface: await surfaceOf(...coarser(next, cells), level)});
    }
    if (wanted !== url) return;
    clear();
    meshes = surfaces.map(({surface, ...of}) => ({...of, ...meshOf(surface)}));
    view.hasSupports = Boolean(next.supports);
    view.hasEvidence = next.evidence;
    view.box = [0, 1].map((axis) => [next.low[axis], next.low[axis] + (next.dims[axis] - 2) * next.cell[axis]]);  // x and y, mm
    next.object = next.supports = null;
    model = next;
    say("");
    reset();
  }

  const turnBy = (byYaw, byPitch) => moved() || look(yaw + byYaw, Math.max(-Math.PI / 2, Math.min(Math.PI / 2, pitch + byPitch)));
  function zoomBy(factor, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
    const next = Math.max(0.5, Math.min(40, zoom * factor)), by = next / zoom;
    const from = [x - canvas.clientWidth / 2, y - canvas.clientHeight / 2];
    pan = [0, 1].map((axis) => from[axis] - by * (from[axis] - pan[axis]));
    zoom = next;
    moved();
    draw();
  }
  function panBy(by) {
    pan = [pan[0] + by[0], pan[1] + by[1]];
    moved();
    draw();
  }
  const drag = (by, event) => event.buttons > 1 || event.shiftKey ? panBy(by) : turnBy(-by[0] * 0.01, by[1] * 0.01);
  listenToGestures(canvas, {drag, move: panBy, zoom: zoomBy});
  canvas.oncontextmenu = (event) => event.preventDefault();
  canvas.ondblclick = reset;
  canvas.onkeydown = (event) => {
    const {by, factor, home} = keyGesture(event) || {};
    if (by && event.shiftKey) panBy([30 * by[0], -30 * by[1]]);
    else if (by) turnBy(-by[0] * Math.PI / 24, by[1] * Math.PI / 24);
    else if (factor) zoomBy(factor);
    else if (home) reset();
    else return;
    event.preventDefault();
  };
  canvas.addEventListener("webglcontextrestored", () => location.reload());
  new ResizeObserver(draw).observe(canvas);
  reset();

  const view = {
    frames: 0, box: null, hasSupports: false, hasEvidence: false, look, reset, turnBy, placeOf,
    show(url) {
      if (url === wanted) return;
      wanted = url;
      clear();
      if (url) load(url).catch(() => { if (url === wanted) say(null); });
    },
    plane(mm) {
      if (mm === plane) return;
      moved();
      plane = mm;
      draw();
    },
    supports(shown) { withSupports = shown; draw(); },
    colours(shown) { colours = shown; draw(); },
    // Buttons over the canvas at places, mm: [{at: [x, y, z], node}]
    marks(list) { spots = list; draw(); },
  };
  return view;
}
