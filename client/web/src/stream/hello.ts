// The first message of a connection.
import { create, type Hello, HelloSchema, PayloadCodec } from "../protocol/messages";

const protocolVersion = 1;
const viewer = "multitetra-viewer/0.1"; // The version is that of package.json.

// `part` names a part of the viewer in the server's log; empty: the surfaces.
export function helloFrom(part: string, token: string, takesShells = true): Hello {
  const codecs = [...(takesShells ? [PayloadCodec.SAMPLE_SHELL] : []), PayloadCodec.DRACO_LATTICE];
  return create(HelloSchema, {
    minVersion: protocolVersion,
    maxVersion: protocolVersion,
    codecs,
    token,
    agent: part ? `${viewer} ${part}` : viewer,
  });
}
