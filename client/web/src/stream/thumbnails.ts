// Thumbnails of datasets, drawn by the server: fetched once for each dataset and up axis, one at a time. Files have none.
import type { DatasetInfo } from "../protocol/messages";
import { isOfFiles } from "../static/file_channel";
import type { Vec3 } from "./dataset";
import { fetchResource, resourceAddress } from "./http_resource";

export class Thumbnails {
  private readonly queue: DatasetInfo[] = [];
  private readonly pictures = new Map<string, string>(); // By their addresses.
  private isFetching = false;

  constructor(
    private readonly stream: string, // The address of the server's stream.
    private readonly token: () => string,
    private readonly up: (info: DatasetInfo) => Vec3, // The world axis that points up in the picture.
    private readonly received: (name: string, picture: string) => void,
  ) {}

  // Calls received() when there is a picture; does nothing if there is none.
  request(info: DatasetInfo): void {
    if (isOfFiles(this.stream)) return;
    this.queue.push(info);
    if (!this.isFetching) void this.fetchAll();
  }

  private async fetchAll(): Promise<void> {
    this.isFetching = true;
    for (let info = this.queue.shift(); info; info = this.queue.shift()) {
      const address = thumbnailAddress(this.stream, info, this.up(info));
      const picture = this.pictures.get(address) ?? (await this.fetched(address).catch(() => null));
      if (!picture) continue;
      this.pictures.set(address, picture);
      this.received(info.name, picture);
    }
    this.isFetching = false;
  }

  private async fetched(address: string): Promise<string | null> {
    const reply = await fetchResource(address, this.token());
    return reply.ok ? URL.createObjectURL(await reply.blob()) : null;
  }
}

// `up`: a unit vector along a world axis. The content's digest makes the address that of one picture.
export function thumbnailAddress(stream: string, { name, contentId }: DatasetInfo, up: Vec3): string {
  const axis = up.findIndex((part) => Math.abs(part) === 1);
  const address = resourceAddress(stream, `datasets/${encodeURIComponent(name)}/thumbnail.png`);
  address.searchParams.set("up", `${up[axis] < 0 ? "-" : ""}${"xyz"[axis]}`);
  address.hash = String(contentId);
  return address.href;
}
