import { useEffect, useRef, useState } from "preact/hooks";

/** What a change is answered with: nothing, or a promise that settles when the change is made. */
export type Answer = void | Promise<unknown>;

/**
 * The value a control shows: what a person is setting, until what it was set to is answered.
 *
 * Controls show the server's state. While a person drags, and until the server has answered, that
 * state is behind: showing it would make the control jump back.
 */
export function useHeld<T>(value: T): {
  shown: T;
  hold(value: T): void;
  settle(answer: Answer): void;
  release(): void;
} {
  const [held, setHeld] = useState<{ value: T } | null>(null);
  const turn = useRef(0);
  useEffect(() => () => void (turn.current = -1), []);
  const release = () => {
    turn.current += 1;
    setHeld(null);
  };
  return {
    shown: held ? held.value : value,
    hold(next) {
      turn.current += 1;
      setHeld({ value: next });
    },
    settle(answer) {
      const mine = ++turn.current;
      const end = () => mine === turn.current && setHeld(null);
      if (answer instanceof Promise) answer.then(end, end);
      else end();
    },
    release,
  };
}
