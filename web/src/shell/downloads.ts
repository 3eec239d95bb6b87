import { address, credentials, token } from "../address.ts";
import type { Ended } from "../state.ts";

export type Export = { job?: string; file?: string; name?: string; message?: string };

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

/** How jobs ended: one may have done so before the answer that names it is there. */
export class Endings {
  private readonly known = new Map<string, Ended>();
  private readonly awaited = new Map<string, (ended: Ended) => void>();

  note(ended: Ended): void {
    const awaited = this.awaited.get(ended.job);
    if (awaited) awaited(ended);
    else this.known.set(ended.job, ended);
    this.awaited.delete(ended.job);
  }

  of(job: string): Promise<Ended> {
    const known = this.known.get(job);
    return known ? Promise.resolve(known) : new Promise((ended) => this.awaited.set(job, ended));
  }
}

/** Has the browser save a file of the server's. */
export function download(file: string, name = ""): void {
  const link = document.createElement("a");
  link.href = address(`file/${file}`, token === null ? {} : { token }).href;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
}
