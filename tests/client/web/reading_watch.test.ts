import { resourceAddress } from "../../../client/web/src/stream/http_resource";
import { readingText } from "../../../client/web/src/stream/reading_watch";

describe("ReadingWatch", () => {
  test("NeverRoundsUpToTheWhole", () => {
    expect(readingText({ name: "head", share: 0.996 })).toBe('Reading "head": 99 %.');
    expect(readingText({ name: "head", share: 1 })).toBe('Reading "head": 100 %.');
  });

  test("AsksBesideTheStream", () => {
    expect(resourceAddress("wss://example.org/volumes/v1/stream", "datasets").href).toBe("https://example.org/volumes/v1/datasets");
  });
});
