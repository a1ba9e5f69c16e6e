// Checks of the viewer's functions, run by Node beside a copy of it.
import * as v from "./viewer.mjs";
import assert from "node:assert/strict";
const near = (a, b, off = 1e-6) => assert.ok(Math.abs(a - b) <= off, `${a} is not ${b}`);
const cam = v.camera([0, 1, 0], Math.PI, 0, 4, 600, 400);
const middle = v.project(cam, [0, 1, 0]);
near(middle.x, 300); near(middle.y, 200); near(middle.depth, 4);
// From behind a character that faces +z, its left (+x) is on the picture's left, and up is up.
assert.ok(v.project(cam, [1, 1, 0]).x < 300);
assert.ok(v.project(cam, [0, 2, 0]).y < 200);
assert.ok(v.project(cam, [0, 1, 3]).depth > 4);
assert.equal(v.project(cam, [0, 1, -5]), null);
// What lies under a pixel is where the ground point of that pixel is drawn.
const high = v.camera([3, 0.9, -2], 0.4, 0.5, 5, 640, 440);
const [x, z] = v.groundUnder(high, 200, 300), back = v.project(high, [x, 0, z]);
near(back.x, 200); near(back.y, 300);
assert.equal(v.groundUnder(v.camera([0, 1, 0], 0, 0, 4, 600, 400), 300, 10), null);
const shape = { capsules: [[0, 1, 0.1, 0], [1, 2, 0.1, 1], [0, 9, 0.1, 2]], layout: { positions: [0, 9], speed: [9, 10] } };
const order = v.sortedCapsules(cam, shape, [0, 1, 0, 0, 1, 1, 0, 1, 2, ...Array(18).fill(0), 0, 1, -9]);
assert.deepEqual(order.map((c) => c.side), [1, 0]);
assert.deepEqual(v.parts(shape, Float32Array.of(...Array(9).fill(2), 7)), { positions: Array(9).fill(2), speed: [7] });
const bytes = new Uint8Array(9); new DataView(bytes.buffer).setFloat32(1, 1.5, true); new DataView(bytes.buffer).setFloat32(5, -2, true);
assert.deepEqual([...v.numbersOf(new DataView(bytes.buffer, 1, 8))], [1.5, -2]);
const halves = Uint16Array.of(0x3c00, 0xc000, 0x3555, 0x0001, 0x7c00, 0x0000);
const frames = v.recordedFrames(new DataView(halves.buffer), 3);
assert.equal(frames.length, 2);
near(frames[0][0], 1); near(frames[0][1], -2); near(frames[0][2], 1 / 3, 1e-3); near(frames[1][0], 2 ** -24); assert.equal(frames[1][1], Infinity);
assert.deepEqual(v.recordedFrames(null, 3), []);
// A second of a screen of 60 or 144 Hz ends at the same frame of the recording, which begins anew after its last.
for (const hz of [30, 60, 144]) {
  const seen = Array.from({ length: hz }, (_, k) => v.recordedAt((1000 * k) / hz + 1e-6, 30, 20));
  assert.deepEqual([seen[0], new Set(seen).size, seen.at(-1)], [0, 20, 9]);
}
for (const [point, weights] of [[[0, 0], [1, 0, 0]], [[1, 0], [0, 1, 0]], [[0.5, Math.sqrt(3) / 2], [0, 0, 1]]])
  v.weightsAt(point).forEach((w, k) => near(w, weights[k]));
assert.equal(v.keyOf("KeyW"), "w"); assert.equal(v.keyOf("ShiftRight"), "shift"); assert.equal(v.keyOf("KeyX"), undefined);
// A page without a browser: a recording of ten frames, whose speeds are their numbers, plays by the clock until Stop.
const nodes = {}, said = [];
let clock = 0, next = null;
globalThis.performance = { now: () => clock };
globalThis.requestAnimationFrame = (then) => { next = then; };
globalThis.Option = class {};
globalThis.document = {
  visibilityState: "visible",
  createElement() {
    const heard = {}, node = { dataset: {}, classList: { toggle() {} }, appendChild() {}, add() {}, focus() {} };
    const pen = new Proxy({ canvas: node }, { get: (all, name) => (name in all ? all[name] : () => pen) });
    Object.assign(node, { getContext: () => pen, addEventListener: (name, f) => { heard[name] = f; }, click: () => heard.click() });
    return new Proxy(node, { set: (all, name, value) => { all[name] = value; if (name === "className") nodes[value] = node; return true; } });
  },
};
const layout = { positions: [0, 6], path: [6, 54], contacts: [54, 56], phases: [56, 64], speed: [64, 65] };
const numbers = Array.from({ length: 10 }, (_, k) => [...Array(64).fill(0), [0, 0x3c00, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600, 0x4700, 0x4800, 0x4880][k]]);
const model = {
  get: (name) => ({
    shape: { layout, capsules: [[0, 1, 0.1, 0]], head: { joint: 1, radius: 0.1 }, feet: [0, 1], limbs: [], speed: 1, point: [0, 0], recorded_fps: 10 },
    styles: ["Old"], chosen: ["Old", "Old", "Old"], problem: "", recording: new DataView(Uint16Array.from(numbers.flat()).buffer),
  })[name],
  send: ({ kind }) => said.push(kind), on() {}, off() {},
};
const leave = v.default.render({ model, el: document.createElement("div") });
const play = (ms, hz) => { for (const end = clock + ms; clock < end - 1e-9;) { clock += 1000 / hz; next(clock); } };
const now = () => Number(nodes["sp-value"].textContent.split("now ")[1]);
play(1650, 50);
const first = now();
play(500, 144);
assert.equal((now() - first + 10) % 10, 5);
nodes["sp-power"].click();
const stopped = now();
play(500, 50);
assert.equal(now(), stopped);
nodes["sp-power"].click();
play(200, 50);
assert.equal((now() - stopped + 10) % 10, 2);
leave();
assert.equal(said.at(-1), "stop");
console.log(JSON.stringify(v.COLOURS));
