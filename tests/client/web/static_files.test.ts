// A page without a server makes from prepared files what the server makes of them, and says what is wrong with other bytes.
// The surfaces are those of `multitetra-server reference page_padded.mtd --level 14`: all tetrahedra.
import { readFileSync } from "node:fs";

import { type ContentDigest, emptyDigest, hex, payloadHasher, sum, triangleHasher } from "../../../client/web/src/mesh/content_digest";
import { surfaceCounter } from "../../../client/web/src/mesh/plain_box";
import { shellDecoder } from "../../../client/web/src/mesh/shell_decoder";
import {
  Combination,
  CoordinateSystem,
  create,
  ErrorCode,
  ErrorUnit,
  EstimateSchema,
  FrustumSchema,
  HelloSchema,
  Interpolation,
  IsosurfaceRequestSchema,
  ListDatasetsSchema,
  OpenStreamSchema,
  ProbeSchema,
  type ServerKind,
  SliceDetail,
  SliceSchema,
  StepPolicy,
  StreamOutcome,
  ThresholdMapSchema,
  ThresholdViewSchema,
} from "../../../client/web/src/protocol/messages";
import { FileBlocks } from "../../../client/web/src/static/file_blocks";
import { FileConversation } from "../../../client/web/src/static/file_conversation";
import { unpacked } from "../../../client/web/src/static/packed_brick";
import { PageDatasets } from "../../../client/web/src/static/page_datasets";
import { openPrepared, sectionChecksum } from "../../../client/web/src/static/prepared_file";
import { RangedFile } from "../../../client/web/src/static/ranged_file";
import { Assembler } from "../../../client/web/src/stream/assembler";
import { applied } from "../../../client/web/src/stream/dataset";
import { manifestTile, shellModeOf } from "../../../client/web/src/stream/step_checks";

const golden = (name: string) => new Uint8Array(readFileSync(new URL(`../../golden/${name}`, import.meta.url)));
const wasm = readFileSync(new URL("../../../common/codec/wasm/shell_decoder.wasm", import.meta.url));
const tools = (async () => ({ count: await surfaceCounter(wasm), hash: await payloadHasher() }))();
const files = new Map<string, Uint8Array>(); // The web server's, by path.

// A web server with ranges; `changes` act on its replies.
function webServer(changes: { ignoresRanges?: boolean; tag?: () => string; busy?: number } = {}) {
  const fetched: string[] = [];
  vi.stubGlobal("fetch", async (address: string, { headers }: { headers?: Record<string, string> } = {}) => {
    const bytes = files.get(new URL(address).pathname);
    const range = /^bytes=(\d+)-(\d+)$/.exec(headers?.Range ?? "");
    fetched.push(`${new URL(address).pathname} ${headers?.Range ?? ""}`);
    if (changes.busy && changes.busy-- > 0) return new Response(null, { status: 503 });
    if (!bytes) return new Response(null, { status: 404 });
    if (!range || changes.ignoresRanges) return new Response(bytes.slice());
    if (Number(range[1]) >= bytes.length) return new Response(null, { status: 416 });
    const [from, end] = [Number(range[1]), Math.min(Number(range[2]) + 1, bytes.length)];
    const tags = { ETag: changes.tag?.() ?? '"1"', "Content-Range": `bytes ${from}-${end - 1}/${bytes.length}` };
    return new Response(bytes.slice(from, end), { status: 206, headers: tags });
  });
  return fetched;
}

function serve(name: string, bytes: Uint8Array): string {
  files.set(`/${name}`, bytes);
  return `https://site.example/${name}`;
}

function conversation(address: string, maxBytes?: number) {
  const messages: ServerKind[] = [];
  const datasets = new PageDatasets(address);
  if (maxBytes) datasets.maxSurfaceBytes = maxBytes;
  return { messages, end: new FileConversation(datasets, tools, (message) => messages.push(message)) };
}

const request = (isovalue: number, change = {}) =>
  create(IsosurfaceRequestSchema, {
    isovalue,
    lattice: 5,
    threshold: create(ThresholdMapSchema, { error: 0.25, unit: ErrorUnit.VOXEL, regionCoordinates: CoordinateSystem.WORLD, combine: Combination.IN_ORDER }),
    ...change,
  });

