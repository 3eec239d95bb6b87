import { address, credentials, token } from "../address.ts";

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

/** Has the browser save a file of the server's. */
export function download(file: string, name = ""): void {
  const link = document.createElement("a");
  link.href = address(`file/${file}`, token === null ? {} : { token }).href;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
}
