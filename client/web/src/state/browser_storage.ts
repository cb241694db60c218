// Storage that survives a reload. If the browser forbids storage, values are silently not kept.
export class BrowserStorage {
  constructor(private readonly storage: () => Storage) {}

  get(name: string): string | null {
    try {
      return this.storage().getItem(name);
    } catch {
      return null;
    }
  }

  set(name: string, value: string): void {
    try {
      this.storage().setItem(name, value);
    } catch {
      // Forbidden or full.
    }
  }
}

export const sessionValues = new BrowserStorage(() => sessionStorage);
export const persistentValues = new BrowserStorage(() => localStorage);
