// Returns a function that runs `run` for one value at a time; of those given meanwhile only the last follows. `run` must not
// reject.
export function latestOnly<T>(run: (wanted: T) => Promise<unknown>): (wanted: T) => void {
  let isRunning = false;
  const waiting: T[] = [];
  return async (wanted) => {
    waiting.splice(0, 1, wanted);
    if (isRunning) return;
    isRunning = true;
    while (waiting.length > 0) await run(waiting.shift()!);
    isRunning = false;
  };
}
