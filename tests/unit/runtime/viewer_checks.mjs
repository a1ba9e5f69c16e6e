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
for (const [point, weights] of [[[0, 0], [1, 0, 0]], [[1, 0], [0, 1, 0]], [[0.5, Math.sqrt(3) / 2], [0, 0, 1]]])
  v.weightsAt(point).forEach((w, k) => near(w, weights[k]));
assert.equal(v.keyOf("KeyW"), "w"); assert.equal(v.keyOf("ShiftRight"), "shift"); assert.equal(v.keyOf("KeyX"), undefined);
assert.equal(typeof v.default.render, "function");
console.log(JSON.stringify(v.COLOURS));
