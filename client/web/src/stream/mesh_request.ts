// Fetches a surface as a file of the server, as its settings require. The page may show its full resolution instead, where
// the samples of that arrive sooner.
import type { MeshFormat } from "../mesh/mesh_file";
import type { DatasetInfo } from "../protocol/messages";
import { writtenDefaults } from "../state/settings";
import type { OwnSettings } from "../state/surfaces";
import { addressOf } from "../state/url_state";
import { fetchResource, resourceAddress } from "./http_resource";

export interface MeshReply {
  file: Uint8Array;
  triangles: number | null; // Null: unknown.
}

// In world coordinates. Rejects with a reason. `stream`: the address of the server's stream; `own`: the settings of this surface.
export async function requestMesh(
  stream: string,
  token: string,
  info: DatasetInfo,
  isovalue: number,
  own: OwnSettings,
  format: MeshFormat,
): Promise<MeshReply> {
  const reply = await fetchResource(meshAddress(stream, info, isovalue, own, format), token);
  if (!reply.ok) {
    const { error } = (await reply.json().catch(() => ({}))) as { error?: { text?: string } };
    throw new Error(error?.text ?? `The server refused it with status ${reply.status}.`);
  }
  const triangles = reply.headers.get("Multitetra-Triangles");
  return { file: new Uint8Array(await reply.arrayBuffer()), triangles: triangles === null ? null : Number(triangles) };
}

// HTTP queries name the request's settings as the page's address does.
export function meshAddress(stream: string, { name }: DatasetInfo, isovalue: number, own: OwnSettings, format: MeshFormat): string {
  const { error, bound, topologyRule, topologyTolerance, region, maxTriangles, minComponent, simplify } = own;
  const address = resourceAddress(stream, `datasets/${encodeURIComponent(name)}/isosurface`);
  address.search = addressOf({ ...writtenDefaults, isovalue, error, bound, topologyRule, topologyTolerance, region, maxTriangles, minComponent, simplify });
  address.searchParams.set("format", format);
  return address.href;
}
