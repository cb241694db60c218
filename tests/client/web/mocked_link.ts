// Links whose other end is the test: vi.mock("../../../client/web/src/stream/link", () => import("./mocked_link")).
import type { ClientKind } from "../../../client/web/src/protocol/messages";
import type { LinkEvents } from "../../../client/web/src/stream/link";

// All links in the order of their making, and what they have done.
export const link = { all: [] as LinkEvents[], sent: [] as ClientKind[], waits: [] as number[], attempts: 0 };

export class Link {
  constructor(_address: string, events: LinkEvents) {
    link.all.push(events);
  }
  connect() {
    ++link.attempts;
  }
  connectIn(milliseconds: number) {
    link.waits.push(milliseconds);
  }
  close() {}
  send(message: ClientKind) {
    link.sent.push(message);
  }
}
