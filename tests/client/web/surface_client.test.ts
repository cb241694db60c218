import {
  create,
  type DatasetInfo,
  ErrorCode,
  ErrorReplySchema,
  type EstimateReply,
  type OpenStream,
  Priority,
  type ServerKind,
  type StepBegin,
  StepPolicy,
  StreamOutcome,
} from "../../../client/web/src/protocol/messages";
import type { Surface } from "../../../client/web/src/scene/surface";
import { nothingHidden } from "../../../client/web/src/state/hidden_parts";
import type { StepFacts } from "../../../client/web/src/state/progress";
import { type WrittenSettings, writtenDefaults } from "../../../client/web/src/state/settings";
import { ConnectionPool } from "../../../client/web/src/stream/connection_pool";
import { applied, inverse, latticeToWorld } from "../../../client/web/src/stream/dataset";
import type { DatasetQueries } from "../../../client/web/src/stream/dataset_queries";
import { isosurfaceRequest } from "../../../client/web/src/stream/request";
import { ServerConnection } from "../../../client/web/src/stream/server_connection";
import type { PreviewClient, SharedPreviews } from "../../../client/web/src/stream/shared_previews";
import { StepSpeed } from "../../../client/web/src/stream/step_speed";
import type { StreamRequest } from "../../../client/web/src/stream/stream_request";
import { Prefetcher } from "../../../client/web/src/surfaces/prefetcher";
import { allComponents, type CachedStep, StepCache } from "../../../client/web/src/surfaces/step_cache";
import { SurfaceClient } from "../../../client/web/src/surfaces/surface_client";
import type { TilePool } from "../../../client/web/src/workers/tile_pool";
import type { DrawnTiles, Selection } from "../../../client/web/src/workers/worker_messages";
import { dataset, messages } from "./golden_stream";
import { link } from "./mocked_link";

const [welcome, , begin] = messages();

vi.mock("../../../client/web/src/stream/link", () => import("./mocked_link"));

vi.stubGlobal("window", globalThis); // Provides its timers.

const nothing = () => {};
const silent = { offer: nothing, withdraw: nothing, shown: nothing, settled: nothing };

function partsOf() {
  const surface = {
    budget: 100,
    ids: () => [],
    dropUnused: nothing,
    use: nothing,
    release: nothing,
    show: nothing,
    trianglesOf: () => 30,
  } as unknown as Surface;
  const pool = { cancelJobs: nothing, call: (_: string, drawn: DrawnTiles) => selections.of(drawn) } as unknown as TilePool;
  const stepCache = new StepCache(() => true);
  const sharedPreviews = { request: nothing, cancel: nothing } as unknown as SharedPreviews;
  const queries = { estimate: vi.fn(() => Promise.reject(new Error("Not estimated."))) } as unknown as DatasetQueries;
  const connections = new ConnectionPool(() => new ServerConnection("ws://server/v1/stream", () => "", ""), 2);
  return { number: 1, pool, surface, stepCache, queries, connections, sharedPreviews, speed: new StepSpeed(), isFirst: () => true };
}

function clientOf(parts = partsOf()) {
  return new SurfaceClient(parts, { ...silent, offer: (_, show) => show() });
}

const lastLink = () => link.all.at(-1)!;

const time = { scene: "gyroid", time: null };
const settings = { ...writtenDefaults, isovalue: 0.1, error: 0.5 };

// The last request.
function openStream(): OpenStream | undefined {
  return link.sent.filter(({ case: kind }) => kind === "openStream").at(-1)?.value as OpenStream | undefined;
}

// Accepts the connection; returns the kinds of the client's next messages.
function accept(): string[] {
  link.sent.length = 0;
  lastLink().opened();
  lastLink().received(welcome);
  return link.sent.map(({ case: kind }) => String(kind));
}

function streaming() {
  const client = clientOf();
  client.request(dataset(), settings, null, { time });
  accept();
  return client;
}

