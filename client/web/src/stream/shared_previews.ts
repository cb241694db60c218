// Requests one preview each of many surfaces in shared streams, so that a thousand labels need no thousand requests.
// The streams run one after another on a connection of their own, the coarsest previews (of the largest labels) first.
// Each surface receives its messages as if it had a stream of its own. Surfaces whose preview cannot be received here
// request it themselves.
import { toBinary } from "@bufbuild/protobuf";

import {
  CancelSchema,
  create,
  IsosurfaceRequestSchema,
  MeshUse,
  OpenStreamSchema,
  PayloadCodec,
  type Preview,
  type ServerKind,
  StepPolicy,
  StreamEndSchema,
  StreamOutcome,
} from "../protocol/messages";
import { coarsePreview } from "./coarse_preview";
import { helloFrom } from "./hello";
import { Link } from "./link";
import type { StreamRequest } from "./stream_request";

export interface PreviewClient {
  receive: (message: ServerKind) => void; // Receives a message of the client's stream, whose only step has the number 0.
  requestAlone: () => void; // Called if its preview cannot be received here.
}

interface PreviewRequest {
  client: PreviewClient;
  request: StreamRequest;
  requestId: bigint; // The client's.
  preview: Preview;
  key: string; // Equal for previews that fit into one request.
}

interface Group {
  preview: Preview;
  requests: (PreviewRequest | null)[]; // By step; null: received or cancelled.
}

const maxPerStream = 1024; // The server's limit of datasets per request.

// Returns the request for a shared stream: without normals, because sample shells have none. Null: it cannot be shared.
export function shareableRequest(request: StreamRequest): StreamRequest | null {
  if (request.steps !== "coarse" || request.scalars || !coarsePreview(request.info)) return null;
  return { ...request, isosurface: create(IsosurfaceRequestSchema, { ...request.isosurface, normals: 0 }) };
}

export class SharedPreviews {
  private readonly link: Link;
  private isReady = false;
  private isConnecting = false;
  private lastRequestId = 0n;
  private queued = new Map<PreviewClient, PreviewRequest>(); // Not requested yet.
  private running: Group | null = null;

  constructor(
    address: string,
    private readonly token: () => string,
  ) {
    this.link = new Link(address, {
      opened: () => this.sendHello(),
      received: (message) => this.receive(message),
      closed: () => this.leaveAllToClients(),
      blocked: () => this.leaveAllToClients(),
    });
  }

  // Replaces the client's earlier request. Requires a request from shareableRequest().
  request(client: PreviewClient, request: StreamRequest, requestId: bigint): void {
    this.cancel(client);
    if (this.queued.size === 0) queueMicrotask(() => this.sendNext());
    const preview = coarsePreview(request.info, true)!;
    const key = `${preview.finestSpacing} ${toBinary(IsosurfaceRequestSchema, request.isosurface).join()}`;
    this.queued.set(client, { client, request, requestId, preview, key });
  }

  cancel(client: PreviewClient): void {
    this.queued.delete(client);
    const { running } = this;
    if (!running) return;
    const at = running.requests.findIndex((request) => request?.client === client);
    if (at < 0) return;
    running.requests[at] = null;
    if (running.requests.some((request) => request !== null)) return;
    this.link.send({ case: "cancel", value: create(CancelSchema, { requestId: this.lastRequestId }) });
    this.running = null;
    this.sendNext();
  }

  close(): void {
    this.queued.clear();
    this.running = null;
    this.link.close();
  }

  // ----

  private sendHello(): void {
    this.lastRequestId = 0n;
    this.link.send({ case: "hello", value: helloFrom("previews", this.token()) });
  }

  private sendNext(): void {
    if (this.running || this.queued.size === 0) return;
    if (this.isReady) return this.open();
    if (this.isConnecting) return;
    this.isConnecting = true;
    this.link.connect();
  }

  private open(): void {
    const group = (this.running = this.nextGroup());
    const [first, ...others] = group.requests.map((request) => request!.request);
    const value = create(OpenStreamSchema, {
      requestId: ++this.lastRequestId,
      dataset: first.info.name,
      furtherDatasets: others.map(({ info }) => info.name),
      request: first.isosurface,
      steps: StepPolicy.PREVIEWS_ONLY,
      resumedPreviews: [group.preview],
      use: MeshUse.DISPLAY,
    });
    this.link.send({ case: "openStream", value });
  }

  private nextGroup(): Group {
    const groups = new Map<string, Group>();
    for (const request of this.queued.values()) {
      const group = groups.get(request.key) ?? { preview: request.preview, requests: [] };
      groups.set(request.key, group);
      if (group.requests.length < maxPerStream) group.requests.push(request);
    }
    const next = [...groups.values()].reduce((best, one) => (one.preview.finestSpacing > best.preview.finestSpacing ? one : best));
    for (const request of next.requests) this.queued.delete(request!.client);
    return next;
  }

  private receive(message: ServerKind): void {
    switch (message.case) {
      case "welcome":
        this.isReady = message.value.codecs.includes(PayloadCodec.SAMPLE_SHELL);
        if (this.isReady) return this.sendNext();
        this.link.close(); // Without permission for samples there are no shells.
        return this.leaveAllToClients();
      case "stepBegin":
      case "tile":
      case "stepEnd":
        if (message.value.requestId === this.lastRequestId) this.forward(message);
        return;
      case "streamEnd":
        if (message.value.requestId === this.lastRequestId) this.endGroup();
        return;
      case "error":
        if (message.value.requestId === this.lastRequestId) return this.endGroup();
        if (message.value.requestId !== 0n) return;
        this.link.close();
        return this.leaveAllToClients();
    }
  }

  private forward(message: Extract<ServerKind, { case: "stepBegin" | "tile" | "stepEnd" }>): void {
    const { running } = this;
    const request = running?.requests[message.value.step];
    if (!running || !request) return;
    const own = { requestId: request.requestId, step: 0 };
    request.client.receive({ case: message.case, value: { ...message.value, ...own } } as ServerKind);
    if (message.case !== "stepEnd") return;
    running.requests[message.value.step] = null;
    const end = create(StreamEndSchema, { requestId: request.requestId, outcome: StreamOutcome.COMPLETE, steps: 1 });
    request.client.receive({ case: "streamEnd", value: end });
  }

  // Clients without a preview request it themselves.
  private endGroup(): void {
    const { running } = this;
    this.running = null;
    for (const request of running?.requests ?? []) request?.client.requestAlone();
    this.sendNext();
  }

  private leaveAllToClients(): void {
    this.isReady = this.isConnecting = false;
    const all = [...(this.running?.requests ?? []), ...this.queued.values()];
    this.running = null;
    this.queued.clear();
    for (const request of all) request?.client.requestAlone();
  }
}
