// Exports pictures, videos, files and links.

import { glbScene, type SavedLook } from "../mesh/glb_scene";
import type { MeshFormat } from "../mesh/mesh_file";
import { savedFileText } from "../panel/downloads_section";
import { labelTable, type MeasuredLabel } from "../panel/label_table";
import type { DatasetInfo } from "../protocol/messages";
import { type Animation, recordPictures, recordVideo, turntable } from "../scene/animation";
import { h } from "../shared/elements";
import { rounded } from "../shared/numbers";
import { fileName, type NamedSurface, seriesName } from "../state/file_names";
import { nameOfLabel, renamedLabel, timeOf, timeText, withLabelsBeside } from "../state/series";
import type { Settings } from "../state/settings";
import { toAddress } from "../state/url_state";
import { applied, coordinateResolution, latticeToWorld, type Vec3, voxelLength, voxelVolume } from "../stream/dataset";
import type { MeshReply } from "../stream/mesh_request";
import { boundOf, type ShownTiles } from "../surfaces/shown_surface";
import type { Viewer } from "../viewer/viewer";
import type { PictureOptions } from "../viewer/viewer_options";

export class Downloads {
  private recording: AbortController | null = null;

  constructor(private readonly viewer: Viewer) {}

  // Returns the address of the current view, with all settings.
  addressOf(settings: Settings): string {
    const { info, stage } = this.viewer;
    const { eye, target } = stage.view();
    return toAddress({ ...settings, eye: eye as Vec3, target: target as Vec3 }, info ? coordinateResolution(info) : 0);
  }

  async copyLink(settings: Settings): Promise<void> {
    history.replaceState(null, "", `#${this.addressOf(settings)}`);
    await this.copy(location.href, "The link");
  }

  async copyEmbedding(settings: Settings): Promise<void> {
    const address = new URL(`#${this.addressOf(settings)}`, location.href);
    address.searchParams.set("embed", "");
    const frame = h("iframe", { src: address.href, width: "800", height: "600", allow: "fullscreen", title: "Multi-Tetra viewer" });
    await this.copy(frame.outerHTML, "The HTML");
  }

  async screenshot(options: PictureOptions): Promise<void> {
    const { notices, surfaces } = this.viewer;
    const isWaiting = !surfaces.isShown || !surfaces.isSettled;
    if (isWaiting) notices.announce("The picture will be saved when the surface is complete.");
    const picture = await this.viewer.picture(options);
    if (isWaiting) notices.clear();
    this.save(picture, "png");
    if (!surfaces.isShown) notices.announce("The picture has no surface: none was received.", true);
  }

  async turntable(form: "video" | "pictures"): Promise<void> {
    const { stage } = this.viewer;
    const { eye, target } = stage.view();
    await this.animate(turntable(stage, form), form, () => stage.setView(eye as Vec3, target as Vec3)); // Also if canceled.
  }

  // Records every time of a series, then restores the current one.
  async times(form: "video" | "pictures"): Promise<void> {
    const { viewer } = this;
    const { times } = viewer.playback;
    if (!times) return viewer.notices.announce("This dataset has no times.", true);
    const show = async (at: number) => {
      viewer.set({ t: times.all[at] ?? times.now, playing: false });
      await viewer.settled();
      if (at < times.all.length) this.requireTime(times.all[at]);
    };
    const { t, surfaces, playing } = viewer.get();
    const goBack = () => viewer.set({ t: t ?? times.now, surfaces, playing });
    await this.animate({ name: "time", frames: times.all.length, framesPerSecond: viewer.get().speed, show }, form, goBack);
  }

  // Rejects frames with incomplete surfaces or surfaces of another time.
  private requireTime(time: number): void {
    const { info, surfaces } = this.viewer;
    const isWhole = surfaces.shownTiles(this.viewer.get()).every(({ shown }) => shown.facts.isFinal && isAtTime(shown.info, time));
    const { failure } = surfaces.progressOf(0);
    if (info && isAtTime(info, time) && isAtTime(surfaces.firstShown?.info ?? info, time) && isWhole && failure === null) return;
    throw new Error(`the surface at ${timeText(time, info?.member?.timeUnit ?? "", this.viewer.playback.times?.all ?? [])} was not received.`);
  }

  // Stops filming; returns false if nothing is being filmed.
  cancel(): boolean {
    this.recording?.abort();
    return this.recording !== null;
  }

  private async animate(animation: Animation, form: "video" | "pictures", goBack = () => {}): Promise<void> {
    if (this.cancel()) return; // Another click.
    const { signal } = (this.recording = new AbortController());
    const showProgress = (share: number) => {
      signal.throwIfAborted();
      this.viewer.notices.announce(`Filming: ${Math.round(100 * share)} %. Esc or another click cancels.`);
    };
    try {
      const make = form === "video" ? recordVideo : recordPictures;
      const { file, ending } = await make(this.viewer.stage, animation, () => this.viewer.drawn({ isVideoFrame: true }), showProgress);
      goBack();
      this.save(file, ending, (animation.name === "time" ? seriesName : fileName)(this.shown));
      this.viewer.notices.clear();
    } catch (error) {
      goBack(); // Before the announcement, because another time clears notices.
      this.viewer.notices.announce(signal.aborted ? "Filming was canceled." : `Recording failed: ${(error as Error).message}`, true);
    }
    this.recording = null;
  }

