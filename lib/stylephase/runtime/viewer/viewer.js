// The view of a played character: a plain 2D canvas, drawn back to front. Metres, y up, the character's left is +x.
// The functions above `render` are pure and tested by themselves.

export const COLOURS = {
  middle: "#B4BAC3", left: "#0072B2", right: "#D55E00", ink: "#222222", quiet: "#8A8F96",
  ground: "#C3CAD3", shadow: "#E1E4E9", path: "#C2185B",
  limbs: ["#56B4E9", "#F2B134", "#0072B2", "#D55E00"],
};
const KEYS = { KeyW: "w", KeyA: "a", KeyS: "s", KeyD: "d", KeyQ: "q", KeyE: "e", ShiftLeft: "shift", ShiftRight: "shift" };
const CORNERS = [[0, 0], [1, 0], [0.5, Math.sqrt(3) / 2]];
const NEAR = 0.2, FOCUS = 1.6, GRID = 9;
// What a recording is late by more than this, as in a hidden page, is left out.
const ALIVE_MS = 500, QUIET_MS = 1500, LATE_MS = 250;

/** Name of a key by its place on the keyboard, so that other layouts than English serve too; undefined for others. */
export const keyOf = (code) => KEYS[code];

/** A camera that looks from a direction (yaw, pitch in rad) and distance (m) at a place. */
export function camera(at, yaw, pitch, distance, width, height) {
  const toward = [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch)];
  const right = [Math.cos(yaw), 0, -Math.sin(yaw)];
  const up = [
    toward[1] * right[2] - toward[2] * right[1],
    toward[2] * right[0] - toward[0] * right[2],
    toward[0] * right[1] - toward[1] * right[0],
  ];
  const eye = at.map((v, k) => v + distance * toward[k]);
  return { eye, toward, right, up, scale: FOCUS * height / 2, width, height };
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Where a point appears: x and y in pixels, depth (m) from the eye, pixels per metre there; null behind the eye. */
export function project(cam, point) {
  const off = point.map((v, k) => v - cam.eye[k]);
  const depth = -dot(off, cam.toward);
  if (depth < NEAR) return null;
  const zoom = cam.scale / depth;
  return { x: cam.width / 2 + zoom * dot(off, cam.right), y: cam.height / 2 - zoom * dot(off, cam.up), depth, zoom };
}

/** The ground point (x, z) under a pixel; null above the horizon. */
export function groundUnder(cam, x, y) {
  const a = (x - cam.width / 2) / cam.scale, b = (cam.height / 2 - y) / cam.scale;
  const ray = cam.toward.map((v, k) => -v + a * cam.right[k] + b * cam.up[k]);
  if (ray[1] > -1e-3) return null;
  const far = -cam.eye[1] / ray[1];
  return [cam.eye[0] + far * ray[0], cam.eye[2] + far * ray[2]];
}

/** The capsules of a frame from the farthest to the nearest, each with its two ends as they appear. */
export function sortedCapsules(cam, shape, positions) {
  const joint = (k) => positions.slice(3 * k, 3 * k + 3);
  return shape.capsules
    .map(([a, b, radius, side]) => ({ a: project(cam, joint(a)), b: project(cam, joint(b)), radius, side }))
    .filter(({ a, b }) => a && b)
    .sort((one, other) => other.a.depth + other.b.depth - one.a.depth - one.b.depth);
}

/** Parts of a frame's numbers by name, as plain arrays. */
export function parts(shape, numbers) {
  return Object.fromEntries(Object.entries(shape.layout).map(([name, [a, b]]) => [name, Array.from(numbers.slice(a, b))]));
}

/** Float32 numbers from a message's buffer, which may begin anywhere. */
export function numbersOf(view) {
  return new Float32Array(view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
}

/** Frames of a recording, which is kept in half precision. */
export function recordedFrames(view, values) {
  if (!view || !view.byteLength) return [];
  const frames = [];
  for (let at = 0; at + 2 * values <= view.byteLength; at += 2 * values) {
    frames.push(Float32Array.from({ length: values }, (_, k) => half(view.getUint16(at + 2 * k, true))));
  }
  return frames;
}

/** Which frame of a recording is shown so many milliseconds after it began, over and over; any screen shows it as fast. */
export const recordedAt = (elapsed, fps, count) => Math.floor((Math.max(elapsed, 0) * fps) / 1000) % count;

/** A number of half precision from its bits. */
export function half(bits) {
  const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, fraction = bits & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -14 * (fraction / 1024));
}

/** Weights of the triangle's corners at a point; outside some are below zero, and the kernel takes the nearest point. */
export function weightsAt([x, y]) {
  const top = y / CORNERS[2][1];
  return [1 - x - top / 2, x - top / 2, top];
}

