// Fetches a surface as a mesh that is simplified as its settings require. The page may show its full resolution instead,
// where the samples of that arrive sooner.
import type { DatasetInfo } from "../protocol/messages";
import { defaults, type Settings } from "../state/settings";
import { toAddress } from "../state/url_state";

// Returns a binary PLY file in world coordinates. Rejects with a reason. `stream`: the address of the server's stream;
// `own`: the settings of this surface.
export async function simplifiedMesh(stream: string, token: string, info: DatasetInfo, isovalue: number, own: Settings): Promise<ArrayBuffer> {
  const reply = await fetch(meshAddress(stream, info, isovalue, own), { headers: token ? { Authorization: `Bearer ${token}` } : {} });
  if (!reply.ok) throw new Error(`the server refused it with status ${reply.status}.`);
  return reply.arrayBuffer();
}

// HTTP queries name the request's settings as the page's address does.
export function meshAddress(stream: string, { name }: DatasetInfo, isovalue: number, own: Settings): string {
  const { error, bound, topologyRule, topologyTolerance, region, maxTriangles, minComponent } = own;
  const address = new URL(`datasets/${encodeURIComponent(name)}/isosurface`, stream.replace(/^ws/, "http"));
  address.search = toAddress({ ...defaults, isovalue, error, bound, topologyRule, topologyTolerance, region, maxTriangles, minComponent });
  address.searchParams.set("format", "ply");
  return address.href;
}
