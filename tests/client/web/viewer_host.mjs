// A running server that serves the viewer's page.
import { spawn } from "node:child_process";

export class Server {
  constructor(program, datasets, viewer, options = []) {
    this.program = program;
    this.words = ["serve", datasets, "--viewer", viewer, ...options];
    this.port = 0;
  }

  // Starts the server; a restart uses the same port.
  async start() {
    const listeners = ["--tcp", "tcp://127.0.0.1:0", "--http", `http://127.0.0.1:${this.port}`];
    this.process = spawn(this.program, [...this.words, ...listeners], { stdio: ["ignore", "pipe", "pipe"] });
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

  // SIGTERM lets the server close its connections properly, SIGKILL does not.
  async stop(signal = "SIGTERM") {
    const { process } = this;
    if (!process || process.exitCode !== null || process.signalCode !== null) return;
    const ended = new Promise((resolve) => process.on("exit", resolve));
    process.kill(signal);
    await ended;
  }

  // The page's address.
  get page() {
    return `http://127.0.0.1:${this.port}/`;
  }
}
