// One preview each of many surfaces, in streams that they share: of a thousand labels not each has to be requested. The
// streams run one after another on a connection of their own, those of the coarsest previews, which are of the largest
// labels, first. Each surface gets its part as the messages of a stream of its own. What does not come here, for whatever
// reason, the surfaces request by themselves.
import { toBinary } from "@bufbuild/protobuf";

import {
  CancelSchema, create, HelloSchema, IsosurfaceRequestSchema, MeshUse, OpenStreamSchema, PayloadCodec, type Preview, type ServerKind,
  StepPolicy, StreamEndSchema, StreamOutcome,
} from "../protocol/messages";
import { coarsePreview } from "./coarse_preview";
import type { StreamRequest } from "./conversation";
import { Link } from "./link";

export interface PreviewClient {
  receive: (message: ServerKind) => void; // Of its stream, whose only step has the number 0.
  requestAlone: () => void; // Its preview does not come here.
}

interface Wish {
  client: PreviewClient;
  order: StreamRequest;
  requestId: bigint; // The client's.
  preview: Preview;
  key: string; // The same for all that can be in one request.
}

interface Group {
  preview: Preview;
  wishes: (Wish | null)[]; // By step; null: not wanted any more.
}

const mostTogether = 1024; // Datasets that a server takes in one request.

// As it is requested here: sample shells have no normals. Null: it cannot be.
export function sharedOrderOf(order: StreamRequest): StreamRequest | null {
  if (order.steps !== "coarse" || order.scalars || !coarsePreview(order.info)) return null;
  return { ...order, request: create(IsosurfaceRequestSchema, { ...order.request, normals: 0 }) };
}

export class SharedPreviews {
  private readonly link: Link;
  private isReady = false;
  private isConnecting = false;
  private lastRequestId = 0n;
  private wanted = new Map<PreviewClient, Wish>(); // Not requested yet.
  private running: Group | null = null;

  constructor(address: string, private readonly token: () => string) {
    this.link = new Link(address, {
      opened: () => this.greet(),
      received: (message) => this.receive(message),
      closed: () => this.giveUp(),
      impossible: () => this.giveUp(),
    });
  }

  // Replaces what the client wanted before. Requires an order of sharedOrderOf().
  want(client: PreviewClient, order: StreamRequest, requestId: bigint): void {
    this.leave(client);
    if (this.wanted.size === 0) queueMicrotask(() => this.goOn());
    const preview = coarsePreview(order.info, true)!;
    const key = `${preview.finestSpacing} ${toBinary(IsosurfaceRequestSchema, order.request).join()}`;
    this.wanted.set(client, { client, order, requestId, preview, key });
  }

  leave(client: PreviewClient): void {
    this.wanted.delete(client);
    const { running } = this;
    if (!running) return;
    const at = running.wishes.findIndex((wish) => wish?.client === client);
    if (at < 0) return;
    running.wishes[at] = null;
    if (running.wishes.some((wish) => wish !== null)) return;
    this.link.send({ case: "cancel", value: create(CancelSchema, { requestId: this.lastRequestId }) });
    this.running = null;
    this.goOn();
  }

  close(): void {
    this.wanted.clear();
    this.running = null;
    this.link.leave();
  }

  // ----

  private greet(): void {
    const codecs = [PayloadCodec.SAMPLE_SHELL, PayloadCodec.DRACO_LATTICE];
    const value = create(HelloSchema, { minVersion: 1, maxVersion: 1, codecs, token: this.token(), agent: "multitetra-viewer/0.1 previews" });
    this.lastRequestId = 0n;
    this.link.send({ case: "hello", value });
  }

  private goOn(): void {
    if (this.running || this.wanted.size === 0) return;
    if (this.isReady) return this.open();
    if (this.isConnecting) return;
    this.isConnecting = true;
    this.link.connect();
  }

  private open(): void {
    const group = (this.running = this.nextGroup());
    const [first, ...others] = group.wishes.map((wish) => wish!.order);
    const value = create(OpenStreamSchema, {
      requestId: ++this.lastRequestId, dataset: first.info.name, furtherDatasets: others.map(({ info }) => info.name), request: first.request,
      steps: StepPolicy.PREVIEWS_ONLY, resumedPreviews: [group.preview], use: MeshUse.DISPLAY,
    });
    this.link.send({ case: "openStream", value });
  }

  private nextGroup(): Group {
    const groups = new Map<string, Group>();
    for (const wish of this.wanted.values()) {
      const group = groups.get(wish.key) ?? { preview: wish.preview, wishes: [] };
      groups.set(wish.key, group);
      if (group.wishes.length < mostTogether) group.wishes.push(wish);
    }
    const next = [...groups.values()].reduce((best, one) => (one.preview.finestSpacing > best.preview.finestSpacing ? one : best));
    for (const wish of next.wishes) this.wanted.delete(wish!.client);
    return next;
  }

  private receive(message: ServerKind): void {
    switch (message.case) {
      case "welcome":
        this.isReady = message.value.codecs.includes(PayloadCodec.SAMPLE_SHELL);
        if (this.isReady) return this.goOn();
        this.link.leave(); // Without the right to samples there are no shells.
        return this.giveUp();
      case "stepBegin":
      case "tile":
      case "stepEnd":
        if (message.value.requestId === this.lastRequestId) this.pass(message);
        return;
      case "streamEnd":
        if (message.value.requestId === this.lastRequestId) this.endGroup();
        return;
      case "error":
        if (message.value.requestId === this.lastRequestId) return this.endGroup();
        if (message.value.requestId !== 0n) return;
        this.link.leave();
        return this.giveUp();
    }
  }

  private pass(message: Extract<ServerKind, { case: "stepBegin" | "tile" | "stepEnd" }>): void {
    const { running } = this;
    const wish = running?.wishes[message.value.step];
    if (!running || !wish) return;
    const own = { requestId: wish.requestId, step: 0 };
    wish.client.receive({ case: message.case, value: { ...message.value, ...own } } as ServerKind);
    if (message.case !== "stepEnd") return;
    running.wishes[message.value.step] = null;
    const end = create(StreamEndSchema, { requestId: wish.requestId, outcome: StreamOutcome.COMPLETE, steps: 1 });
    wish.client.receive({ case: "streamEnd", value: end });
  }

  // Those whose preview has not come request it alone.
  private endGroup(): void {
    const { running } = this;
    this.running = null;
    for (const wish of running?.wishes ?? []) wish?.client.requestAlone();
    this.goOn();
  }

  private giveUp(): void {
    this.isReady = this.isConnecting = false;
    const all = [...(this.running?.wishes ?? []), ...this.wanted.values()];
    this.running = null;
    this.wanted.clear();
    for (const wish of all) wish?.client.requestAlone();
  }
}