function make(tag, parent, name, text = "") {
  const node = document.createElement(tag);
  node.className = `sp-${name}`;
  node.textContent = text;
  parent.appendChild(node);
  return node;
}

function polygon(ctx, cam, ground, colour) {
  const seen = ground.map(([x, z]) => project(cam, [x, 0.004, z]));
  if (seen.some((p) => !p)) return;
  ctx.fillStyle = colour;
  ctx.beginPath();
  seen.forEach((p, k) => (k ? ctx.lineTo(p.x, p.y) : ctx.moveTo(p.x, p.y)));
  ctx.fill();
}

function line(ctx, a, b, width, colour) {
  if (!a || !b) return;
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.beginPath();
  ctx.moveTo(a.x, a.y);
  ctx.lineTo(b.x, b.y);
  ctx.stroke();
}

function drawGround(ctx, cam, [x0, , z0]) {
  const from = [Math.round(x0) - GRID, Math.round(z0) - GRID];
  for (let i = 0; i <= 2 * GRID; i++) {
    for (let j = 0; j < 2 * GRID; j++) {
      for (const [a, b] of [[[i, j], [i, j + 1]], [[j, i], [j + 1, i]]]) {
        const [p, q] = [a, b].map(([u, v]) => [from[0] + u, 0, from[1] + v]);
        const fade = 1 - Math.hypot((p[0] + q[0]) / 2 - x0, (p[2] + q[2]) / 2 - z0) / GRID;
        if (fade <= 0) continue;
        ctx.globalAlpha = fade;
        line(ctx, project(cam, p), project(cam, q), 1, COLOURS.ground);
      }
    }
  }
  ctx.globalAlpha = 1;
}

function drawPath(ctx, cam, path) {
  for (let k = 0; k < path.length / 4; k++) {
    const [x, z, dx, dz] = path.slice(4 * k, 4 * k + 4);
    const corner = (ahead, aside) => [x + 0.13 * (ahead * dx + aside * dz), z + 0.13 * (ahead * dz - aside * dx)];
    const colour = k < path.length / 8 ? COLOURS.quiet : COLOURS.ink;
    polygon(ctx, cam, [corner(0.5, 0), corner(-0.5, -0.35), corner(-0.5, 0.35)], colour);
  }
}

function drawContacts(ctx, cam, shape, frame) {
  frame.contacts.forEach((contact, k) => {
    if (contact < 0.5) return;
    const [x, , z] = frame.positions.slice(3 * shape.feet[k], 3 * shape.feet[k] + 3);
    const round = Array.from({ length: 20 }, (_, n) => [x + 0.16 * Math.cos(n * 0.314), z + 0.16 * Math.sin(n * 0.314)]);
    ctx.globalAlpha = 0.45;
    polygon(ctx, cam, round, k ? COLOURS.left : COLOURS.right);
    ctx.globalAlpha = 1;
  });
}

function drawBody(ctx, cam, shape, positions) {
  const flat = positions.map((v, k) => (k % 3 === 1 ? 0.002 : v));
  for (const { a, b, radius } of sortedCapsules(cam, shape, flat)) line(ctx, a, b, 1.6 * radius * a.zoom, COLOURS.shadow);
  const { joint, radius } = shape.head;
  const neck = shape.capsules.find(([, child]) => child === joint);
  const at = (k) => positions.slice(3 * k, 3 * k + 3);
  const up = neck ? at(joint).map((v, k) => v - at(neck[0])[k]) : [0, 1, 0];
  const length = Math.hypot(...up) || 1;
  const skull = project(cam, at(joint).map((v, k) => v + (0.9 * radius * up[k]) / length));
  const drawn = sortedCapsules(cam, shape, positions);
  if (skull) drawn.push({ a: skull, b: { ...skull, x: skull.x + 0.01 }, radius, side: 0 });
  drawn.sort((one, other) => other.a.depth + other.b.depth - one.a.depth - one.b.depth);
  for (const { a, b, radius: r, side } of drawn) {
    const colour = [COLOURS.middle, COLOURS.left, COLOURS.right][side], width = r * (a.zoom + b.zoom);
    line(ctx, a, b, width, "#00000055");
    line(ctx, a, b, Math.max(1, width - 3), colour);
    ctx.save();
    ctx.translate(-width / 7, -width / 7);
    line(ctx, a, b, width / 5, "#FFFFFF55");
    ctx.restore();
  }
}

