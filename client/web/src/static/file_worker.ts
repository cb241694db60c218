// Answers the links of a page from files: one conversation a port.
import shellWasm from "../../../../common/codec/wasm/shell_decoder.wasm?url";
import { payloadHasher } from "../mesh/content_digest";
import { surfaceCounter } from "../mesh/plain_box";
import { decodedRequest, encodedReply, type ServerKind } from "../protocol/messages";
import type { ChannelRequest, FirstRead } from "./file_channel";
import { FileConversation } from "./file_conversation";
import { PageDatasets } from "./page_datasets";
import type { Tools } from "./surface_level";

const datasets = new Map<string, PageDatasets>(); // By address.
const tools = madeTools();

async function madeTools(): Promise<Tools> {
  const wasm = await fetch(shellWasm).then((reply) => reply.arrayBuffer());
  return { count: await surfaceCounter(wasm), hash: await payloadHasher() };
}

function datasetsAt(address: string): PageDatasets {
  const found = datasets.get(address) ?? new PageDatasets(address);
  datasets.set(address, found);
  return found;
}

const first = JSON.parse(self.name) as FirstRead;
datasetsAt(first.address).openEarly(first.dataset);

self.onmessage = ({ data: { address, port } }: MessageEvent<ChannelRequest>) => {
  const send = (message: ServerKind) => {
    const bytes = encodedReply(message);
    port.postMessage(bytes.buffer, [bytes.buffer]);
  };
  const conversation = new FileConversation(datasetsAt(address), tools, send, (share) => port.postMessage(share));
  port.onmessage = ({ data }: MessageEvent<ArrayBuffer | null>) => {
    if (data) return void conversation.receive(decodedRequest(new Uint8Array(data)));
    conversation.close();
    port.close();
  };
};
