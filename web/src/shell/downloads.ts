import { address, credentials, remember, remembered, token } from "../address.ts";
import type { Ended } from "../state.ts";

export type Export = { job?: string; file?: string; message?: string };

const mostAwaited = 20; // as many as the server keeps

/** Asks for a file of a tab's result. */
export async function requestExport(body: object): Promise<Export> {
  try {
    const response = await fetch(address("export"), {
      method: "POST",
      headers: { ...credentials(), "Content-Type": "application/json" },
      body: JSON.stringify(body),
    });
    const answer = (await response.json().catch(() => ({}))) as Export;
    if (response.ok || answer.message) return answer;
    return { message: `Nothing was saved: the server answered ${response.status}.` };
  } catch {
    return { message: "Nothing was saved: the server does not answer. Try again when it is back." };
  }
}

/**
 * The exports that this page has asked for and not fetched, also before it was loaded again. One may
 * have ended before the answer that names its file is there.
 */
export class Awaited {
  private files = (remembered("exports") ?? "").split(" ").filter(Boolean);
  private readonly ended = new Map<string, Ended>();

  /** This page has asked for it: it is fetched once it is done. */
  add(file: string): void {
    this.keep([...this.files, file]);
    const ended = this.ended.get(file);
    if (ended) this.note(ended);
  }

  /** One has ended, as told first or again. True if this page was waiting for it. */
  note({ file = "", ...ended }: Ended): boolean {
    if (!this.files.includes(file)) {
      this.ended.set(file, { file, ...ended });
      return false;
    }
    this.keep(this.files.filter((one) => one !== file));
    if (ended.outcome === "done") download(file, ended.name);
    return true;
  }

  private keep(files: string[]): void {
    this.files = files.slice(-mostAwaited);
    remember("exports", this.files.join(" "));
  }
}

/** Has the browser save a file of the server's. */
function download(file: string, name = ""): void {
  const link = document.createElement("a");
  link.href = address(`file/${file}`, token === null ? {} : { token }).href;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
}