function drawDials(ctx, shape, phases, most) {
  const size = ctx.canvas.width / 4;
  ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
  ctx.textAlign = "center";
  ctx.font = "10px sans-serif";
  shape.limbs.forEach((name, k) => {
    const [sine, cosine] = phases.slice(2 * k, 2 * k + 2), middle = { x: size * (k + 0.5), y: size * 0.5 };
    const reach = (0.42 * size) / Math.max(most, 1e-6);
    ctx.strokeStyle = COLOURS.ground;
    ctx.lineWidth = 1;
    ctx.beginPath();
    ctx.arc(middle.x, middle.y, 0.42 * size, 0, 2 * Math.PI);
    ctx.stroke();
    line(ctx, middle, { x: middle.x + reach * sine, y: middle.y - reach * cosine }, 3, COLOURS.limbs[k]);
    ctx.fillStyle = COLOURS.ink;
    ctx.fillText(name, middle.x, size * 1.12);
  });
}

const PAD = 12;
const trianglePixel = (ctx, [x, y]) => ({ x: PAD + x * (ctx.canvas.width - 2 * PAD), y: ctx.canvas.height - PAD - y * (ctx.canvas.width - 2 * PAD) });

function drawTriangle(ctx, point) {
  ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
  const corners = CORNERS.map((c) => trianglePixel(ctx, c));
  corners.forEach((c, k) => line(ctx, c, corners[(k + 1) % 3], 2, COLOURS.quiet));
  const here = trianglePixel(ctx, point);
  ctx.fillStyle = COLOURS.path;
  ctx.beginPath();
  ctx.arc(here.x, here.y, 6, 0, 2 * Math.PI);
  ctx.fill();
}

