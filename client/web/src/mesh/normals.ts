// Normals for shading, in lattice coordinates: the GPU transforms them by the inverse transpose of the map for
// vertices. Each has four signed 16-bit numbers, x, y, z and 0, which keeps vertices aligned.

// The matrix lattice -> world, by columns, without translation.
export type Linear = readonly number[];

// Converts the field's normals, which the wire has in world coordinates.
export function fieldNormals(world: Float32Array, linear: Linear): Int16Array {
  const packed = new Int16Array((4 * world.length) / 3);
  for (let v = 0; v < world.length / 3; ++v) {
    const x = world[3 * v];
    const y = world[3 * v + 1];
    const z = world[3 * v + 2];
    const dot = (column: number) => linear[column] * x + linear[column + 1] * y + linear[column + 2] * z;
    pack(packed, v, dot(0), dot(3), dot(6));
  }
  return packed;
}

interface Corners {
  positions: Int32Array | Float32Array; // Three per vertex.
  triangles: Uint32Array; // Three vertex numbers each.
}

// Returns sums of the normals of the triangles around each vertex, three numbers per vertex; those of tiles add up at
// shared vertices. A triangle has the weight of the sine of its corner, so that large triangles of a simplified mesh do
// not dominate. Edges shorter than `voxel`, in units of positions, count as that long: small triangles, whose normals are
// those of rounded vertices, have less weight.
export function normalSums({ positions: p, triangles }: Corners, voxel: number): Float32Array {
  const sums = new Float32Array(p.length);
  const add = (at: number, weight: number, nx: number, ny: number, nz: number) => {
    sums[at] += weight * nx;
    sums[at + 1] += weight * ny;
    sums[at + 2] += weight * nz;
  };
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t];
    const b = 3 * triangles[t + 1];
    const c = 3 * triangles[t + 2];
    const ux = p[b] - p[a];
    const uy = p[b + 1] - p[a + 1];
    const uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a];
    const vy = p[c + 1] - p[a + 1];
    const vz = p[c + 2] - p[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    const ab = Math.max(voxel, Math.sqrt(ux * ux + uy * uy + uz * uz));
    const ac = Math.max(voxel, Math.sqrt(vx * vx + vy * vy + vz * vz));
    const bc = Math.max(voxel, Math.sqrt((vx - ux) ** 2 + (vy - uy) ** 2 + (vz - uz) ** 2));
    add(a, 1 / (ab * ac), nx, ny, nz);
    add(b, 1 / (ab * bc), nx, ny, nz);
    add(c, 1 / (bc * ac), nx, ny, nz);
  }
  return sums;
}

// Smooths the sums `rounds` times: each vertex gets the sum over the corners of its triangles, which averages normals
// over a larger neighborhood. Single triangles of quantized samples do not represent the surface's orientation.
export function smoothedSums(sums: Float32Array, triangles: Uint32Array, rounds: number): Float32Array {
  let from = sums;
  for (let round = 0; round < rounds; ++round) {
    const to = new Float32Array(from.length);
    for (let t = 0; t < triangles.length; t += 3) {
      const a = 3 * triangles[t];
      const b = 3 * triangles[t + 1];
      const c = 3 * triangles[t + 2];
      const x = from[a] + from[b] + from[c];
      const y = from[a + 1] + from[b + 1] + from[c + 1];
      const z = from[a + 2] + from[b + 2] + from[c + 2];
      to[a] += x;
      to[a + 1] += y;
      to[a + 2] += z;
      to[b] += x;
      to[b + 1] += y;
      to[b + 2] += z;
      to[c] += x;
      to[c + 1] += y;
      to[c + 2] += z;
    }
    from = to;
  }
  return from;
}

export function packedNormals(sums: Float32Array): Int16Array {
  const packed = new Int16Array((4 * sums.length) / 3);
  for (let v = 0; v < sums.length / 3; ++v) {
    pack(packed, v, sums[3 * v], sums[3 * v + 1], sums[3 * v + 2]);
  }
  return packed;
}

export function pack(into: Int16Array, vertex: number, x: number, y: number, z: number): void {
  const scale = 32767 / (Math.hypot(x, y, z) || 1);
  into[4 * vertex] = x * scale;
  into[4 * vertex + 1] = y * scale;
  into[4 * vertex + 2] = z * scale;
}
