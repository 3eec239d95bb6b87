import { useEffect, useState } from "preact/hooks";
import { Icon } from "../ui/index.ts";
import type { App } from "./app.ts";

/** Files can be dropped anywhere: while they are above the page, it says so. */
export function DropZone({ app }: { app: App }) {
  const [above, setAbove] = useState(false);
  useEffect(() => {
    const carries = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
    const over = (event: DragEvent) => {
      if (!carries(event)) return;
      event.preventDefault();
      event.dataTransfer!.dropEffect = "copy";
      setAbove(true);
    };
    const leave = (event: DragEvent) => event.relatedTarget === null && setAbove(false);
    const drop = (event: DragEvent) => {
      if (!carries(event)) return;
      event.preventDefault();
      setAbove(false);
      openAll(app, event.dataTransfer!);
    };
    addEventListener("dragenter", over);
    addEventListener("dragover", over);
    addEventListener("dragleave", leave);
    addEventListener("drop", drop);
    return () => {
      removeEventListener("dragenter", over);
      removeEventListener("dragover", over);
      removeEventListener("dragleave", leave);
      removeEventListener("drop", drop);
    };
  }, []);
  return (
    <>
      <input
        id="files"
        type="file"
        multiple
        hidden
        aria-label="Files to open"
        onChange={({ currentTarget }) => {
          void app.upload(currentTarget.files ?? []);
          currentTarget.value = ""; // so that the same file can be chosen again
        }}
      />
      {above && (
        <div class="drop-above" aria-hidden="true">
          <div>
            <Icon name="open" size={40} />
            Drop to open
          </div>
        </div>
      )}
    </>
  );
}

function openAll(app: App, dropped: DataTransfer): void {
  const folders = [...dropped.items].filter((item) => item.webkitGetAsEntry()?.isDirectory).length;
  if (folders > 0) app.notify("warning", "Folders are not opened: drop the files in them.");
  // a folder is in `files` as well, as a file that cannot be read
  const files = [...dropped.items]
    .filter((item) => item.kind === "file" && !item.webkitGetAsEntry()?.isDirectory)
    .map((item) => item.getAsFile())
    .filter((file) => file !== null);
  if (files.length > 0) void app.upload(files);
}
