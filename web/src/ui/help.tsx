import { Dialog } from "./dialog.tsx";
import { shownKeys } from "./keys.ts";

export type HelpPart = { title: string; rows: readonly { keys: string; does: string }[] };

/** All shortcuts, and what the mouse does. */
export function Help({ parts, onClose }: { parts: readonly HelpPart[]; onClose(): void }) {
  return (
    <Dialog title="Keyboard and mouse" wide onClose={onClose}>
      <div class="help">
        {parts
          .filter((part) => part.rows.length > 0)
          .map((part) => (
            <section key={part.title}>
              <h3>{part.title}</h3>
              <dl>
                {part.rows.map((row) => (
                  <div key={row.keys + row.does}>
                    <dt>
                      {row.keys.split(" / ").map((keys) => (
                        <kbd key={keys}>{shownKeys(keys)}</kbd>
                      ))}
                    </dt>
                    <dd>{row.does}</dd>
                  </div>
                ))}
              </dl>
            </section>
          ))}
      </div>
    </Dialog>
  );
}