// Simulates the mesh worker's selections of components; the test decides when it answers.
const selections = {
  requested: [] as { drawn: DrawnTiles; answer: (found: Selection) => void }[],
  of: (drawn: DrawnTiles) => new Promise<Selection>((answer) => selections.requested.push({ drawn, answer })),
};

function selectionOf(shown: number): Selection {
  return { components: 5, shown, triangles: 10 * shown, largest: null, parted: [] };
}

describe("SurfaceClient", () => {
  test("RepeatsLostStreams", () => {
    const client = streaming();
    expect(client.progress.get()).toMatchObject({ isStreaming: true, failure: null });
    lastLink().closed();
    expect(client.progress.get().isStreaming).toBe(false);
    expect(accept()).toEqual(["hello", "openStream"]);
    expect(client.progress.get().isStreaming).toBe(true);
  });

  test("ReplacesTooLargeSurfacesByOnesOfASafeSize", async () => {
    const parts = partsOf();
    vi.mocked(parts.queries.estimate).mockResolvedValue({ triangles: 9_000_000n, bytes: 10n, errorBoundWorld: 1 } as EstimateReply);
    const client = clientOf(parts);
    client.request(dataset(), settings, null, { time });
    accept();
    await vi.waitFor(() => expect(client.progress.get().sizeToConfirm).toMatchObject({ triangles: 9_000_000 }));
    expect(openStream()?.request?.maxTriangles).toBe(2_000_000n);
    client.confirmSize();
    expect(openStream()?.request?.maxTriangles).toBe(0n);
  });

  test("DoesNotRepeatTooLargeSurfaces", () => {
    const client = clientOf();
    const info = dataset();
    client.request(info, settings, null, { time });
    accept();
    const { requestId } = openStream()!;
    lastLink().received({ case: "error", value: create(ErrorReplySchema, { requestId, code: ErrorCode.LIMIT_EXCEEDED, text: "A page holds less." }) });
    expect(client.progress.get().failure).toMatchObject({ text: "A page holds less.", needsView: `${info.name} ${settings.isovalue}` });
    link.sent.length = 0;
    client.request(info, settings, null, { time });
    expect(openStream()).toBeUndefined();
    client.request(info, { ...settings, error: 1 }, null, { time });
    expect(openStream()).toBeDefined();
  });

  test("RequestsNoSizesOfSmallLabels", () => {
    const requests = (samples: bigint) => {
      const parts = { ...partsOf(), isFirst: () => false };
      const info = { ...dataset(), member: { label: { value: 1, samples } } } as unknown as DatasetInfo;
      clientOf(parts).request(info, settings, null, { time });
      return vi.mocked(parts.queries.estimate).mock.calls.length;
    };
    expect([requests(1000n), requests(1_000_000_000n)]).toEqual([0, 1]);
  });

  test("RequestsMissingSharedPreviewsAlone", () => {
    const wanted: StreamRequest[] = [];
    const previewed: PreviewClient[] = [];
    const request = (one: PreviewClient, of: StreamRequest) => void [previewed.push(one), wanted.push(of)];
    const sharedPreviews = { cancel: nothing, request } as unknown as SharedPreviews;
    const client = clientOf({ ...partsOf(), sharedPreviews, isFirst: () => false });
    const info = { ...dataset(), member: { label: { value: 1, samples: 100n, box: [0, 0, 0, 9, 9, 9] } } } as unknown as DatasetInfo;
    const attempts = link.attempts;
    client.request(info, { ...settings, shading: "field" }, null, { time, steps: "coarse" });
    expect(wanted).toMatchObject([{ info, isosurface: { normals: 0 } }]);
    expect([client.isPreviewing, link.attempts]).toEqual([true, attempts]);
    previewed[0].requestAlone();
    expect(link.attempts).toBe(attempts + 1);
    accept();
    expect(openStream()).toMatchObject({ request: { normals: 8 }, steps: StepPolicy.PREVIEWS_ONLY });
  });

  test("RequestsPreviewsFirstAmongSeveralSurfaces", () => {
    const client = clientOf();
    client.request(dataset(), settings, null, { time, steps: "previews" });
    accept();
    expect(openStream()?.steps).toBe(StepPolicy.PREVIEWS_ONLY);
    expect(client.isPreviewing).toBe(true);
    const { requestId, request } = openStream()!;
    const preview = { ...(begin.value as StepBegin), requestId, request, isFinal: false };
    lastLink().received({ case: "stepBegin", value: preview } as ServerKind);
    lastLink().received({ case: "streamEnd", value: { requestId, outcome: StreamOutcome.COMPLETE, steps: 1 } } as ServerKind);
    expect(client.progress.get().failure).toBeNull();
    expect([client.isPreviewed, client.isBusy]).toEqual([true, false]);
    client.finish();
    expect(openStream()?.steps).toBe(StepPolicy.FINAL_ONLY);
    expect([client.isPreviewed, client.isBusy]).toEqual([false, true]);
  });

  test("CompletesWhileDragging", () => {
    const client = clientOf();
    client.request(dataset(), settings, null, { time, steps: "all", isDragging: true });
    accept();
    expect(openStream()?.steps).toBe(StepPolicy.PROGRESSIVE);
    client.close();
  });

  test("ShowsCachedStepsImmediately", () => {
    const parts = partsOf();
    const client = clientOf(parts);
    link.sent.length = 0;
    parts.stepCache.keep(requestOf(dataset()), frameOf(dataset()));
    client.request(dataset(), settings, null, { time });
    expect(openStream()).toBeUndefined();
    expect(client.shown?.info.name).toBe(dataset().name);
    client.request(dataset(), { ...settings, isovalue: 0.2 }, null, { time });
    accept();
    expect(openStream()).toBeDefined();
  });

  test("IsCurrentOnlyWithTheLatestIsovalue", () => {
    const { client } = keptAndWanted(settings);
    expect(client.isCurrent).toBe(true);
    client.request(dataset(), { ...settings, isovalue: 0.2 }, null, { time });
    expect(client.isCurrent).toBe(false);
    client.request(dataset(), settings, null, { time });
    expect(client.isCurrent).toBe(true);
  });

  test("HidesSmallComponentsWithoutRequests", async () => {
    const { client, shows, settles } = keptAndWanted(settings);
    expect(shows).toEqual([null]);
    client.hide({ minComponent: 4, places: [] });
    client.hide({ minComponent: 12, places: [] });
    client.hide({ minComponent: 12, places: [] });
    expect([selections.requested.length, client.isBusy, client.isSettled]).toEqual([2, false, false]);
    const [four, twelve] = selections.requested;
    expect(twelve.drawn.leastDiagonal).toBe(12 * 32); // In lattice steps.
    twelve.answer(selectionOf(2));
    four.answer(selectionOf(3)); // This one was cancelled.
    await vi.waitFor(() => expect(client.progress.get().components).toEqual({ minComponent: 12, components: 5, shown: 2, triangles: 20 }));
    expect(client.drawn.leastDiagonal).toBe(12 * 32);
    client.hide(nothingHidden);
    await vi.waitFor(() => expect(client.progress.get().components).toBeNull());
    expect(shows).toEqual([null, selectionOf(2), null]);
    expect([client.drawn.leastDiagonal, client.isSettled, settles(), openStream()]).toEqual([0, true, 1, undefined]);
  });

  test("HidesPartsInLatticeCoordinates", async () => {
    const { client } = keptAndWanted(settings);
    client.hide({ minComponent: 0, places: [[1, 2, 3]] });
    const [requested] = selections.requested;
    expect(requested.drawn).toMatchObject({ leastDiagonal: 0, hidden: [applied(inverse(latticeToWorld(dataset(), 5)), [1, 2, 3])] });
    requested.answer(selectionOf(4));
    await vi.waitFor(() => expect(client.progress.get().components).toMatchObject({ components: 5, shown: 4 }));
    expect(client.drawn.hidden).toEqual(requested.drawn.hidden);
  });

  test("ShowsCachedStepsWithoutHiddenComponents", async () => {
    const { client, shows, settles } = keptAndWanted({ ...settings, minComponent: 3 });
    expect([shows, client.shown, client.isBusy, settles()]).toEqual([[], null, true, 0]);
    selections.requested[0].answer(selectionOf(1));
    await vi.waitFor(() => expect(shows).toEqual([selectionOf(1)]));
    expect([client.isBusy, settles()]).toEqual([false, 1]);
  });
});