function render({ model, el }) {
  const shape = model.get("shape"), values = Math.max(...Object.values(shape.layout).map(([, end]) => end));
  const say = (kind, value = null) => model.send({ kind, value });
  const root = make("div", el, "viewer");
  root.tabIndex = 0;
  root.dataset.lmSuppressShortcuts = "true";
  const canvas = make("canvas", root, "stage"), side = make("div", root, "side");
  Object.assign(canvas, { width: 560, height: 420 });
  const buttons = make("div", side, "row");
  const power = make("button", buttons, "power", "Stop"), draw = make("button", buttons, "draw", "Draw a path");
  const again = make("button", buttons, "reset", "Reset");
  const triangle = make("canvas", side, "triangle");
  Object.assign(triangle, { width: 180, height: 164 });
  const corners = ["left", "right", "top"].map((name) => {
    const row = make("label", side, "row", name), select = make("select", row, "style");
    model.get("styles").forEach((style) => select.add(new Option(style, style)));
    return select;
  });
  const pace = make("label", side, "row", "speed"), slider = make("input", pace, "speed"), shown = make("span", pace, "value");
  Object.assign(slider, { type: "range", min: 0, max: 3, step: 0.05 });
  slider.value = shape.speed;
  const dials = make("canvas", side, "dials");
  Object.assign(dials, { width: 260, height: 78 });
  const status = make("div", side, "status");
  make("div", side, "help", "Click the picture, then: W A S D move, Q E turn, Shift runs. Drag to look around, wheel to zoom.");

  const view = { yaw: Math.PI + 0.5, pitch: 0.28, distance: 3.2, at: [0, 0.9, 0] };
  const held = new Set();
  let frame = null, fresh = false, on = true, last = 0, point = shape.point, most = 0;
  let drawing = false, stroke = null, recorded = null, played = 0, before = 0, alive = true;

  const cam = () => camera(view.at, view.yaw, view.pitch, view.distance, canvas.width, canvas.height);
  const take = (numbers) => {
    frame = parts(shape, numbers);
    most = Math.max(0.995 * most, ...[0, 2, 4, 6].map((k) => Math.hypot(frame.phases[k], frame.phases[k + 1])));
    fresh = true;
  };
  const follow = () => {
    const root = 4 * 6, [x, z, dx, dz] = frame.path.slice(root, root + 4);
    view.at = [view.at[0] + 0.2 * (x - view.at[0]), 0.9, view.at[2] + 0.2 * (z - view.at[2])];
    if (!stroke && held.size) {
      const off = Math.atan2(dx, dz) + Math.PI + 0.5 - view.yaw;
      view.yaw += 0.015 * Math.atan2(Math.sin(off), Math.cos(off));
    }
  };
  const paint = () => {
    const ctx = canvas.getContext("2d"), seen = cam();
    ctx.lineCap = "round";
    ctx.fillStyle = "#FFFFFF";
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    drawGround(ctx, seen, view.at);
    if (stroke) stroke.forEach((p, k) => k && line(ctx, project(seen, [stroke[k - 1][0], 0, stroke[k - 1][1]]), project(seen, [p[0], 0, p[1]]), 3, COLOURS.path));
    drawPath(ctx, seen, frame.path);
    drawContacts(ctx, seen, shape, frame);
    drawBody(ctx, seen, shape, frame.positions);
    drawDials(dials.getContext("2d"), shape, frame.phases, most);
    shown.textContent = `${Number(slider.value).toFixed(2)} m/s, now ${frame.speed[0].toFixed(2)}`;
  };
  const loop = (now) => {
    if (!alive) return;
    if (on && performance.now() - last > QUIET_MS && recorded === null) {
      recorded = recordedFrames(model.get("recording"), values);
      status.textContent = model.get("problem") || `${recorded.length ? "A recording: no" : "No"} kernel answers, or it is busy.`;
    }
    if (on && recorded?.length) {
      played += Math.min(now - before, LATE_MS);
      take(recorded[recordedAt(played, shape.recorded_fps, recorded.length)]);
    }
    before = now;
    if (frame && fresh) {
      follow();
      paint();
      fresh = false;
    }
    requestAnimationFrame(loop);
  };
  const beat = () => { if (on && document.visibilityState === "visible") say("alive"); };
  const heard = (message, buffers) => {
    if (message.kind !== "frame") return;
    last = performance.now();
    recorded = null;
    status.textContent = model.get("problem") || "";
    take(numbersOf(buffers[0]));
  };
  const keys = (event, down) => {
    const key = keyOf(event.code);
    if (!key || event.target.tagName === "SELECT") return;
    event.preventDefault();
    event.stopPropagation();
    if (down === held.has(key)) return;
    if (down) held.add(key); else held.delete(key);
    say("keys", [...held]);
  };
  const lift = () => { if (held.size) { held.clear(); say("keys", []); } };
  const place = (event, node) => [(event.offsetX * node.width) / node.clientWidth, (event.offsetY * node.height) / node.clientHeight];
  const mix = (event) => {
    if (!(event.buttons & 1)) return;
    const [x, y] = place(event, triangle), size = triangle.width - 2 * PAD;
    const wished = [(x - PAD) / size, (triangle.height - PAD - y) / size], w = weightsAt(wished).map((v) => Math.max(v, 0));
    const whole = w[0] + w[1] + w[2];
    point = [0, 1].map((axis) => CORNERS.reduce((sum, c, k) => sum + (w[k] / whole) * c[axis], 0));
    drawTriangle(triangle.getContext("2d"), point);
    say("mix", point);
  };

  root.addEventListener("keydown", (event) => keys(event, true));
  root.addEventListener("keyup", (event) => keys(event, false));
  root.addEventListener("blur", lift);
  canvas.addEventListener("pointerdown", (event) => {
    root.focus();
    canvas.setPointerCapture(event.pointerId);
    if (drawing) stroke = [];
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!(event.buttons & 1)) return;
    if (stroke) {
      const ground = groundUnder(cam(), ...place(event, canvas)), before = stroke.at(-1);
      if (ground && (!before || Math.hypot(ground[0] - before[0], ground[1] - before[1]) > 0.1)) stroke.push(ground);
    } else {
      view.yaw -= 0.008 * event.movementX;
      view.pitch = Math.min(1.4, Math.max(0.03, view.pitch + 0.006 * event.movementY));
    }
    fresh = true;
  });
  canvas.addEventListener("pointerup", () => {
    if (stroke) say("path", stroke);
    stroke = null;
    drawing = false;
    draw.classList.remove("sp-on");
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.distance = Math.min(15, Math.max(1.5, view.distance * Math.exp(0.001 * event.deltaY)));
    fresh = true;
  }, { passive: false });
  triangle.addEventListener("pointerdown", (event) => { triangle.setPointerCapture(event.pointerId); mix(event); });
  triangle.addEventListener("pointermove", mix);
  slider.addEventListener("input", () => say("speed", Number(slider.value)));
  corners.forEach((select) => select.addEventListener("change", () => say("styles", corners.map((c) => c.value))));
  again.addEventListener("click", () => { say("reset"); root.focus(); });
  draw.addEventListener("click", () => { drawing = !drawing; draw.classList.toggle("sp-on", drawing); });
  power.addEventListener("click", () => {
    on = !on;
    power.textContent = on ? "Stop" : "Start";
    if (on) beat(); else say("stop");
    root.focus();
  });
  const chosen = () => corners.forEach((select, k) => { select.value = model.get("chosen")[k]; });
  // What was refused is not chosen either.
  const problem = () => {
    status.textContent = model.get("problem");
    if (model.get("problem")) chosen();
  };
  model.on("msg:custom", heard);
  model.on("change:chosen", chosen);
  model.on("change:problem", problem);
  chosen();
  drawTriangle(triangle.getContext("2d"), point);
  last = performance.now();
  beat();
  const timer = setInterval(beat, ALIVE_MS);
  requestAnimationFrame(loop);
  return () => {
    alive = false;
    clearInterval(timer);
    lift();
    say("stop");
    model.off("msg:custom", heard);
    model.off("change:chosen", chosen);
    model.off("change:problem", problem);
  };
}

export default { render };
