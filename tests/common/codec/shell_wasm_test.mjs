// The WebAssembly decoder gives the same meshes as the C++ one for a folder's shells, and refuses the same bytes.
//
//   node shell_wasm_test.mjs shell.wasm folder    (tests/golden, or a folder that write_shells has filled)
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';

const [wasmFile, folder] = process.argv.slice(2);
const module = new WebAssembly.Module(readFileSync(wasmFile));
assert.deepEqual(WebAssembly.Module.imports(module), [], 'It needs nothing of its host');
const { memory, ...shell } = new WebAssembly.Instance(module).exports;

function decode(bytes) {
  const at = shell.shell_payload(bytes.length);
  new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
  const opened = shell.shell_open();
  if (opened !== 0) return opened;
  const decoded = shell.shell_decode();
  if (decoded !== 0) return decoded;
  return {
    vertices: new Int32Array(memory.buffer, shell.shell_vertices(), 3 * shell.shell_vertex_count()),
    triangles: new Uint32Array(memory.buffer, shell.shell_triangles(), 3 * shell.shell_triangle_count()),
  };
}

const compare = (a, b) => a.findIndex((v, i) => v !== b[i]);
const less = (a, b) => { const i = compare(a, b); return i >= 0 && a[i] < b[i]; };

// The same as in tests/support/golden_shells.hpp.
function checksum({ vertices, triangles }) {
  const point = (index) => [...vertices.subarray(3 * index, 3 * index + 3)];
  const all = [];
  for (let i = 0; i < triangles.length; i += 3) {
    const corners = [0, 1, 2].map((k) => point(triangles[i + k]));
    const turned = [0, 1, 2].map((k) => [...corners[k], ...corners[(k + 1) % 3], ...corners[(k + 2) % 3]]);
    all.push(turned.reduce((least, one) => (less(one, least) ? one : least)));
  }
  all.sort((a, b) => (less(a, b) ? -1 : less(b, a) ? 1 : 0));
  let sum = 2166136261;
  for (const triangle of all) {
    for (const v of triangle) sum = Math.imul(sum ^ v, 16777619);
  }
  return (sum >>> 0).toString(16);
}

for (let round = 0; round < 2; ++round) {  // The second round reuses memory.
  for (const line of readFileSync(`${folder}/shells.txt`, 'utf8').trim().split('\n')) {
    const name = line.split(' ')[0];
    const bytes = readFileSync(`${folder}/shell_${name}.bin`);
    const mesh = decode(bytes);
    const found = `${name} ${mesh.vertices.length / 3} ${mesh.triangles.length / 3} ${checksum(mesh)}`;
    assert.equal(found, line);
    console.log(found);
    assert.equal(decode(bytes.subarray(0, bytes.length - 5)), 3, 'Bytes are missing');
    assert.equal(decode(bytes.subarray(0, 8)), 2, 'The header ends');
    assert.equal(decode(Uint8Array.of(3, ...bytes.subarray(1))), 1, 'Another version');
  }
}
