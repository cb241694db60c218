// Assembles server messages into complete, checked steps; the counterpart of client/library/assembler.hpp. Pure: work
// done elsewhere (decoding, checking a step) is returned as an effect, and its result is passed to a method.
//
// A step is shown only after all its tiles are decoded and its checks have passed; until then the previous step stays.
// Steps end in the request in which they began. After a failed check the assembler returns no more effects.

import { isSound, type MeshTopology } from "../mesh/boundary_matcher";
import { type ContentDigest, emptyDigest, fromHex, hex, sum } from "../mesh/content_digest";
import { cubeName, type ManifestTile } from "../mesh/tile_mesh";
import { type DatasetInfo, type IsosurfaceRequest, type ServerKind, type StepBegin, type StepEnd, StreamOutcome } from "../protocol/messages";
import { manifestFault, manifestTile, parameterFault, preservesTopology } from "./step_checks";

export interface ExpectedStream {
  info: DatasetInfo;
  isosurface: IsosurfaceRequest; // Every field is set explicitly.
  requestId: bigint;
  isPreviewsOnly?: boolean; // The stream may end before the final step.
}

export interface StepOfTiles {
  begin: StepBegin;
  end: StepEnd;
  tiles: ManifestTile[];
  digest: ContentDigest; // The digest of all triangles, computed here.
  cached: number; // Cached tiles, which were not sent.
}

export type AssemblerEffect =
  | { kind: "begun"; begin: StepBegin; tiles: ManifestTile[]; missing: number }
  | { kind: "decode"; tile: ManifestTile; payload: Uint8Array; begin: StepBegin }
  | { kind: "check"; step: StepOfTiles }
  // `sameAs`: the earlier step that it was compared with, if its topology had to be the same.
  | { kind: "committed"; step: StepOfTiles; topology: MeshTopology; sameAs: number | null }
  | { kind: "ended"; outcome: StreamOutcome }
  | { kind: "refused"; code: number; text: string; retryAfter: number } // Seconds; 0: unknown.
  | { kind: "failed"; text: string };

interface Pending {
  begin: StepBegin;
  tiles: ManifestTile[];
  cached: number;
  received: Set<number>;
  bytes: number;
  end: StepEnd | null;
  checking: StepOfTiles | null;
}

const maxSteps = 64;

export class Assembler {
  private readonly pending: Pending[] = [];
  private steps = 0; // Number of steps begun.
  private finalHasBegun = false;
  private streamEnd: AssemblerEffect | null = null; // Follows the complete steps.
  private isOver = false;
  private readonly missing = new Map<number, Set<string>>(); // Missing tile keys by step.
  private invariants: { step: number; euler: number; components: number } | null = null;
  private readonly announced = new Set<string>();
  private readonly ready: Set<string>;

  // `cached`: keys of cached tiles that were named to the server.
  constructor(
    private readonly request: ExpectedStream,
    cached: Iterable<string> = [],
  ) {
    this.ready = new Set(cached);
  }

  get hasEnded(): boolean {
    return this.isOver;
  }

  // Whether the server has sent everything; received tiles may still be decoded and checked.
  get isReceived(): boolean {
    return this.isOver || this.streamEnd !== null;
  }

  receive(message: ServerKind): AssemblerEffect[] {
    if (this.isOver) return [];
    switch (message.case) {
      case "stepBegin":
        return this.ofThisStream(message.value.requestId, () => this.begin(message.value));
      case "tile": {
        const { requestId, step, index, payload } = message.value;
        return this.ofThisStream(requestId, () => this.tile(step, index, payload));
      }
      case "stepEnd":
        return this.ofThisStream(message.value.requestId, () => this.end(message.value));
      case "streamEnd":
        return this.ofThisStream(message.value.requestId, () => {
          const { outcome, steps } = message.value;
          return this.endOfStream(outcome, steps);
        });
      case "error": {
        const { requestId, code, text, retryAfter } = message.value;
        if (requestId !== this.request.requestId && requestId !== 0n) return [];
        return this.endWith({ kind: "refused", code, text, retryAfter });
      }
      default:
        return [];
    }
  }

  // Called when a tile of a "decode" effect has passed its checks.
  decoded(key: string): AssemblerEffect[] {
    this.ready.add(key);
    return this.advance();
  }

  damaged(text: string): AssemblerEffect[] {
    return this.fail(text);
  }

  // Called with the result of a "check" effect.
  checked(step: number, topology: MeshTopology): AssemblerEffect[] {
    const first = this.pending[0];
    if (this.isOver || !first?.checking || first.begin.step !== step) return [];
    const fault = this.topologyFault(first.begin, topology);
    if (fault) return this.fail(`Step ${step}: ${fault}.`);
    const { checking } = first;
    this.pending.shift();
    const compared = preservesTopology(checking.begin) ? this.invariants!.step : step;
    const sameAs = compared === step ? null : compared;
    return [{ kind: "committed", step: checking, topology, sameAs }, ...this.advance()];
  }

  private ofThisStream(id: bigint, act: () => AssemblerEffect[]): AssemblerEffect[] {
    if (id === this.request.requestId) return act();
    // Messages of an earlier stream may still arrive.
    return id < this.request.requestId ? [] : this.fail("A message belongs to a request that was never made.");
  }

  private fail(text: string): AssemblerEffect[] {
    if (this.isOver) return [];
    this.isOver = true;
    this.pending.length = 0;
    return [{ kind: "failed", text }];
  }

