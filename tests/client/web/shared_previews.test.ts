import {
  create,
  type DatasetInfo,
  ErrorReplySchema,
  type OpenStream,
  PayloadCodec,
  SeriesMemberSchema,
  type ServerKind,
  StepBeginSchema,
  StepEndSchema,
  StepPolicy,
  StreamEndSchema,
  TileSchema,
  WelcomeSchema,
} from "../../../client/web/src/protocol/messages";
import { writtenDefaults } from "../../../client/web/src/state/settings";
import { isosurfaceRequest } from "../../../client/web/src/stream/request";
import { SharedPreviews, sharedRequestId } from "../../../client/web/src/stream/shared_previews";
import { plain } from "./made_datasets";
import { link } from "./mocked_link";

vi.mock("../../../client/web/src/stream/link", () => import("./mocked_link"));

function labelOf(value: number, side: number): DatasetInfo {
  const box = [0, 0, 0, side - 1, side - 1, side - 1];
  return { ...plain(`cells.label${value}`), member: create(SeriesMemberSchema, { series: "cells", label: { value, box } }) };
}

// A surface that requests the preview of a label, and the messages that it received.
function surfaceOf(previews: SharedPreviews, value: number, side: number) {
  const received: string[] = [];
  const client = {
    received: ({ case: kind, value: message }: ServerKind) => {
      const { requestId, step = 0 } = message as { requestId: bigint; step?: number };
      received.push(`${kind} ${requestId} ${step}`);
    },
    requestAlone: () => void received.push("alone"),
  };
  const info = labelOf(value, side);
  const isosurface = isosurfaceRequest(info, { ...writtenDefaults, isovalue: 0.5, shading: "facets" }, null);
  previews.request(client, { info, isosurface, steps: "coarse" });
  return { client, received };
}

const openStreams = () => link.sent.filter(({ case: kind }) => kind === "openStream").map(({ value }) => value as OpenStream);
const welcome = (codecs = [PayloadCodec.DRACO_LATTICE, PayloadCodec.SAMPLE_SHELL]): ServerKind => ({
  case: "welcome",
  value: create(WelcomeSchema, { version: 1, codecs }),
});
const send = (...messages: ServerKind[]) => messages.forEach((message) => link.all.at(-1)!.received(message));
const stepOf = (requestId: bigint, step: number): ServerKind[] => [
  { case: "stepBegin", value: create(StepBeginSchema, { requestId, step }) },
  { case: "tile", value: create(TileSchema, { requestId, step }) },
  { case: "stepEnd", value: create(StepEndSchema, { requestId, step }) },
];
const endOf = (requestId: bigint): ServerKind => ({ case: "streamEnd", value: create(StreamEndSchema, { requestId, outcome: 1 }) });

// Two labels of 16 samples a side and one of 40, requested.
async function three() {
  link.sent.length = 0;
  const previews = new SharedPreviews("ws://server/v1/stream", () => "token");
  const all = [surfaceOf(previews, 1, 16), surfaceOf(previews, 2, 40), surfaceOf(previews, 3, 16)];
  await Promise.resolve();
  link.all.at(-1)!.opened();
  send(welcome());
  return { previews, all };
}

describe("SharedPreviews", () => {
  test("AreGroupedBySpacingLargestFirst", async () => {
    const { all } = await three();
    expect(openStreams()).toMatchObject([{ requestId: 1n, dataset: "cells.label2", furtherDatasets: [], steps: StepPolicy.PREVIEWS_ONLY }]);
    send(...stepOf(1n, 0), endOf(1n));
    expect(openStreams()[1]).toMatchObject({
      requestId: 2n,
      dataset: "cells.label1",
      furtherDatasets: ["cells.label3"],
      resumedPreviews: [{ finestSpacing: 4, shell: { levelsPerOctave: 2 } }],
    });
    send(...stepOf(2n, 0), ...stepOf(2n, 1), endOf(2n));
    for (const { received } of all) expect(received).toEqual(["stepBegin", "tile", "stepEnd", "streamEnd"].map((kind) => `${kind} ${sharedRequestId} 0`));
  });

  test("RefusedPreviewsAreRequestedAlone", async () => {
    const { all } = await three();
    send(...stepOf(1n, 0), endOf(1n), ...stepOf(2n, 0));
    send({ case: "error", value: create(ErrorReplySchema, { requestId: 2n, text: "It is damaged." }) });
    expect(all[0].received).toHaveLength(4);
    expect(all[2].received).toEqual(["alone"]);
  });

  test("LetClientsRequestAloneWithoutConnectionOrShells", async () => {
    const { all } = await three();
    link.all.at(-1)!.closed();
    expect(all.map(({ received }) => received)).toEqual([["alone"], ["alone"], ["alone"]]);
    const previews = new SharedPreviews("ws://server/v1/stream", () => "");
    const { received } = surfaceOf(previews, 1, 16);
    await Promise.resolve();
    link.all.at(-1)!.opened();
    send(welcome([PayloadCodec.DRACO_LATTICE]));
    expect(received).toEqual(["alone"]);
  });

  test("CancelStreamsThatNoClientNeeds", async () => {
    const { previews, all } = await three();
    send(...stepOf(1n, 0), endOf(1n));
    previews.cancel(all[0].client);
    send(...stepOf(2n, 0));
    expect(all[0].received).toEqual([]);
    previews.cancel(all[2].client);
    expect(link.sent.at(-1)).toMatchObject({ case: "cancel", value: { requestId: 2n } });
    const attempts = link.attempts;
    surfaceOf(previews, 4, 16);
    await Promise.resolve();
    expect(openStreams().at(-1)).toMatchObject({ requestId: 3n, dataset: "cells.label4" });
    expect(link.attempts).toBe(attempts);
  });
});
