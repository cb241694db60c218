// What a tile is after decoding, and what a manifest promised of it.

// A tile's octree cube: side 2^exponent grid steps, at (x, y, z) times its side.
export interface OctreeCube {
  exponent: number;
  x: number;
  y: number;
  z: number;
}

export interface TilePromise {
  key: string; // hex() of the digest of its triangles.
  cube: OctreeCube;
  triangles: number;
  vertices: number;
  bytes: number;
}

// A box of lattice points: low x, y, z, high x, y, z.
export type LatticeBox = [number, number, number, number, number, number];

// On the lattice; every vertex distinct and used.
export interface LatticeMesh {
  positions: Int32Array; // Three a vertex.
  triangles: Uint32Array; // Three vertex numbers each, counterclockwise from outside.
  normals: Float32Array | null; // Three a vertex: the field's, in world coordinates.
}

export function nameOf(cube: OctreeCube): string {
  return `cube ${cube.exponent}:${cube.x}/${cube.y}/${cube.z}`;
}
