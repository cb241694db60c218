// Follows how far a server is that has no dataset yet, because it is reading the volume.
import { fetchResource, resourceAddress } from "./http_resource";

interface Reading {
  name: string;
  share: number; // 0 to 1.
}

const interval = 300; // Milliseconds.
const longest = 10_000; // Where nothing is read, each wait is twice the last one.

export class ReadingWatch {
  private timer = 0;
  private wait = interval;

  constructor(
    private readonly stream: string, // The address of the server's stream.
    private readonly token: () => string,
    private readonly report: (text: string) => void,
    private readonly ended: () => void, // Nothing is being read: asks for the list again.
  ) {}

  // Reports until close(); does nothing if it does so already.
  begin(): void {
    if (this.timer !== 0) return;
    this.wait = interval;
    this.next(0);
  }

  close(): void {
    clearTimeout(this.timer);
    this.timer = 0;
  }

  private next(wait: number): void {
    this.timer = window.setTimeout(() => void this.look(), wait);
  }

  private async look(): Promise<void> {
    const reply = await fetchResource(resourceAddress(this.stream, "datasets").href, this.token()).catch(() => null);
    const { reading = [] } = reply?.ok ? ((await reply.json().catch(() => ({}))) as { reading?: Reading[] }) : {};
    if (this.timer === 0) return;
    if (reading.length > 0) {
      this.wait = interval;
      this.report(readingText(reading[0]));
    } else {
      this.wait = Math.min(2 * this.wait, longest);
      this.ended();
    }
    if (this.timer !== 0) this.next(this.wait);
  }
}

export function readingText({ name, share }: Reading): string {
  return `Reading "${name}": ${Math.floor(100 * share)} %.`;
}
