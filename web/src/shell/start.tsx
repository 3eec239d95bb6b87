import { useState } from "preact/hooks";
import type { Example, Offer } from "../state.ts";
import { tabs } from "../tabs/index.ts";
import { ago, Button, Confirm, Icon, IconButton, Sign } from "../ui/index.ts";
import type { App } from "./app.ts";
import { Picture } from "./pictures.tsx";
import { openFiles } from "./shortcuts.ts";

/** Where a person begins: open a file, take an example, or go on with earlier work. */
export function StartPage({ app }: { app: App }) {
  const { state } = app;
  return (
    <div class="start" role="region" aria-label="Start">
      <div class="start-page">
        {!app.isEmpty && (
          <span class="start-close">
            <IconButton icon="close" label="Back to the studio" onClick={() => app.show(null)} />
          </span>
        )}
        <header>
          <Sign size={44} />
          <div>
            <h1>henkei studio</h1>
            <p>Change the form of surfaces: combine, register, deform, remesh in quads, design.</p>
          </div>
        </header>
        <button type="button" class="drop-here" aria-label="Open a mesh" onClick={openFiles}>
          <Icon name="open" size={28} />
          <strong>Drop meshes here, or click to choose</strong>
          <span>
            OBJ, PLY, STL, OFF, VTK, glTF and others; they stay on the machine of the studio
          </span>
        </button>
        {state && state.offers.length > 0 && <Offers app={app} offers={state.offers} />}
        {state && <Examples app={app} examples={state.examples} />}
      </div>
    </div>
  );
}

function Examples({ app, examples }: { app: App; examples: readonly Example[] }) {
  const shown = tabs.filter((tab) => examples.some((example) => example.tab === tab.name));
  if (shown.length === 0) return null;
  return (
    <section aria-label="Examples">
      <h2>Begin with an example</h2>
      <div class="cards">
        {shown.map((tab) => (
          <article
            class={`card${tab === app.tab ? " chosen" : ""}`}
            key={tab.name}
            aria-label={tab.title}
          >
            <Picture tab={tab.name} />
            <h3>{tab.title}</h3>
            <p>{tab.about}</p>
            <div class="card-examples">
              {examples
                .filter((example) => example.tab === tab.name)
                .map((example) => (
                  <button
                    key={example.name}
                    type="button"
                    class="example"
                    title={example.about}
                    onClick={() => void app.begin("example", { name: example.name })}
                  >
                    <Icon name="play" size={12} />
                    <span>{example.title}</span>
                  </button>
                ))}
            </div>
          </article>
        ))}
      </div>
    </section>
  );
}

function Offers({ app, offers }: { app: App; offers: readonly Offer[] }) {
  const [forgetting, setForgetting] = useState<Offer | null>(null);
  return (
    <section aria-label="Earlier work">
      <h2>Go on with earlier work</h2>
      <ul class="offers">
        {offers.map((offer) => (
          <li key={offer.session}>
            <Icon name="clock" />
            <span class="offer-meshes">{named(offer.meshes)}</span>
            <span class="detail">{ago(offer.saved)}</span>
            <Button
              label="Restore"
              onClick={() => void app.begin("restore", { session: offer.session })}
            />
            <IconButton
              icon="trash"
              size={14}
              label={`Forget ${named(offer.meshes)}`}
              onClick={() => setForgetting(offer)}
            />
          </li>
        ))}
      </ul>
      {forgetting && (
        <Confirm
          title={`Forget ${named(forgetting.meshes)}?`}
          text="Everything that was done in this session is deleted, and cannot be had back."
          yes="Forget"
          onYes={() => void app.do("document", "forget", { session: forgetting.session })}
          onClose={() => setForgetting(null)}
        />
      )}
    </section>
  );
}

function named(meshes: readonly string[]): string {
  if (meshes.length === 0) return "no mesh";
  const first = meshes.slice(0, 3).join(", ");
  return meshes.length > 3 ? `${first} and ${meshes.length - 3} more` : first;
}