  private begin(begin: StepBegin): AssemblerEffect[] {
    const fault = (what: string) => this.fail(`Step ${begin.step}: ${what}.`);
    const last = this.pending.at(-1);
    if (last && !last.end) return fault("it begins before the previous step has ended");
    if (begin.step !== this.steps) return fault(`step ${this.steps} was due`);
    if (this.finalHasBegun) return fault("it follows the final step");
    if (begin.step >= maxSteps) return fault(`this viewer allows ${maxSteps} steps`);
    const found = parameterFault(begin, this.request.isosurface) ?? manifestFault(begin, this.request.info);
    if (found) return fault(found);
    const tiles = begin.tiles.map(manifestTile);
    const missing = tiles.filter(({ key }) => !this.ready.has(key) && !this.announced.has(key));
    for (const { key } of missing) this.announced.add(key);
    const pending: Pending = {
      begin,
      tiles,
      cached: tiles.length - missing.length,
      received: new Set(),
      bytes: 0,
      end: null,
      checking: null,
    };
    this.pending.push(pending);
    this.missing.set(begin.step, new Set(missing.map(({ key }) => key)));
    ++this.steps;
    this.finalHasBegun = begin.isFinal;
    return [{ kind: "begun", begin, tiles, missing: missing.length }];
  }

  private tile(step: number, index: number, payload: Uint8Array): AssemblerEffect[] {
    const pending = this.pending.at(-1);
    if (!pending || pending.end || pending.begin.step !== step) {
      return this.fail(`Step ${step}: a tile arrived outside of its step.`);
    }
    const tile = pending.tiles[index];
    if (!tile) return this.fail(`Step ${step}: tile ${index} is not in its manifest.`);
    const name = `Step ${step}: tile ${index} (${cubeName(tile.cube)})`;
    if (!this.missing.get(step)!.delete(tile.key)) {
      return this.fail(`${name} was sent again.`);
    }
    if (payload.length !== tile.bytes) {
      return this.fail(`${name} has ${payload.length} bytes; the manifest lists ${tile.bytes}.`);
    }
    pending.received.add(index);
    pending.bytes += payload.length;
    return [{ kind: "decode", tile, payload, begin: pending.begin }];
  }

  private end(end: StepEnd): AssemblerEffect[] {
    const fault = (what: string) => this.fail(`Step ${end.step}: ${what}.`);
    const pending = this.pending.at(-1);
    if (!pending || pending.end || pending.begin.step !== end.step) {
      return fault("it ends without having begun");
    }
    const missing = this.missing.get(end.step)!.size;
    if (missing > 0) return fault(`it ends with ${missing} of its tiles missing`);
    if (end.tilesSent !== pending.received.size || end.payloadBytes !== BigInt(pending.bytes)) {
      return fault(`the server counts ${end.tilesSent} tiles and ${end.payloadBytes} bytes; ` + `${pending.received.size} and ${pending.bytes} came`);
    }
    pending.end = end;
    return this.advance();
  }

  private endOfStream(outcome: StreamOutcome, steps: number): AssemblerEffect[] {
    if (this.streamEnd) return this.fail("The end of the stream was sent twice.");
    if (steps !== this.steps && outcome === StreamOutcome.COMPLETE) {
      return this.fail(`The server counts ${steps} steps; ${this.steps} were received.`);
    }
    if (outcome === StreamOutcome.COMPLETE && !this.finalHasBegun && !(this.request.isPreviewsOnly && this.steps > 0)) {
      return this.fail("The server ended the stream as complete, but the final step is missing.");
    }
    return this.endWith({ kind: "ended", outcome });
  }

  private endWith(end: AssemblerEffect): AssemblerEffect[] {
    this.streamEnd = end;
    // An interrupted step will never be complete.
    if (this.pending.at(-1) && !this.pending.at(-1)!.end) this.pending.pop();
    return this.advance();
  }

  // Continues with the oldest waiting step, or returns the end.
  private advance(): AssemblerEffect[] {
    if (this.isOver) return [];
    const first = this.pending[0];
    if (!first) {
      if (!this.streamEnd) return [];
      this.isOver = true;
      return [this.streamEnd];
    }
    if (!first.end || first.checking || first.tiles.some(({ key }) => !this.ready.has(key))) {
      return [];
    }
    const digest = first.tiles.reduce((d, { key }) => sum(d, fromHex(key)), emptyDigest);
    if (digest.high !== first.end.digestHigh || digest.low !== first.end.digestLow) {
      const sent = hex({ high: first.end.digestHigh, low: first.end.digestLow });
      return this.fail(`Step ${first.begin.step}: its digest is ${hex(digest)}; the server sent ${sent}.`);
    }
    const { begin, end, tiles, cached } = first;
    first.checking = { begin, end, tiles, digest, cached };
    return [{ kind: "check", step: first.checking }];
  }

  private topologyFault(begin: StepBegin, found: MeshTopology): string | null {
    if (!isSound(found)) {
      return (
        `the mesh has defects: ${found.openEdges} open edges, ${found.nonmanifoldEdges} ` +
        `non-manifold edges, ${found.degenerateTriangles} degenerate triangles`
      );
    }
    if (!preservesTopology(begin)) return null;
    const first = (this.invariants ??= {
      step: begin.step,
      euler: found.eulerCharacteristic,
      components: found.components,
    });
    if (first.euler === found.eulerCharacteristic && first.components === found.components) {
      return null;
    }
    return (
      `its topology differs from step ${first.step}, though both preserve it: Euler ` +
      `characteristic ${found.eulerCharacteristic} instead of ${first.euler}, ` +
      `${found.components} components instead of ${first.components}`
    );
  }
}
