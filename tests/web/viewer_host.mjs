// A running server with its viewer's page, for tests: the server's own HTTP door where it serves the
// page, else a small host before it that serves the files and passes WebSockets on.
import { spawn } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import http from "node:http";
import net from "node:net";
import path from "node:path";

const types = {
  ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm",
  ".svg": "image/svg+xml", ".txt": "text/plain",
};

export class Server {
  constructor(program, datasets, viewer) {
    this.program = program;
    this.datasets = datasets;
    this.viewer = viewer;
    this.port = 0;
  }

  // A second start takes the port of the first.
  async start() {
    const doors = ["--tcp", "tcp://127.0.0.1:0", "--http", `http://127.0.0.1:${this.port}`];
    this.process = spawn(this.program, ["serve", this.datasets, ...doors], { stdio: ["ignore", "pipe", "pipe"] });
    this.port = await new Promise((resolve, reject) => {
      let said = "";
      const read = (bytes) => {
        said += bytes;
        const port = said.match(/http:\/\/127\.0\.0\.1:(\d+)/);
        if (port) resolve(Number(port[1]));
      };
      this.process.stdout.on("data", read);
      this.process.stderr.on("data", read);
      this.process.on("exit", () => reject(new Error(`The server ended: ${said}`)));
    });
  }

  async stop() {
    const { process } = this;
    if (!process || process.exitCode !== null) return;
    const ended = new Promise((resolve) => process.on("exit", resolve));
    process.kill();
    await ended;
  }

  // The address of the page.
  async page() {
    const own = `http://127.0.0.1:${this.port}/`;
    const answer = await fetch(own).catch(() => null);
    if (answer?.ok && (await answer.text()).includes('id="app"')) return own;
    this.host ??= await host(this);
    return `http://127.0.0.1:${this.host.address().port}/`;
  }

  async close() {
    this.host?.closeAllConnections();
    this.host?.close();
    await this.stop();
  }
}

async function host(server) {
  const listener = http.createServer((request, response) => {
    const name = new URL(request.url, "http://host").pathname;
    const file = path.join(server.viewer, path.normalize(name.endsWith("/") ? `${name}index.html` : name));
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": types[path.extname(file)] ?? "application/octet-stream" });
    response.end(readFileSync(file));
  });
  listener.on("upgrade", (request, socket, head) => {
    const upstream = net.connect(server.port, "127.0.0.1", () => {
      const header = request.rawHeaders.map((word, i) => (i % 2 ? `${word}\r\n` : `${word}: `)).join("");
      upstream.write(`GET ${request.url} HTTP/1.1\r\n${header}\r\n`);
      upstream.write(head);
      upstream.pipe(socket).pipe(upstream);
    });
    upstream.on("error", () => socket.destroy());
    socket.on("error", () => upstream.destroy());
    upstream.on("close", () => socket.destroy());
  });
  await new Promise((resolve) => listener.listen(0, "127.0.0.1", resolve));
  return listener;
}