// A client with cached surfaces, and the selections that its surface was requested to show.
function keptAndWanted(wanted: WrittenSettings) {
  link.sent.length = selections.requested.length = 0;
  const shows: (Selection | null)[] = [];
  const parts = partsOf();
  parts.surface.show = (_, selection) => shows.push(selection ?? null);
  parts.stepCache.keep(requestOf(dataset()), frameOf(dataset()));
  let settled = 0;
  const client = new SurfaceClient(parts, { ...silent, offer: (_, show) => show(), settled: () => ++settled });
  client.request(dataset(), wanted, null, { time });
  return { client, shows, settles: () => settled };
}

describe("Prefetcher", () => {
  const times = [1, 2, 3, 4].map((time) => ({ ...dataset(), name: `gyroid.t${time}` }));
  const soon = times.map((info) => ({ info, time }));

  test("RequestsOneTimeAtATimeInBackground", () => {
    const prefetcher = new Prefetcher(partsOf());
    prefetcher.prepare(soon, settings, null);
    accept();
    expect(openStream()).toMatchObject({ dataset: "gyroid.t1", steps: StepPolicy.FINAL_ONLY, priority: Priority.BACKGROUND });
    expect(prefetcher.has({ info: times[0] }, settings, null)).toBe(false);
    lastLink().received({ case: "error", value: { requestId: 1n, code: 3, text: "No." } } as ServerKind);
    expect(prefetcher.has({ info: times[0] }, settings, null)).toBe(true); // It will have none.
    expect(openStream()?.dataset).toBe("gyroid.t2");
    prefetcher.close();
  });

  test("SkipsCachedTimesWithinItsBudget", () => {
    const parts = partsOf();
    const prefetcher = new Prefetcher(parts);
    for (const info of times.slice(0, 3)) parts.stepCache.keep(requestOf(info), frameOf(info));
    link.sent.length = 0;
    const { attempts } = link;
    prefetcher.prepare(soon, settings, null); // 30 of 100 triangles each.
    expect(link.attempts).toBe(attempts);
    prefetcher.prepare(soon.slice(2), settings, null);
    accept();
    expect(openStream()?.dataset).toBe("gyroid.t4");
    prefetcher.close();
  });

  test("RestartsForOtherSettings", () => {
    const prefetcher = new Prefetcher(partsOf());
    prefetcher.prepare(soon, settings, null);
    accept();
    prefetcher.prepare(soon, { ...settings, isovalue: 0.2 }, null);
    expect(openStream()).toMatchObject({ dataset: "gyroid.t1", request: { isovalue: 0.2 } });
    expect(prefetcher.has({ info: times[0] }, { ...settings, isovalue: 0.2 }, null)).toBe(false);
    prefetcher.close();
  });

  test("CancelsUnneededPrefetches", () => {
    const prefetcher = new Prefetcher(partsOf());
    prefetcher.prepare(soon, settings, null);
    accept();
    prefetcher.prepare(soon.slice(2), settings, null);
    expect(link.sent.map(({ case: kind }) => kind)).toContain("cancel");
    expect(openStream()?.dataset).toBe("gyroid.t3");
    prefetcher.close();
  });
});

function requestOf(info: DatasetInfo) {
  return { info, isosurface: isosurfaceRequest(info, settings, null) };
}

function frameOf(info: DatasetInfo): CachedStep {
  const facts = { isFinal: true } as StepFacts;
  return { ids: [`1:${info.name}/8/tile`], shown: { info, resolution: 5, request: requestOf(info).isosurface, facts }, visible: allComponents };
}
