// Blocks of files in the browser's storage (IndexedDB), for the next visit. Bounded: when it is full, it begins again.
// Where there is no storage, nothing is kept.

const maxBlocks = 1 << 15; // 256 MiB.
const storeName = "blocks";

export class BlockStore {
  private readonly database: Promise<IDBDatabase | null>;

  constructor() {
    this.database = opened();
  }

  // Returns the blocks of a file, in order; undefined: not kept.
  async get(file: string, blocks: readonly number[]): Promise<(Uint8Array | undefined)[]> {
    const database = await this.database;
    if (!database) return [];
    const store = database.transaction(storeName, "readonly").objectStore(storeName);
    return Promise.all(blocks.map((block) => settled<Uint8Array | undefined>(store.get([file, block])))).catch(() => []);
  }

  async put(file: string, blocks: ReadonlyMap<number, Uint8Array>): Promise<void> {
    const database = await this.database;
    if (!database) return;
    try {
      const store = database.transaction(storeName, "readwrite").objectStore(storeName);
      if ((await settled(store.count())) + blocks.size > maxBlocks) store.clear();
      for (const [block, bytes] of blocks) store.put(bytes, [file, block]);
    } catch {
      // Full, or the page may store nothing: the blocks are fetched again.
    }
  }
}

function opened(): Promise<IDBDatabase | null> {
  try {
    const request = indexedDB.open("multitetra-files", 1);
    request.onupgradeneeded = () => request.result.createObjectStore(storeName);
    return settled(request).catch(() => null);
  } catch {
    return Promise.resolve(null);
  }
}

function settled<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}
