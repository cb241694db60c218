// A browser's WebSocket, from the listener's own page and from a page of another origin.
//
//   node browser.mjs TOKEN HTTPS-URL...
import assert from "node:assert/strict";
import { createServer } from "node:http";
import { createRequire } from "node:module";

const installed = createRequire(new URL("../../client/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");
const [token, ...listeners] = process.argv.slice(2);

const elsewhere = createServer((_, response) => {
  response.setHeader("Content-Type", "text/html");
  response.end("<!doctype html><title>Elsewhere</title>");
});
await new Promise((ready) => elsewhere.listen(0, "127.0.0.1", ready));
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM,
  args: ["--no-sandbox", "--ignore-certificate-errors"],
});
try {
  const page = await browser.newPage({ ignoreHTTPSErrors: true });
  for (const listener of listeners) {
    const stream = `${listener.replace("https:", "wss:")}/v1/stream`;
    await page.goto(`${listener}/v1/openapi.json`);
    const kinds = await page.evaluate(converse, { stream, token });
    assert.equal(kinds[0], 1, `${listener}: Welcome is the first message`);
    assert.deepEqual(kinds.slice(1), [8], `${listener}: then a Pong`);
    const status = await page.evaluate(
      async ({ token }) => (await fetch("/v1/datasets", { headers: { Authorization: `Bearer ${token}` } })).status,
      { token },
    );
    assert.equal(status, 200, `${listener}: its own page may ask over HTTP`);

    await page.goto(`http://127.0.0.1:${elsewhere.address().port}/`);
    assert.deepEqual(await page.evaluate(converse, { stream, token }), [], `${listener}: another origin's page is refused`);
    const answer = await page.evaluate(
      (listener) => fetch(`${listener}/v1/openapi.json`).then((a) => a.status, () => "refused"),
      listener,
    );
    assert.equal(answer, "refused", `${listener}: another origin's page may not read`);
  }
} finally {
  await browser.close();
  elsewhere.close();
}

// Runs in the page. Returns the kinds of the messages that answer Hello and Ping, by field number; none if the
// connection is rejected.
function converse({ stream, token }) {
  const text = new TextEncoder();
  const field = (number, bytes) => [(number << 3) | 2, bytes.length, ...bytes];
  const hello = [0x08, 1, 0x10, 1, ...field(3, [1]), ...field(4, text.encode(token)), ...field(5, text.encode("page"))];
  const ping = [0x08, 5];
  return new Promise((resolve) => {
    const kinds = [];
    const socket = new WebSocket(stream, "multitetra.v1");
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(new Uint8Array(field(1, hello)));
    socket.onmessage = ({ data }) => {
      kinds.push(new Uint8Array(data)[0] >> 3);
      if (kinds.length === 1) socket.send(new Uint8Array(field(5, ping)));
      if (kinds.length === 2) socket.close();
    };
    socket.onclose = () => resolve(kinds);
  });
}
