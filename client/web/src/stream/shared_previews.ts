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
  type Preview,
  type ServerKind,
  StepPolicy,
  StreamEndSchema,
  StreamOutcome,
} from "../protocol/messages";
import { coarsePreview } from "./coarse_preview";
import { type ConnectionUser, ServerConnection } from "./server_connection";
import type { StreamRequest } from "./stream_request";

export interface PreviewClient {
  received: (message: ServerKind) => void; // A message of the stream sharedRequestId, whose only step has the number 0.
  requestAlone: () => void; // Called if its preview cannot be received here.
}

interface PreviewRequest {
  client: PreviewClient;
  request: StreamRequest;
  preview: Preview;
  key: string; // Equal for previews that fit into one request.
}

interface Group {
  preview: Preview;
  requests: (PreviewRequest | null)[]; // By step; null: received or cancelled.
}

export const sharedRequestId = 1n;
const maxPerStream = 1024; // The server's limit of datasets per request.

// Returns the request for a shared stream: without normals, because sample shells have none. Null: it cannot be shared.
export function shareableRequest(request: StreamRequest): StreamRequest | null {
  if (request.steps !== "coarse" || request.scalars || !coarsePreview(request.info)) return null;
  return { ...request, isosurface: create(IsosurfaceRequestSchema, { ...request.isosurface, normals: 0 }) };
}

export class SharedPreviews implements ConnectionUser {
  private readonly connection: ServerConnection;
  private requestId = 0n; // Of the running stream.
  private queued = new Map<PreviewClient, PreviewRequest>(); // Not requested yet.
  private running: Group | null = null;

  constructor(address: string, token: () => string) {
    this.connection = new ServerConnection(address, token, "previews");
  }

  // Replaces the client's earlier request. Requires a request from shareableRequest().
  request(client: PreviewClient, request: StreamRequest): void {
    this.cancel(client);
    if (this.queued.size === 0) queueMicrotask(() => this.sendNext());
    const preview = coarsePreview(request.info, true)!;
    const key = `${preview.finestSpacing} ${toBinary(IsosurfaceRequestSchema, request.isosurface).join()}`;
    this.queued.set(client, { client, request, preview, key });
  }

  cancel(client: PreviewClient): void {
    this.queued.delete(client);
    const { running } = this;
    if (!running) return;
    const at = running.requests.findIndex((request) => request?.client === client);
    if (at < 0) return;
    running.requests[at] = null;
    if (running.requests.some((request) => request !== null)) return;
    this.connection.send({ case: "cancel", value: create(CancelSchema, { requestId: this.requestId }) });
    this.running = null;
    this.sendNext();
  }

  close(): void {
    this.queued.clear();
    this.running = null;
    this.connection.use(null);
    this.connection.close();
  }

  // ----

  // Without permission for samples there are no shells.
  ready(): void {
    if (this.connection.state.get().permitsSamples) this.sendNext();
    else this.lost();
  }

  // Clients without a preview request it themselves.
  lost(): void {
    const all = [...(this.running?.requests ?? []), ...this.queued.values()];
    this.close();
    for (const request of all) request?.client.requestAlone();
  }

  private sendNext(): void {
    if (this.running || this.queued.size === 0) return;
    if (this.connection.isReady) this.open();
    else if (this.connection.isFree) this.connection.use(this);
  }

  private open(): void {
    const group = (this.running = this.nextGroup());
    this.requestId = this.connection.nextRequestId();
    const [first, ...others] = group.requests.map((request) => request!.request);
    const value = create(OpenStreamSchema, {
      requestId: this.requestId,
      dataset: first.info.name,
      furtherDatasets: others.map(({ info }) => info.name),
      request: first.isosurface,
      steps: StepPolicy.PREVIEWS_ONLY,
      resumedPreviews: [group.preview],
      use: MeshUse.DISPLAY,
    });
    this.connection.send({ case: "openStream", value });
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

  received(message: ServerKind): void {
    if (!message.value || !("requestId" in message.value) || message.value.requestId !== this.requestId) return;
    if (message.case === "stepBegin" || message.case === "tile" || message.case === "stepEnd") this.forward(message);
    else if (message.case === "streamEnd" || message.case === "error") this.endGroup();
  }

  private forward(message: Extract<ServerKind, { case: "stepBegin" | "tile" | "stepEnd" }>): void {
    const { running } = this;
    const request = running?.requests[message.value.step];
    if (!running || !request) return;
    const own = { requestId: sharedRequestId, step: 0 };
    request.client.received({ case: message.case, value: { ...message.value, ...own } } as ServerKind);
    if (message.case !== "stepEnd") return;
    running.requests[message.value.step] = null;
    const end = create(StreamEndSchema, { requestId: sharedRequestId, outcome: StreamOutcome.COMPLETE, steps: 1 });
    request.client.received({ case: "streamEnd", value: end });
  }

  private endGroup(): void {
    const { running } = this;
    this.running = null;
    for (const request of running?.requests ?? []) request?.client.requestAlone();
    this.sendNext();
  }
}
