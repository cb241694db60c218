// A picture, a file or a link of what is shown.
import { h } from "./panel/dom";
import type { Notices } from "./panel/notices";
import type { Stage } from "./scene/stage";
import type { Surface } from "./scene/surface";
import type { ShownSurface } from "./shown_surface";
import type { Settings } from "./state/settings";
import { toAddress } from "./state/url_state";
import { latticeToWorld, type Vec3 } from "./stream/dataset";
import type { TilePool } from "./workers/tile_pool";
import type { MeshFormat } from "./workers/worker_messages";

export class TakeAway {
  constructor(
    private readonly stage: Stage,
    private readonly surface: Surface,
    private readonly pool: TilePool,
    private readonly notices: Notices,
    private readonly shown: () => ShownSurface | null,
  ) {}

  async copyLink(settings: Settings): Promise<void> {
    const { eye, target } = this.stage.view();
    const now = { ...settings, eye: eye as Vec3, target: target as Vec3 };
    history.replaceState(null, "", `#${toAddress(now)}`);
    try {
      await navigator.clipboard.writeText(location.href);
      this.notices.tell("The link is in the clipboard.", true);
    } catch {
      this.notices.tell("The link is in the address line; this browser does not let pages copy.", true);
    }
  }

  async screenshot(): Promise<void> {
    const background = getComputedStyle(document.body).backgroundColor;
    this.save(await this.stage.picture(background), "png");
  }

  async download(format: MeshFormat): Promise<void> {
    const shown = this.shown();
    if (!shown || this.surface.shownIds.length === 0) {
      this.notices.tell("There is no surface to save.", true);
      return;
    }
    const toWorld = [...latticeToWorld(shown.info, shown.resolution)];
    try {
      const bytes = await this.pool.file([...this.surface.shownIds], format, toWorld);
      this.save(new Blob([bytes as Uint8Array<ArrayBuffer>]), format);
    } catch {
      this.notices.tell("The surface has changed meanwhile; try again.", true);
    }
  }

  private save(blob: Blob, ending: string): void {
    const shown = this.shown();
    const name = shown ? `${shown.info.name}_${shown.facts.isovalue}` : "multitetra";
    const link = h("a", { href: URL.createObjectURL(blob), download: `${name}.${ending}` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }
}
