import type { TabName } from "../state.ts";
import { Hint, Section } from "../ui/index.ts";
import type { Tab } from "./tab.ts";

/** A tab that only shows what is there. */
export function stub(name: TabName, title: string, about: string, viewports: 1 | 2): Tab {
  return {
    name,
    title,
    about,
    viewports,
    tools: [
      {
        name: "orbit",
        title: "Turn the view",
        icon: "orbit",
        viewport: "orbit",
        hint: "Drag to turn, wheel to zoom, Shift to move",
      },
    ],
    shortcuts: [],
    Panel: () => (
      <Section title={title}>
        <Hint>{about}</Hint>
      </Section>
    ),
    async scene(studio, _, view) {
      const viewport = studio.viewports[0]!;
      for (const [key, { data }] of Object.entries(view.surfaces))
        if (!viewport.surface(key)) viewport.add(key, await studio.surface(data), studio.look);
    },
  };
}
