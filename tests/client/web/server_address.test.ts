import { keepStaticAddress, serverAddress, Token } from "../../../client/web/src/page/server_address";

// A page at an address; the browser storage persists across the pages of a test.
function page(address: string) {
  vi.stubGlobal("location", new URL(address));
  const server = serverAddress();
  return { server, token: new Token(server) };
}

function storage() {
  const kept = new Map<string, string>();
  return {
    getItem: (name: string) => kept.get(name) ?? null,
    setItem: (name: string, value: string) => void kept.set(name, value),
  };
}

describe("ServerAddress", () => {
  beforeEach(() => {
    vi.stubGlobal("sessionStorage", storage());
    vi.stubGlobal("document", { querySelector: () => null });
  });
  afterEach(() => vi.unstubAllGlobals());

  test("DefaultsToTheHostOfThePage", () => {
    expect(page("http://volumes.example:7480/").server).toBe("ws://volumes.example:7480/v1/stream");
    expect(page("https://volumes.example/?x=1#y").server).toBe("wss://volumes.example/v1/stream");
    expect(page("https://site.example/volumes/?x=1#y").server).toBe("wss://site.example/volumes/v1/stream");
    expect(serverAddress("https://volumes.example/path/")).toBe("wss://volumes.example/path/v1/stream");
    expect(page("http://localhost:5173/?server=ws://other:1/v1/stream").server).toBe("ws://other:1/v1/stream");
  });

  test("NamesFilesInsteadOfAServer", () => {
    expect(page("https://site.example/page/?static=head.mtd#isovalue=3").server).toBe("static:https://site.example/page/head.mtd");
    vi.stubGlobal("document", { querySelector: () => ({ content: "datasets.json" }) });
    expect(page("https://site.example/page/").server).toBe("static:https://site.example/page/datasets.json");
    expect(page("https://site.example/page/?server=ws://other:1/v1/stream").server).toBe("ws://other:1/v1/stream");
  });

  test("MovesFilesToTheQuery", () => {
    const replaceState = vi.fn();
    vi.stubGlobal("history", { replaceState });
    vi.stubGlobal("location", new URL("https://site.example/?embed=#static=a%20b.mtd&isovalue=3"));
    keepStaticAddress();
    expect(String(replaceState.mock.calls[0][2])).toBe("https://site.example/?embed=&static=a+b.mtd#isovalue=3");
  });

  test("KeepsATokenForTheSession", () => {
    expect(page("https://volumes.example/").token.get()).toBe("");
    expect(page("https://volumes.example/#dataset=head&token=mt_secret").token.get()).toBe("mt_secret");
    expect(page("https://volumes.example/#dataset=head").token.get()).toBe("mt_secret");
    page("https://volumes.example/").token.set("mt_typed");
    expect(page("https://volumes.example/").token.get()).toBe("mt_typed");
  });

  test("SendsAStoredTokenToItsServerOnly", () => {
    page("https://volumes.example/#token=mt_secret");
    for (const other of [
      "wss://thief.example/v1/stream",
      "wss://volumes.example.thief.example/v1/stream",
      "wss://volumes.example:444/v1/stream",
      "wss://volumes.example@thief.example/v1/stream",
      "ws://volumes.example/v1/stream",
      "wss://volumes.example/v1/stream/../elsewhere",
      "",
      "token",
    ]) {
      expect(page(`https://volumes.example/?server=${other}`).token.get(), other).toBe("");
    }
    page("https://volumes.example/?server=wss://thief.example/v1/stream#token=mt_other");
    expect(page("https://volumes.example/").token.get()).toBe("mt_secret");
  });

  test("ReadsATokenFromAnEditedAddressOnce", () => {
    const { token } = page("https://volumes.example/");
    expect(token.readFrom("#isovalue=3")).toBe(false);
    expect(token.readFrom("#token=mt_new&isovalue=3")).toBe(true);
    expect(token.readFrom("#token=mt_new")).toBe(false);
    expect(token.readFrom("#token=")).toBe(false);
    expect(page("https://volumes.example/").token.get()).toBe("mt_new");
  });

  test("TokenLeavesTheAddressAtOnce", () => {
    const replaced: string[] = [];
    vi.stubGlobal("history", { replaceState: (_: null, __: string, address: string) => replaced.push(address) });
    for (const hash of ["#token=mt_secret", "#dataset=head&token=mt_secret&isovalue=3", "#dataset=head", ""]) {
      page(`https://volumes.example/${hash}`);
      Token.hide();
    }
    expect(replaced).toEqual(["#", "#dataset=head&isovalue=3"]);
  });

  test("KeepsATokenInMemoryWithoutStorage", () => {
    vi.stubGlobal("sessionStorage", undefined);
    const { token } = page("https://volumes.example/#token=mt_secret");
    expect(token.get()).toBe("mt_secret");
  });
});
