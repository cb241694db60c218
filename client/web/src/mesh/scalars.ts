// The values of a second field at a tile's vertices: on the wire, codes in the order of the vertices' lattice
// coordinates, by z, then y, then x, independent of Draco's order.

// Returns the values for the shader: 1 to 2 from the low end of the range to the high one, -1 where there is no value.
// 0 is the default of a vertex without data.
export function scalarAttribute(positions: Float32Array, codes: Uint8Array, bits: number): Float32Array {
  const order = verticesInOrder(positions);
  const none = 2 ** bits - 1;
  const bytes = bits / 8;
  const attribute = new Float32Array(order.length);
  order.forEach((vertex, i) => {
    const code = bytes === 1 ? codes[i] : codes[2 * i] | (codes[2 * i + 1] << 8);
    attribute[vertex] = code === none ? -1 : 1 + code / (none - 1);
  });
  return attribute;
}

// Returns the number of vertices without a value.
export function missingValues(codes: Uint8Array, bits: number): number {
  const bytes = bits / 8;
  let missing = 0;
  for (let at = 0; at < codes.length; at += bytes) if (codes[at] === 255 && codes[at + bytes - 1] === 255) ++missing;
  return missing;
}

const orders = new WeakMap<Float32Array, Uint32Array>(); // Cached, because tiles are colored repeatedly.

function verticesInOrder(p: Float32Array): Uint32Array {
  let order = orders.get(p);
  if (order) return order;
  order = Uint32Array.from({ length: p.length / 3 }, (_, i) => i);
  order.sort((a, b) => p[3 * a + 2] - p[3 * b + 2] || p[3 * a + 1] - p[3 * b + 1] || p[3 * a] - p[3 * b]);
  orders.set(p, order);
  return order;
}