function seenFrom(eye: number[], lookAt: number[]) {
  const frustum = create(FrustumSchema, { lookAt, up: [0, 0, 1], aspect: 1 });
  const view = create(ThresholdViewSchema, { eye, fieldOfView: 35, heightPixels: 600, tolerancePixels: 1, frustum });
  return { threshold: create(ThresholdMapSchema, { ...request(0).threshold!, view }) };
}

// All replies to a stream.
async function streamed(address: string, dataset: string, isovalue: number, change: { maxBytes?: number; steps?: StepPolicy; request?: object } = {}) {
  const { messages, end } = conversation(address, change.maxBytes);
  const value = create(OpenStreamSchema, { requestId: 1n, dataset, request: request(isovalue, change.request), steps: change.steps });
  await end.receive({ case: "openStream", value });
  return messages;
}

function failureOf(messages: readonly ServerKind[]): string | undefined {
  const last = messages.at(-1);
  return last?.case === "error" ? last.value.text : undefined;
}

// The digest of the triangles of each step.
async function digests(messages: readonly ServerKind[]): Promise<{ spacing: number; triangles: number; digest: string }[]> {
  const [decode, hash] = [await shellDecoder(wasm), await triangleHasher(5)];
  const begins = messages.filter((message) => message.case === "stepBegin").map(({ value }) => value);
  return begins.map((begin) => {
    let digest: ContentDigest = emptyDigest;
    for (const message of messages) {
      if (message.case !== "tile" || message.value.step !== begin.step) continue;
      const { mesh } = decode(message.value.payload, manifestTile(begin.tiles[message.value.index]), shellModeOf(begin)!, 5);
      digest = sum(digest, hash(mesh.positions, mesh.triangles));
    }
    return { spacing: begin.finestSpacing, triangles: begin.tiles.reduce((n, tile) => n + tile.triangles, 0), digest: hex(digest) };
  });
}

