// Unpacks the bricks and pieces of a prepared file (server/dataset/FORMAT.md).
const codecs = { raw: 0, constant: 1, blosc: 2 };
const bloscHeaderBytes = 16;
const blosc = import("numcodecs/blosc").then(({ default: Blosc }) => Blosc.fromConfig({ id: "blosc" })); // While files are opened.
blosc.catch(() => {}); // Bricks that need it tell.

// Size and codec, as in an index.
export function entryOf(word: number): { size: number; codec: number } {
  return { size: word & 0xfffffff, codec: word >>> 28 };
}

// Returns `bytes` bytes; null: the packed ones are damaged. `itemBytes`: those of a constant brick.
export async function unpacked(codec: number, packed: Uint8Array, bytes: number, itemBytes: number): Promise<Uint8Array | null> {
  if (codec === codecs.raw) return packed.length === bytes ? packed : null;
  if (codec === codecs.constant) return packed.length === itemBytes ? repeated(packed, bytes) : null;
  if (codec !== codecs.blosc || packed.length < bloscHeaderBytes) return null;
  // The codec trusts the sizes in a frame's header.
  const header = new DataView(packed.buffer, packed.byteOffset, bloscHeaderBytes);
  if (header.getUint32(4, true) !== bytes || header.getUint32(12, true) !== packed.length) return null;
  try {
    const made = await (await blosc).decode(packed);
    return made.length === bytes ? made : null;
  } catch {
    return null;
  }
}

function repeated(item: Uint8Array, bytes: number): Uint8Array {
  const all = new Uint8Array(bytes);
  for (let at = 0; at < bytes; at += item.length) all.set(item, at);
  return all;
}
