// A decoded tile, and its summary in the manifest.

// A tile's octree cube: side 2^exponent grid steps, at (x, y, z) times its side.
export interface OctreeCube {
  exponent: number;
  x: number;
  y: number;
  z: number;
}

export interface ManifestTile {
  key: string; // hex() of its content digest.
  cube: OctreeCube;
  triangles: number;
  vertices: number;
  bytes: number;
}

// A box of lattice points: low x, y, z, high x, y, z.
export type LatticeBox = [number, number, number, number, number, number];

// On the lattice; every vertex is distinct and used.
export interface LatticeMesh {
  positions: Int32Array; // Three per vertex.
  triangles: Uint32Array; // Three vertex numbers each, counterclockwise from outside.
  normals: Float32Array | null; // The field's normals in world coordinates, three per vertex.
}

export function cubeName(cube: OctreeCube): string {
  return `cube ${cube.exponent}:${cube.x}/${cube.y}/${cube.z}`;
}

// Whether all vertices lie in the cube.
export function isInside(positions: Int32Array, cube: OctreeCube, resolution: number): boolean {
  const side = 2 ** (cube.exponent + resolution);
  const low = [cube.x * side, cube.y * side, cube.z * side];
  for (let i = 0; i < positions.length; ++i) {
    const from = low[i % 3];
    if (positions[i] < from || positions[i] > from + side) return false;
  }
  return true;
}
