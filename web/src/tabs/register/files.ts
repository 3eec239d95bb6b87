/** Landmarks from files of this and other programs. */

import type { Studio } from "../tab.ts";

export const endings = [".json", ".vts", ".pp", ".fcsv"] as const;

/** Characters of a file that fit into a message. */
const longest = 300_000;

/** Reads landmarks from one file, or from one for each mesh. */
export async function readLandmarks(studio: Studio, files: readonly File[]): Promise<void> {
  if (files.length > 2)
    return studio.notify(
      "warning",
      "Landmarks are in one file, or in one for each mesh: choose one or two.",
    );
  const large = files.find((file) => file.size > longest);
  if (large) return studio.notify("warning", `${large.name} is too large for a file of landmarks.`);
  const read = await Promise.all(
    files.map(async (file) => ({ name: file.name, text: await file.text() })),
  );
  await studio.do("register", "read_landmarks", { files: read });
}

/** Takes what is landmarks of files that were dropped; the others are left. */
export async function receive(studio: Studio, files: readonly File[]): Promise<readonly File[]> {
  const own = await Promise.all(files.map(isLandmarks));
  const found = files.filter((_, k) => own[k]);
  if (found.length > 0) await readLandmarks(studio, found);
  return files.filter((_, k) => !own[k]);
}

async function isLandmarks(file: File): Promise<boolean> {
  const name = file.name.toLowerCase();
  if (name.endsWith(".mrk.json")) return true;
  if (!name.endsWith(".json")) return endings.some((ending) => name.endsWith(ending));
  // recipes are objects, and go their own way
  return file.size <= longest && (await file.text()).trimStart().startsWith("[");
}
