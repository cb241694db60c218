// Encodes and decodes the messages of the conversation. The only module that depends on their encoding, which
// proto/README.md documents.
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";

import { type ClientMessage, ClientMessageSchema, type ServerMessage, ServerMessageSchema } from "./generated/multitetra/v1/conversation_pb";

export { create } from "@bufbuild/protobuf";
export * from "./generated/multitetra/v1/conversation_pb";
export * from "./generated/multitetra/v1/dataset_pb";
export * from "./generated/multitetra/v1/request_pb";

export type ServerKind = ServerMessage["kind"];
export type ClientKind = ClientMessage["kind"];

export function encoded(kind: ClientKind): Uint8Array {
  return toBinary(ClientMessageSchema, create(ClientMessageSchema, { kind }));
}

// Throws if the bytes are not a message.
export function decoded(bytes: Uint8Array): ServerKind {
  return fromBinary(ServerMessageSchema, bytes).kind;
}

// The other end's, where a page answers itself.
export function decodedRequest(bytes: Uint8Array): ClientKind {
  return fromBinary(ClientMessageSchema, bytes).kind;
}

export function encodedReply(kind: ServerKind): Uint8Array<ArrayBuffer> {
  return toBinary(ServerMessageSchema, create(ServerMessageSchema, { kind })) as Uint8Array<ArrayBuffer>;
}