describe("StaticFiles", () => {
  beforeEach(() => void webServer());
  afterEach(() => vi.unstubAllGlobals());

  test.each([
    ["padded", -300.5, 10656, "3366a1f29d40b2e884ee7806637d9766", [8, 1]],
    ["masked", 0.1, 8433, "0a14e6a224ad25ac1079581a890a1a09", [1]], // Every eighth sample misses the surface.
  ])("GiveTheFullResolutionSurface: %s", async (name, isovalue, triangles, digest, spacings) => {
    const address = serve(`${name}.mtd`, golden(`page_${name}.mtd`));
    const messages = await streamed(address, name, isovalue);
    const steps = await digests(messages);
    expect(steps.map(({ spacing }) => spacing)).toEqual(spacings);
    expect(steps[0].triangles).toBeGreaterThan(50);
    expect(steps.at(-1)).toEqual({ spacing: 1, triangles, digest });
  });

  test("SatisfyTheChecksOfAStream", async () => {
    const address = serve("padded.mtd", golden("page_padded.mtd"));
    const [info] = await new PageDatasets(address).list();
    const assembler = new Assembler({ info, isosurface: request(-300.5), requestId: 1n });
    const effects = (await streamed(address, "padded", -300.5)).flatMap((message) => assembler.receive(message));
    expect(effects.filter(({ kind }) => kind === "failed")).toEqual([]);
    expect(effects.filter(({ kind }) => kind === "begun")).toHaveLength(2);
  });

  test("DescribeTheirDataset", async () => {
    const [info] = await new PageDatasets(serve("masked.mtd", golden("page_masked.mtd"))).list();
    expect(info).toMatchObject({ name: "masked", dims: [23, 18, 20], spacing: [0.5, 0.5, 0.75], voidSamples: 3544n, missing: "errors", gridExponent: 5 });
    expect(info.indexToWorld).toEqual([0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.75, 1, 2, 3]);
    expect(info.contentId).not.toBe(0n);
  });

  test("AreFetchedOnce", async () => {
    const fetched = webServer();
    const { messages, end } = conversation(serve("padded.mtd", golden("page_padded.mtd")));
    for (const [i, isovalue] of [-300.5, -200, 100].entries()) {
      await end.receive({ case: "openStream", value: create(OpenStreamSchema, { requestId: BigInt(i + 1), dataset: "padded", request: request(isovalue) }) });
    }
    expect(messages.filter(({ case: kind }) => kind === "streamEnd")).toHaveLength(3);
    expect(fetched).toEqual(["/padded.mtd bytes=0-262143"]);
  });

  test("AreFetchedOnceByTwoAtATime", async () => {
    const large = golden("page_padded.mtd");
    const fetched = webServer();
    const blocks = new FileBlocks(new RangedFile(serve("padded.mtd", large)), null);
    const [one, other] = await Promise.all([blocks.require([[9000, 9010]]), blocks.require([[9005, 9020]])]);
    expect([...one(9000, 9010), ...other(9010, 9020)]).toEqual([...large.subarray(9000, 9020)]);
    expect(fetched).toHaveLength(1);
  });

  test("AreNotFetchedForASurfaceThatNobodyWantsAnyMore", async () => {
    const fetched = webServer();
    const blocks = new FileBlocks(new RangedFile(serve("large.mtd", new Uint8Array(100 << 20))), null);
    await blocks.require([[0, 100 << 20]], () => false);
    expect(fetched.length).toBeLessThan(20);
  });

  test("KeepThePreviewIfTheSurfaceIsTooLarge", async () => {
    const address = serve("padded.mtd", golden("page_padded.mtd"));
    const messages = await streamed(address, "padded", -300.5, { maxBytes: 10_000, steps: StepPolicy.FINAL_ONLY });
    expect((await digests(messages)).map(({ spacing }) => spacing)).toEqual([8]);
    expect(failureOf(messages)).toMatch(/^Every eighth sample is shown: the samples around this surface take/);
    expect(messages.at(-1)?.value).toMatchObject({ code: ErrorCode.LIMIT_EXCEEDED });
  });

  test("AreFineNearTheEyeIfTheSurfaceIsTooLarge", async () => {
    const address = serve("padded.mtd", golden("page_padded.mtd"));
    const [info] = await new PageDatasets(address).list();
    const [eye, lookAt] = [applied(info.indexToWorld, [-1, -1, -1]), applied(info.indexToWorld, [10, 10, 10])];
    const messages = await streamed(address, "padded", -300.5, { maxBytes: 10_000, request: seenFrom(eye, lookAt) });
    const assembler = new Assembler({ info, isosurface: request(-300.5, seenFrom(eye, lookAt)), requestId: 1n });
    expect(messages.flatMap((message) => assembler.receive(message)).filter(({ kind }) => kind === "failed")).toEqual([]);
    const [preview, near] = await digests(messages);
    expect(preview.spacing).toBe(8);
    expect(near.triangles).toBeGreaterThan(5 * preview.triangles);
    expect(near.triangles).toBeLessThan(10656);
    expect(failureOf(messages)).toMatch(/^All samples are shown near the eye, and every second to eighth farther away: /);
  });

  test("HaveAnExpectedSize", async () => {
    const { messages, end } = conversation(serve("padded.mtd", golden("page_padded.mtd")));
    await end.receive({ case: "estimate", value: create(EstimateSchema, { requestId: 1n, dataset: "padded", request: request(-300.5) }) });
    expect(messages[0]).toMatchObject({ case: "estimateReply", value: { triangles: 10656n } }); // It has one tile.
  });

  test("HaveNoBudgetsAndNoColors", async () => {
    const address = serve("padded.mtd", golden("page_padded.mtd"));
    const budget = await streamed(address, "padded", -300.5, { request: { maxTriangles: 100n } });
    expect((await digests(budget)).map(({ spacing }) => spacing)).toEqual([8]);
    expect(budget.at(-1)).toMatchObject({ case: "streamEnd", value: { outcome: StreamOutcome.CANCELLED, steps: 1 } });
    const larger = await digests(await streamed(address, "padded", -300.5, { request: { maxTriangles: 5000n } }));
    expect(larger.map(({ spacing }) => spacing)).toEqual([8, 2]);
    expect(larger[1].triangles).toBeGreaterThan(1000);
    const { messages, end } = conversation(address);
    const scalars = { dataset: "padded" };
    await end.receive({ case: "openStream", value: create(OpenStreamSchema, { requestId: 1n, dataset: "padded", request: request(0), scalars }) });
    expect(failureOf(messages)).toContain("needs a server");
  });

  test("AreSampledAsByAServer", async () => {
    const { messages, end } = conversation(serve("masked.mtd", golden("page_masked.mtd")));
    const field = (x: number, y: number, z: number) =>
      Math.sin(0.5 * x) * Math.cos(0.4 * y) + Math.sin(0.45 * y) * Math.cos(0.5 * z) + Math.sin(0.4 * z) * Math.cos(0.5 * x);
    const slice = {
      requestId: 1n,
      dataset: "masked",
      coordinates: CoordinateSystem.INDEX,
      origin: [0, 9, 0],
      right: [1, 0, 0],
      down: [0, 0, 1],
      width: 23,
      height: 20,
    };
    await end.receive({ case: "slice", value: create(SliceSchema, { ...slice, detail: SliceDetail.FULL }) });
    const sampled = messages[0].case === "sliceReply" ? messages[0].value : null;
    expect(sampled).toMatchObject({ width: 23, height: 20, sampleSpacing: 1 });
    const values = new Float32Array(sampled!.values.slice().buffer);
    values.forEach((value, i) => {
      const [x, z] = [i % 23, Math.floor(i / 23)];
      const isVoid = (x - 11) ** 2 + (z - 9) ** 2 > 110 || (x === 9 && z === 9);
      if (isVoid) expect(value).toBeNaN();
      else expect(Math.abs(value - field(x, 9, z))).toBeLessThan(0.01);
    });
    const layers = { ...slice, height: 1, layers: 20, inward: [0, 0, 1], detail: SliceDetail.FULL };
    await end.receive({ case: "slice", value: create(SliceSchema, layers) });
    expect(messages[1].value).toMatchObject({ height: 1, layers: 20, values: sampled!.values });
    for (const step of [1, 2, 5]) {
      const size = { width: Math.floor(22 / step), height: Math.floor(17 / step), layers: 3 };
      const box = { ...slice, origin: [1, 0, 2], right: [step, 0, 0], down: [0, step, 0], inward: [0, 0, step], ...size, detail: SliceDetail.FULL };
      const boxes: Uint8Array[] = [];
      for (const interpolation of [Interpolation.NEAREST, Interpolation.LINEAR]) {
        await end.receive({ case: "slice", value: create(SliceSchema, { ...box, interpolation }) });
        const reply = messages.pop()!;
        if (reply.case === "sliceReply") boxes.push(reply.value.values);
      }
      expect(boxes[0].length).toBe(4 * size.width * size.height * 3);
      expect(boxes[0]).toEqual(boxes[1]); // Which reads sample by sample.
    }
    await end.receive({ case: "probe", value: create(ProbeSchema, { requestId: 2n, dataset: "masked", places: [1 + 0.5 * 12.5, 2 + 0.5 * 8, 3 + 0.75 * 7] }) });
    const place = messages[2].case === "probeReply" ? messages[2].value.places[0] : null;
    expect(place!.index).toEqual([12.5, 8, 7]);
    expect(place!.value!).toBeCloseTo((field(12, 8, 7) + field(13, 8, 7)) / 2, 1);
    expect(place!.gradient[0]).toBeCloseTo((field(13.5, 8, 7) - field(11.5, 8, 7)) / 2 / 0.5, 0);
  });

  test("RefuseAServerWithoutRanges", async () => {
    webServer({ ignoresRanges: true });
    const { messages, end } = conversation(serve("padded.mtd", golden("page_padded.mtd")));
    await end.receive({ case: "hello", value: create(HelloSchema) });
    expect(failureOf(messages)).toMatch(/^site\.example ignores ranges and would send "padded\.mtd" as a whole, as Python's http\.server/);
    await end.receive({ case: "listDatasets", value: create(ListDatasetsSchema) });
    expect(messages).toHaveLength(2);
  });

  test("AreFetchedAgainIfTheWebServerIsBusy", async () => {
    webServer({ busy: 1 });
    expect((await openPrepared(serve("padded.mtd", golden("page_padded.mtd")))).info.name).toBe("padded");
    await expect(openPrepared("https://site.example/none.mtd")).rejects.toThrow('site.example answered the request for "none.mtd" with status 404.');
  });

  test("NoticeAChangedFile", async () => {
    let tag = '"1"';
    webServer({ tag: () => tag });
    const { file } = await openPrepared(serve("padded.mtd", golden("page_padded.mtd")));
    tag = '"2"';
    await expect(file.read(0, 10)).rejects.toThrow('"padded.mtd" has changed on site.example while it was read: load the page again.');
  });

  test("AreReadFromAnIndex", async () => {
    serve("a.mtd", golden("page_padded.mtd"));
    const bytes = golden("page_padded.mtd");
    const metadata = JSON.parse(new TextDecoder().decode(bytes.subarray(4096, bytes.indexOf(0, 4096))));
    const index = (content: unknown) => new PageDatasets(serve("datasets.json", new TextEncoder().encode(JSON.stringify(content))));
    const datasets = index({ version: 1, datasets: [{ file: "a.mtd", metadata }] });
    expect((await datasets.list()).map(({ name }) => name)).toEqual(["padded"]);
    expect((await datasets.volume("padded")).info.name).toBe("padded");
    await expect(datasets.volume("other")).rejects.toThrow('This page has no dataset named "other".');
    await expect(index({ version: 1, datasets: [{ file: "a.mtd", metadata: { ...metadata, dims: [9, 9, 9] } }] }).volume("padded")).rejects.toThrow(
      "export the page again",
    );
    await expect(index({ version: 2 }).list()).rejects.toThrow("it has version 2, not 1");
    await expect(index([]).list()).rejects.toThrow("is not the index of a page");
  });

  // Any byte of what is read may be wrong; the others do not matter.
  test("SayThatTheyAreDamaged", async () => {
    const whole = golden("page_padded.mtd");
    let seed = 1;
    const random = (below: number) => (seed = (seed * 48271) % 0x7fffffff) % below;
    let refused = 0;
    for (let round = 0; round < 100; ++round) {
      const bytes = whole.slice();
      const end = round % 3 === 0 ? 420 : bytes.length;
      for (let i = 0; i < 3; ++i) bytes[random(end)] ^= 1 + random(255);
      const cut = round % 10 === 9 ? bytes.slice(0, random(bytes.length)) : bytes;
      const messages = await streamed(serve(`damaged${round}.mtd`, cut), "padded", -300.5, { steps: StepPolicy.FINAL_ONLY });
      const failure = failureOf(messages);
      if (failure) expect(failure).toMatch(/^"damaged\d+\.mtd" (is damaged|is not a prepared|has format|ends too early|has a section)/);
      else expect((await digests(messages))[0].digest).toBe("3366a1f29d40b2e884ee7806637d9766");
      if (failure) ++refused;
    }
    expect(refused).toBeGreaterThan(60);
    const old = await streamed(serve("old.mtd", golden("small_of_release_0.mtd")), "small", 0);
    expect(failureOf(old)).toBe('"old.mtd" is not a prepared dataset (.mtd) of release 1.');
  });

  // A hostile file has the right checksums: what cannot be used is refused in a sentence, and nothing takes long.
  test("SurviveForgedSections", async () => {
    const checksum = await sectionChecksum();
    const random = randomNumbers(11);
    let refused = 0;
    for (let round = 0; round < 120; ++round) {
      const name = ["padded", "masked"][round % 2];
      const bytes = forged(golden(`page_${name}.mtd`), random, checksum);
      const address = serve(`forged${round}.mtd`, bytes);
      const { messages, end } = conversation(address, round % 8 < 6 ? 1 << 24 : 20_000);
      const found = (await new PageDatasets(address).list().catch(() => []))[0]?.name ?? name;
      const common = { requestId: 1n, dataset: found, coordinates: CoordinateSystem.INDEX };
      await end.receive({ case: "openStream", value: create(OpenStreamSchema, { ...common, request: request(0.1, seenFrom([0, 0, 0], [5, 5, 5])) }) });
      await end.receive({
        case: "slice",
        value: create(SliceSchema, { ...common, right: [1, 0, 0], down: [0, 1, 0], origin: [0, 0, 1], width: 40, height: 40 }),
      });
      await end.receive({ case: "probe", value: create(ProbeSchema, { ...common, places: [1, 1, 1] }) });
      const errors = messages.flatMap((message) => (message.case === "error" ? [message.value.text] : []));
      for (const text of errors)
        expect(text).toMatch(
          /^("forged\d+\.mtd" (is damaged|is not a prepared|ends too early|has a section)|Every eighth|All samples are shown near|The samples of a tile cannot be marched: some are infinite)/,
        );
      for (const text of errors) expect(text).not.toMatch(/undefined|Invalid|buffer|bounds|BigInt|length of/);
      if (errors.length > 0) ++refused;
    }
    expect(refused).toBeGreaterThan(40);
  });

  // A hostile file has the right checksums.
  test("SurviveDamagedFrames", async () => {
    const { offset, size, bytes } = firstFrame(golden("page_padded.mtd"));
    const frame = golden("page_padded.mtd").slice(offset, offset + size);
    const whole = await unpacked(2, frame, bytes, 2);
    expect(whole).toHaveLength(bytes);
    let seed = 7;
    const random = (below: number) => (seed = (seed * 48271) % 0x7fffffff) % below;
    for (let round = 0; round < 300; ++round) {
      const damaged = frame.slice(0, round % 5 === 0 ? random(size) : size);
      for (let i = 0; i < 2; ++i) damaged[random(damaged.length)] ^= 1 + random(255);
      const made = await unpacked(2, damaged, bytes, 2);
      expect(made === null || made.length === bytes).toBe(true);
    }
    expect(await unpacked(2, frame, bytes, 2)).toEqual(whole);
  });
});

// The first brick of samples in a frame of blosc: c-blosc's version 2, bit shuffle.
function firstFrame(file: Uint8Array): { offset: number; size: number; bytes: number } {
  const view = new DataView(file.buffer);
  const found = Array.from({ length: file.length / 4 }, (_, i) => 4 * i).find(
    (at) => file[at] === 2 && file[at + 1] === 1 && file[at + 3] === 2 && view.getUint32(at + 4, true) === 8192,
  )!;
  return { offset: found, size: view.getUint32(found + 12, true), bytes: view.getUint32(found + 4, true) };
}

function randomNumbers(seed: number): (below: number) => number {
  let state = seed;
  return (below) => (state = (state * 48271) % 0x7fffffff) % below;
}

// Changes a section, or where the table says that it lies, and corrects the checksums of both.
function forged(file: Uint8Array, random: (below: number) => number, checksum: (bytes: Uint8Array) => bigint): Uint8Array {
  const view = new DataView(file.buffer);
  const end = 24 + 40 * view.getUint32(12, true);
  const entry = 24 + 40 * random(view.getUint32(12, true));
  const [offset, size] = [Number(view.getBigUint64(entry + 16, true)), Number(view.getBigUint64(entry + 24, true))];
  const isMetadata = file[entry] === "m".charCodeAt(0);
  if (random(3) === 0) {
    const huge = [0n, 1n, 1n << 20n, 1n << 40n, (1n << 52n) + 1n, (1n << 64n) - 1n][random(6)];
    view.setBigUint64(16, 1n << 53n, true); // The length of the file.
    view.setBigUint64(entry + [16, 24][random(2)], huge, true);
  } else if (isMetadata) {
    const text = new TextDecoder().decode(file.subarray(offset, offset + size));
    const numbers = [...text.matchAll(/-?\d+(\.\d+)?/g)];
    const { index, 0: number } = numbers[random(numbers.length)];
    const other = ["0", "-1", "1e9", "524289", "1e308", "null", '"x"', "[]"][random(8)].slice(0, number.length).padEnd(number.length);
    file.set(new TextEncoder().encode(other), offset + index);
  } else {
    for (let i = 0; i < 3; ++i) file[offset + random(size)] ^= 1 + random(255);
  }
  const named = ["offset", "size"].map((_, i) => Number(view.getBigUint64(entry + 16 + 8 * i, true)));
  view.setBigUint64(entry + 32, checksum(file.subarray(named[0], named[0] + named[1])), true);
  view.setBigUint64(end, checksum(file.subarray(0, end)), true);
  return file;
}
