import { count, counted, IconButton, List, Section } from "../ui/index.ts";
import type { App } from "./app.ts";
import { openFiles } from "./shortcuts.ts";

/** The meshes that are open. */
export function Shelf({ app }: { app: App }) {
  const meshes = app.state?.meshes ?? [];
  const used = Object.values((app.state?.tabs[app.tab.name]?.state ?? {}) as object);
  return (
    <Section
      title="Meshes"
      aside={
        <IconButton icon="plus" size={14} label="Open meshes" keys="Ctrl+O" onClick={openFiles} />
      }
    >
      <List
        label="Open meshes"
        rows={meshes.map((mesh) => ({
          id: mesh.id,
          name: mesh.name,
          selected: used.includes(mesh.id),
          detail: `${count(mesh.vertices)} / ${count(mesh.faces)}`,
          hint: [
            mesh.about,
            `${counted(mesh.vertices, "vertex", "vertices")}, ${counted(mesh.faces, "face")}`,
            app.tab.use ? `Click: use it for ${app.tab.title}` : "",
          ]
            .filter(Boolean)
            .join("\n"),
        }))}
        onSelect={app.tab.use && ((id) => app.tab.use!(app, id))}
        onRename={(mesh, name) => app.do("document", "rename", { mesh, name })}
        onRemove={(mesh) => void app.do("document", "remove", { mesh })}
      />
    </Section>
  );
}
