// Reads the counts that a tile's Draco bytes state, without decoding: the start of the only kind of
// bitstream that a server may send (edgebreaker 2.2, one connectivity).

export interface PayloadCounts {
  triangles: number;
  vertices: number; // Draco's vertices; split ones count several times.
}

const header = [0x44, 0x52, 0x41, 0x43, 0x4f, 2, 2, 1, 1, 0, 0]; // "DRACO", 2.2, edgebreaker.
const standardTraversal = 0;
const valenceTraversal = 2;

// Returns the counts, or what was expected instead.
export function payloadCounts(payload: Uint8Array): PayloadCounts | string {
  const expected = (what: string) => `the payload is not a tile's Draco mesh: expected ${what}`;
  if (header.some((byte, i) => payload[i] !== byte)) return expected("an edgebreaker mesh 2.2");
  let at = header.length;
  const traversal = payload[at++];
  if (traversal !== standardTraversal && traversal !== valenceTraversal) {
    return expected("the standard or the valence traversal");
  }
  const varint = () => {
    let value = 0;
    for (let factor = 1; factor <= 2 ** 28 && at < payload.length; factor *= 128) {
      const byte = payload[at++];
      value += (byte & 0x7f) * factor;
      if (byte < 0x80) return value;
    }
    return NaN;
  };
  const vertices = varint();
  const triangles = varint();
  if (payload[at++] !== 0) return expected("no attribute with its own connectivity");
  const symbols = varint();
  const splits = varint();
  if (!(vertices <= 3 * triangles)) return expected("no more than three vertices a triangle");
  if (!(symbols <= triangles && triangles <= symbols + Math.floor(symbols / 3))) {
    return expected("as many symbols as the triangles need");
  }
  if (!(splits <= symbols)) return expected("no more split symbols than symbols");
  return { triangles, vertices };
}
