import { isSound, matchBoundaries } from "../../../client/web/src/mesh/boundary_matcher";
import { hex } from "../../../client/web/src/mesh/content_digest";
import { boundaryOf, type TileBoundary } from "../../../client/web/src/mesh/tile_boundary";
import { create, ErrorCode, ErrorReplySchema, type ServerKind } from "../../../client/web/src/protocol/messages";
import { Assembler, type AssemblerEffect } from "../../../client/web/src/stream/assembler";
import { dataBorder } from "../../../client/web/src/stream/dataset";
import { dataset, found, messages, request, tileFrom } from "./golden_stream";

const stream = messages().filter(({ case: kind }) => kind !== "welcome" && kind !== "datasetList");

// Performs the assembler's effects as the page does, and returns those visible to a user.
async function played(all: readonly ServerKind[], assembler = newAssembler()) {
  const seen: AssemblerEffect[] = [];
  const boundaries = new Map<string, TileBoundary>();
  const perform = async (effects: AssemblerEffect[]): Promise<void> => {
    for (const effect of effects) {
      if (effect.kind === "decode") {
        try {
          boundaries.set(effect.tile.key, boundaryOf(await tileFrom(effect.payload, effect.tile)));
          await perform(assembler.decoded(effect.tile.key));
        } catch (error) {
          await perform(assembler.damaged((error as Error).message));
        }
      } else if (effect.kind === "check") {
        const { tiles, begin } = effect.step;
        const seams = matchBoundaries(
          tiles.map(({ key }) => boundaries.get(key)!),
          dataBorder(dataset(), 5, 0, 1),
        );
        await perform(assembler.checked(begin.step, seams.topology));
      } else {
        seen.push(effect);
      }
    }
  };
  for (const message of all) await perform(assembler.receive(message));
  return seen;
}

function newAssembler(held: string[] = []): Assembler {
  return new Assembler({ info: dataset(), isosurface: request(), requestId: 1n }, held);
}

function kinds(effects: AssemblerEffect[]): string[] {
  return effects.map(({ kind }) => kind);
}

function changed(index: number, change: (value: never) => void): ServerKind[] {
  const all = messages().filter(({ case: kind }) => kind !== "welcome" && kind !== "datasetList");
  change(all[index].value as never);
  return all;
}

describe("Assembler", () => {
  test("MatchesTheNativeClient", async () => {
    const effects = await played(stream);
    expect(kinds(effects)).toEqual(["begun", "committed", "ended"]);
    const committed = effects[1] as AssemblerEffect & { kind: "committed" };
    expect(hex(committed.step.digest)).toBe(found.digest);
    expect(isSound(committed.topology)).toBe(true);
    const { digest: _, ...counts } = found;
    expect(committed.topology).toMatchObject(counts);
  });

  test("CommitsNoStepBeforeItsEnd", async () => {
    for (let cut = 0; cut < stream.length - 2; ++cut) {
      expect(kinds(await played(stream.slice(0, cut)))).not.toContain("committed");
    }
  });

  test("CommitsCompleteStepsBeforeARefusal", () => {
    const assembler = newAssembler();
    const refusal: ServerKind = { case: "error", value: create(ErrorReplySchema, { requestId: 1n, code: ErrorCode.LIMIT_EXCEEDED, text: "too large" }) };
    const effects = [...stream.slice(0, -1), refusal].flatMap((message) => assembler.receive(message));
    expect(kinds(effects)).not.toContain("refused");
    const decoded = effects.flatMap((effect) => (effect.kind === "decode" ? assembler.decoded(effect.tile.key) : []));
    expect(kinds(decoded)).toEqual(["check"]);
    const topology = { ...found, borderEdges: 0, openEdges: 0, nonmanifoldEdges: 0, degenerateTriangles: 0 };
    expect(kinds(assembler.checked(0, topology as never))).toEqual(["committed", "refused"]);
  });

  test("RejectsMissingTiles", async () => {
    const effects = await played(stream.filter((_, i) => i !== 2));
    expect(effects.at(-1)).toMatchObject({ kind: "failed", text: expect.stringContaining("1 of its tiles missing") });
  });

  test("RejectsDamagedTiles", async () => {
    for (const at of [0, 12, 500, 3000]) {
      const all = changed(1, (tile: { payload: Uint8Array }) => (tile.payload[at] ^= 1));
      expect(kinds(await played(all))).not.toContain("committed");
    }
  });

  test("RejectsWrongStepDigests", async () => {
    const all = changed(stream.length - 2, (end: { digestLow: bigint }) => (end.digestLow ^= 1n));
    expect((await played(all)).at(-1)).toMatchObject({ kind: "failed", text: expect.stringContaining("digest") });
  });

  test("RejectsParametersThatWereNotRequested", async () => {
    const all = changed(0, (begin: { request: { isovalue: number } }) => (begin.request.isovalue = 0.2));
    expect((await played(all)).at(-1)).toMatchObject({ kind: "failed", text: expect.stringContaining("parameters") });
  });

  test("IgnoresMessagesOfEarlierStreams", async () => {
    const later = new Assembler({ info: dataset(), isosurface: request(), requestId: 2n });
    expect(await played(stream, later)).toEqual([]);
  });

  test("UsesCachedTiles", () => {
    const tiles = (stream[0].value as { tiles: unknown[] }).tiles;
    const keys = (newAssembler().receive(stream[0])[0] as AssemblerEffect & { kind: "begun" }).tiles;
    const assembler = newAssembler(keys.slice(1).map(({ key }) => key));
    const [begun] = assembler.receive(stream[0]);
    expect(begun).toMatchObject({ kind: "begun", missing: 1 });
    expect(tiles.length).toBe(5);
  });
});
