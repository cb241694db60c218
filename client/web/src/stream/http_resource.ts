// Resources of the server that answers the stream: their paths stand beside it.
export function resourceAddress(stream: string, path: string): URL {
  return new URL(path, stream.replace(/^ws/, "http"));
}

// Rejects with a TypeError only if there is no reply.
export function fetchResource(address: string, token: string): Promise<Response> {
  return fetch(address, { headers: token ? { Authorization: `Bearer ${token}` } : {} });
}