  // GLB has all visible surfaces, other formats the first one: as files of the server, or as shown where parts of a surface
  // are hidden or the server cannot be reached.
  async download(format: MeshFormat): Promise<void> {
    const { surfaces, notices } = this.viewer;
    const visible = surfaces.shownTiles(this.viewer.get());
    const saved = format === "glb" ? visible : visible.slice(0, 1);
    if (saved.length === 0) return notices.announce("There is no surface to save.", true);
    notices.announce("Waiting for the file.");
    try {
      const files = await Promise.all(saved.map((one) => this.meshFile(one, format)));
      const looks = saved.map((one) => this.lookOf(one));
      const file =
        format === "glb"
          ? glbScene(
              files.map(({ file: glb }, i) => ({ glb, look: looks[i] })),
              saved[0].shown.info.lengthUnit,
            )
          : files[0].file;
      this.save(new Blob([file as Uint8Array<ArrayBuffer>]), format, fileName(saved.map(named)));
      notices.announce(
        savedFileText({
          triangles: files.reduce((sum, { triangles }) => sum + (triangles ?? 0), 0),
          isOfSamples: saved.some(({ shown }, i) => shown.facts.shell !== null && files[i].isAsShown),
          isOneOfSeveral: visible.length > saved.length,
          expected: saved.length === 1 && saved[0].at === 0 ? surfaces.sizes.get().expected : null,
        }),
        true,
      );
    } catch (error) {
      notices.announce((error as Error).message, true);
    }
  }

  // The server's reason for not making a file is the user's; without a connection the surface is saved as it is shown.
  private async meshFile(surface: ShownTiles, format: MeshFormat): Promise<MeshReply & { isAsShown: boolean }> {
    const settings = this.viewer.get();
    const hiddenParts = settings.surfaces[surface.at]?.hiddenParts ?? [];
    const made = hiddenParts.length > 0 ? null : await this.viewer.surfaces.file(surface, settings, format).catch(nullIfUnreachable);
    if (made) return { ...made, isAsShown: false };
    const {
      drawn,
      shown: { info, resolution },
    } = surface;
    const file = await this.viewer.pool.call("file", {
      drawn,
      toWorld: [...latticeToWorld(info, resolution)],
      step: voxelLength(info) / 2 ** resolution,
      format,
    });
    return { file, triangles: this.shownTriangles(surface), isAsShown: true };
  }

  private lookOf({ shown: { info, facts }, color, opacity }: ShownTiles): SavedLook {
    const label = info.member?.label;
    return { name: label ? nameOfLabel(label, this.viewer.get()) : `${info.name}, isovalue ${facts.isovalue}`, color, opacity };
  }

  private shownTriangles({ at, shown }: ShownTiles): number {
    return this.viewer.surfaces.progressOf(at).components?.triangles ?? shown.facts.triangles;
  }

  // Saves a table of all labels, with volumes and areas of visible ones; `only`: the indices of surfaces; null: all.
  async labels(only: readonly number[] | null): Promise<void> {
    const { viewer } = this;
    const tiles = viewer.surfaces.shownTiles(viewer.get()).filter(({ at, shown }) => shown.info.member?.label && (!only || only.includes(at)));
    if (tiles.length === 0) return viewer.notices.announce("No labels are shown.", true);
    const complete = tiles.filter((one) => one.shown.facts.spacing === 1); // The volumes of previews may be far off.
    const measures = new Map(
      await Promise.all(
        complete.map(async ({ shown, drawn }) => {
          const toWorld = [...latticeToWorld(shown.info, shown.resolution)];
          const found = await viewer.pool.call("measure", drawn, toWorld, null).catch(() => null);
          return [shown.info.name, { found, bound: boundOf(shown) }] as const;
        }),
      ),
    );
    const shown = tiles.map((one) => one.shown.info);
    const labels = only ? shown : withLabelsBeside(viewer.queries.datasets.get().list ?? [], shown);
    const rows = labels.map((info): MeasuredLabel => {
      const label = info.member!.label!;
      return {
        label: renamedLabel(label, viewer.get().labelNames),
        samplesVolume: Number(label.samples) * voxelVolume(info),
        ...(measures.get(info.name) ?? { found: null, bound: null }),
        centroid: label.centroid.length === 3 ? applied(info.indexToWorld, label.centroid).map((value) => rounded(value, coordinateResolution(info))) : null,
      };
    });
    this.save(new Blob([labelTable(rows, shown[0].lengthUnit)], { type: "text/csv" }), "csv", fileName(tiles.map(named)));
    const waiting = tiles.length - complete.length;
    if (waiting > 0) viewer.notices.announce(`The table has no volumes of ${waiting} labels, which are still being refined.`, true);
  }

  private async copy(text: string, what: string): Promise<void> {
    try {
      await navigator.clipboard.writeText(text);
      this.viewer.notices.announce(`${what} was copied to the clipboard.`, true);
    } catch {
      this.viewer.notices.announce("The link is in the address bar; this browser does not allow pages to copy.", true);
    }
  }

  // The visible surfaces.
  private get shown(): NamedSurface[] {
    return this.viewer.surfaces.shownTiles(this.viewer.get()).map(named);
  }

  private save(blob: Blob, ending: string, name = fileName(this.shown)): void {
    const link = h("a", { href: URL.createObjectURL(blob), download: `${name}.${ending}` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }
}

function named({ shown: { info, facts } }: ShownTiles): NamedSurface {
  return { info, isovalue: facts.isovalue };
}

// Datasets without a time match every time.
function isAtTime(info: DatasetInfo, time: number): boolean {
  return (timeOf(info) ?? time) === time;
}

// For fetch(), which rejects with a TypeError only if there is no reply.
function nullIfUnreachable(error: unknown): null {
  if (error instanceof TypeError) return null;
  throw error;
}
