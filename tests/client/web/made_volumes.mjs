// Volume files made from formulas, for tests and pictures.
import { writeFileSync } from "node:fs";

// `value(x, y, z)` is called with the indices of each sample.
export function samplesOf(size, value) {
  const samples = new Float32Array(size ** 3);
  for (let i = 0; i < samples.length; ++i) samples[i] = value(i % size, Math.floor(i / size) % size, Math.floor(i / size ** 2));
  return samples;
}

export const unitSpace = "space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n";

// Writes a Uint8Array, Uint16Array or Float32Array as NRRD; `space` holds further header lines.
export function writeNrrd(file, size, samples, space = "") {
  const type = { Uint8Array: "uint8", Uint16Array: "uint16" }[samples.constructor.name] ?? "float";
  const header = `NRRD0004\ntype: ${type}\ndimension: 3\n${space}sizes: ${size} ${size} ${size}\nendian: little\nencoding: raw\n\n`;
  writeFileSync(file, Buffer.concat([Buffer.from(header), Buffer.from(samples.buffer)]));
}

// Writes a VTK image with the given arrays, by name, as Base64 in XML.
export function writeVti(file, size, arrays) {
  const words = Object.entries(arrays).map(([name, samples]) => {
    const length = Buffer.alloc(4);
    length.writeUInt32LE(samples.byteLength);
    const data = Buffer.concat([length, Buffer.from(samples.buffer)]).toString("base64");
    return `<DataArray type="Float32" Name="${name}" format="binary">${data}</DataArray>`;
  });
  const extent = `0 ${size - 1} 0 ${size - 1} 0 ${size - 1}`;
  writeFileSync(file,
    `<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"><ImageData WholeExtent="${extent}" Origin="0 0 0" Spacing="1 1 1">` +
    `<Piece Extent="${extent}"><PointData>${words.join("")}</PointData></Piece></ImageData></VTKFile>`);
}
