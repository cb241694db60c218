// Joins GLB files of one surface each to a scene in which every surface has its name and color.

// How a surface looks.
export interface SavedLook {
  name: string;
  color: string; // "#rrggbb"
  opacity: number; // 0 to 1.
}

type Index = number;
interface Primitive {
  attributes: Record<string, Index>;
  indices?: Index;
  material?: Index;
}
interface Gltf {
  asset: Record<string, unknown>;
  scene?: Index;
  scenes?: { nodes?: Index[] }[];
  nodes?: { name?: string; mesh?: Index; children?: Index[] }[];
  meshes?: { primitives: Primitive[]; extensions?: Record<string, unknown> }[];
  materials?: Record<string, unknown>[];
  accessors?: { bufferView?: Index }[];
  bufferViews?: { buffer: Index; byteOffset?: number }[];
  buffers?: { byteLength: number }[];
  extensionsUsed?: string[];
}

const magic = { glb: 0x46546c67, json: 0x4e4f534a, binary: 0x004e4942 };

// Throws if the bytes are not such a file.
export function glbScene(files: readonly { glb: Uint8Array; look: SavedLook }[], lengthUnit: string): Uint8Array {
  const scene: Required<Gltf> = {
    asset: {},
    scene: 0,
    scenes: [{ nodes: [] }],
    nodes: [],
    meshes: [],
    materials: [],
    accessors: [],
    bufferViews: [],
    buffers: [],
    extensionsUsed: [],
  };
  const binaries: Uint8Array[] = [];
  let bytes = 0;
  for (const { glb, look } of files) {
    const { json, binary } = contentOf(glb);
    append(scene, json, look, bytes);
    bytes += binary.length;
    binaries.push(binary);
  }
  const { asset } = scene;
  if (lengthUnit) scene.asset = { ...asset, extras: { ...(asset.extras as object), length_unit: lengthUnit } };
  scene.buffers = [{ byteLength: bytes }];
  return glbOf(Object.fromEntries(Object.entries(scene).filter(([, value]) => !Array.isArray(value) || value.length > 0)), binaries);
}

function append(scene: Required<Gltf>, file: Gltf, look: SavedLook, byteOffset: number): void {
  const [nodes, meshes, materials, accessors, views] = [scene.nodes, scene.meshes, scene.materials, scene.accessors, scene.bufferViews].map(
    ({ length }) => length,
  );
  scene.asset = { ...file.asset, ...scene.asset };
  scene.extensionsUsed = [...new Set([...scene.extensionsUsed, ...(file.extensionsUsed ?? [])])];
  scene.scenes[0].nodes!.push(...(file.scenes?.[file.scene ?? 0]?.nodes ?? []).map((node) => node + nodes));
  for (const { mesh, children, ...node } of file.nodes ?? []) {
    scene.nodes.push({
      ...node,
      ...(mesh === undefined ? {} : { name: look.name, mesh: mesh + meshes }),
      ...(children && { children: children.map((child) => child + nodes) }),
    });
  }
  for (const { primitives, extensions, ...mesh } of file.meshes ?? []) {
    const moved = primitives.map(({ attributes, indices, material, ...primitive }) => ({
      ...primitive,
      attributes: Object.fromEntries(Object.entries(attributes).map(([name, index]) => [name, index + accessors])),
      ...(indices === undefined ? {} : { indices: indices + accessors }),
      material: (material ?? 0) + materials,
    }));
    scene.meshes.push({ ...mesh, primitives: moved, ...(extensions && { extensions: movedManifold(extensions, accessors) }) });
  }
  for (const material of file.materials ?? [{}]) scene.materials.push({ ...material, ...lookOf(look) });
  for (const accessor of file.accessors ?? [])
    scene.accessors.push(accessor.bufferView === undefined ? accessor : { ...accessor, bufferView: accessor.bufferView + views });
  for (const view of file.bufferViews ?? []) scene.bufferViews.push({ ...view, byteOffset: (view.byteOffset ?? 0) + byteOffset });
}

// EXT_mesh_manifold names accessors; other extensions of meshes are left out.
function movedManifold(extensions: Record<string, unknown>, accessors: number): Record<string, unknown> {
  const manifold = extensions.EXT_mesh_manifold;
  if (!manifold) return {};
  const moved = (value: unknown, key = ""): unknown => {
    if (typeof value === "object" && value !== null) return Object.fromEntries(Object.entries(value).map(([name, one]) => [name, moved(one, name)]));
    return ["indices", "mergeIndices", "mergeValues"].includes(key) ? Number(value) + accessors : value;
  };
  return { EXT_mesh_manifold: moved(manifold) };
}

function lookOf({ name, color, opacity }: SavedLook): Record<string, unknown> {
  return {
    name,
    doubleSided: true,
    ...(opacity < 1 ? { alphaMode: "BLEND" } : {}),
    pbrMetallicRoughness: { baseColorFactor: [...linearLight(color), opacity], metallicFactor: 0, roughnessFactor: 0.6 },
  };
}

// Converts "#rrggbb" from sRGB to linear light.
function linearLight(color: string): number[] {
  return [1, 3, 5].map((at) => {
    const srgb = parseInt(color.slice(at, at + 2), 16) / 255;
    return srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;
  });
}

function contentOf(glb: Uint8Array): { json: Gltf; binary: Uint8Array } {
  const view = new DataView(glb.buffer, glb.byteOffset, glb.byteLength);
  const isGlb = glb.length >= 20 && view.getUint32(0, true) === magic.glb && view.getUint32(8, true) === glb.length && view.getUint32(16, true) === magic.json;
  const end = isGlb ? 20 + view.getUint32(12, true) : Infinity;
  if (end > glb.length) throw new Error("The server did not send a GLB file.");
  const json = JSON.parse(new TextDecoder().decode(glb.subarray(20, end))) as Gltf;
  return { json, binary: glb.subarray(Math.min(end + 8, glb.length)) };
}

function glbOf(json: object, binaries: readonly Uint8Array[]): Uint8Array {
  const text = new TextEncoder().encode(JSON.stringify(json));
  const jsonBytes = Math.ceil(text.length / 4) * 4;
  const binaryBytes = binaries.reduce((sum, { length }) => sum + length, 0);
  const glb = new Uint8Array(28 + jsonBytes + binaryBytes).fill(0x20, 20, 20 + jsonBytes);
  const view = new DataView(glb.buffer);
  [magic.glb, 2, glb.length, jsonBytes, magic.json].forEach((value, i) => view.setUint32(4 * i, value, true));
  glb.set(text, 20);
  view.setUint32(20 + jsonBytes, binaryBytes, true);
  view.setUint32(24 + jsonBytes, magic.binary, true);
  let at = 28 + jsonBytes;
  for (const binary of binaries) {
    glb.set(binary, at);
    at += binary.length;
  }
  return glb;
}
