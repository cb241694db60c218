import { SwapGroup } from "../../../client/web/src/surfaces/swap_group";
import { neighboringTime, type PlaybackRate, type PlaybackState, TimePlayer, timesAhead } from "../../../client/web/src/viewer/time_player";

// A player with a simulated clock and frames.
class Playing {
  state: PlaybackState = { times: [0, 1, 2, 3], now: 0, playing: true, speed: 10, loop: true };
  ready = new Set([0, 1, 2, 3]);
  now = 0;
  pace: PlaybackRate = { rate: null, isWaiting: false };
  prepared: readonly number[] = [];
  readonly shown: number[] = [];
  private next: (() => void) | null = null;
  readonly player = new TimePlayer(
    () => this.state,
    {
      isReady: (time) => this.ready.has(time),
      prepare: (times) => (this.prepared = times),
      show: (time) => {
        this.shown.push(time);
        this.state = { ...this.state, now: time };
      },
      stop: () => this.turn({ playing: false }),
    },
    (pace) => (this.pace = pace),
    (act) => (this.next = act),
    () => this.now,
  );

  turn(change: Partial<PlaybackState>): void {
    this.state = { ...this.state, ...change };
    this.player.update();
  }

  // Advances in frames of 20 ms.
  run(milliseconds: number): void {
    for (const end = this.now + milliseconds; this.now < end; ) {
      this.now += 20;
      const act = this.next;
      this.next = null;
      act?.();
    }
  }
}

describe("TimePlayer", () => {
  test("LoopsAtItsSpeed", () => {
    const playing = new Playing();
    playing.player.update();
    playing.run(510);
    expect(playing.shown).toEqual([1, 2, 3, 0, 1]);
    expect(playing.pace.rate).toBeCloseTo(10, 1);
  });

  test("StopsAtTheEnd", () => {
    const playing = new Playing();
    playing.turn({ loop: false });
    playing.run(1000);
    expect(playing.shown).toEqual([1, 2, 3]);
    expect(playing.state.playing).toBe(false);
    expect(playing.prepared).toEqual([]);
  });

  test("WaitsForMissingTimesWithoutCatchingUp", () => {
    const playing = new Playing();
    playing.ready.delete(1);
    playing.player.update();
    playing.run(1000);
    expect(playing.shown).toEqual([]);
    expect(playing.pace.isWaiting).toBe(true);
    playing.ready.add(1);
    playing.run(110);
    expect(playing.shown).toEqual([1, 2]);
    expect(playing.pace.isWaiting).toBe(false);
  });

  test("PrefetchesUpcomingTimesInOrder", () => {
    const playing = new Playing();
    playing.turn({ now: 2 });
    playing.run(20);
    expect(playing.prepared).toEqual([3, 0, 1]);
    playing.turn({ playing: false });
    expect(playing.prepared).toEqual([]);
    playing.run(500);
    expect(playing.shown).toEqual([]);
  });

  test("ListsUpcomingAndNeighboringTimes", () => {
    const times = [0, 0.5, 2];
    expect(timesAhead({ times, now: 0.5, loop: false })).toEqual([2]);
    expect(timesAhead({ times, now: 2, loop: false })).toEqual([]);
    expect(timesAhead({ times, now: 2, loop: true })).toEqual([0, 0.5]);
    expect(neighboringTime({ times, now: 0, loop: true }, -1)).toBe(2);
    expect(neighboringTime({ times, now: 0, loop: false }, -1)).toBe(0);
    expect(neighboringTime({ times, now: 2, loop: false }, 1)).toBe(2);
  });
});

describe("SwapGroup", () => {
  function stage() {
    const seen = ["a", "b"];
    const drawn: string[] = [];
    const swapGroup = new SwapGroup<string>(
      () => seen,
      () => drawn.push("|"),
    );
    const offer = (who: string, time: number, scene = "flow") => swapGroup.offer(who, { scene, time }, () => drawn.push(`${who}${time}`));
    const open = () => ["a", "b"].filter((who) => swapGroup.isDrawable(who)).join("");
    return { seen, drawn, swapGroup, offer, open };
  }

  test("ShowsTheFirstSceneImmediately", () => {
    const { drawn, offer } = stage();
    offer("a", 0);
    offer("b", 0);
    expect(drawn).toEqual(["a0", "|", "b0"]);
  });

  test("SwapsWhenAllHaveTheNextTime", () => {
    const { drawn, offer, open } = stage();
    offer("a", 0);
    offer("b", 0);
    drawn.length = 0;
    offer("b", 1);
    expect(drawn).toEqual([]);
    expect(open()).toBe("ab");
    offer("a", 1);
    expect(drawn).toEqual(["b1", "a1", "|"]);
    expect(open()).toBe("ab");
  });

  test("ShowsOnlyTheLatestOffer", () => {
    const { drawn, offer, swapGroup } = stage();
    offer("a", 0);
    offer("b", 0);
    drawn.length = 0;
    offer("a", 1);
    offer("a", 2);
    offer("b", 1);
    expect(drawn).toEqual([]);
    swapGroup.withdraw("a");
    offer("b", 2);
    expect(drawn).toEqual([]);
    offer("a", 2);
    expect(drawn).toEqual(["b2", "a2", "|"]);
  });

  test("DoesNotWaitForHiddenMembers", () => {
    const { seen, drawn, offer, swapGroup, open } = stage();
    offer("a", 0);
    offer("b", 0);
    drawn.length = 0;
    offer("a", 1);
    seen.pop();
    swapGroup.update();
    expect(drawn).toEqual(["a1", "|"]);
    expect(open()).toBe("a");
    offer("b", 2); // Hidden: nothing of it is drawn.
    expect(open()).toBe("a");
    seen.push("b");
    offer("a", 2);
    expect(drawn.slice(2)).toEqual(["b2", "a2", "|"]);
    expect(open()).toBe("ab");
  });

  test("ShowsMembersHiddenWhileWaiting", () => {
    const { seen, offer, swapGroup, open } = stage();
    offer("a", 0);
    offer("b", 0);
    offer("b", 1);
    seen.pop();
    offer("a", 1);
    seen.push("b");
    swapGroup.update();
    expect(open()).toBe("ab");
  });

  test("SwapsImmediatelyIfNoneIsVisible", () => {
    const { seen, offer, swapGroup, open } = stage();
    offer("a", 0);
    offer("b", 0);
    seen.length = 0;
    offer("a", 1);
    seen.push("a");
    swapGroup.update();
    expect(open()).toBe("a");
  });

  test("ShowsAnotherSceneImmediately", () => {
    const { drawn, offer, open } = stage();
    offer("a", 0);
    offer("b", 0);
    drawn.length = 0;
    offer("a", 5, "head");
    expect(drawn).toEqual(["a5", "|"]);
    expect(open()).toBe("a");
  });
});
