/** Where the server is: relative to the page, so that it works behind proxies, and its token. */

const kept = `henkei ${location.pathname}`; // of this page, where several are behind one host

type Remembered = "token" | "session" | "exports";

/** What outlives a reload of this browser tab. */
export function remembered(name: Remembered): string | null {
  try {
    return sessionStorage.getItem(`${kept} ${name}`);
  } catch {
    return null; // storage can be forbidden
  }
}

export function remember(name: Remembered, value: string): void {
  try {
    sessionStorage.setItem(`${kept} ${name}`, value);
  } catch {
    // then a reload begins anew
  }
}

/** The token of the page's address, or else of an earlier load of it. */
function given(): string | null {
  const inAddress = new URL(location.href).searchParams.get("token");
  if (inAddress !== null) remember("token", inAddress);
  return inAddress ?? remembered("token");
}

export const token = given();

/**
 * Takes the token out of the address bar, if this browser tab keeps it: then the refusal that the
 * bare address gets comes back by itself, see `comeBack`.
 */
export function hideToken(): void {
  const bare = new URL(location.href);
  bare.searchParams.delete("token");
  if (bare.href === location.href || remembered("token") !== token) return;
  history.replaceState(history.state, "", bare);
}

/** Where the page was refused for want of a token: loads it with the one this browser tab has. */
export function comeBack(): void {
  const here = new URL(location.href);
  if (token === null || here.searchParams.has("token")) return;
  here.searchParams.set("token", token);
  location.replace(here);
}

/** Of something of the server, such as "data/…". */
export function address(path: string, query: Record<string, string> = {}): URL {
  const url = new URL(path, location.href);
  url.search = new URLSearchParams(query).toString();
  url.hash = "";
  return url;
}

/** Of the web socket; a web socket can send no headers, so the token is part of it. */
export function socketAddress(): URL {
  const url = address("ws", token === null ? {} : { token });
  url.protocol = url.protocol.replace("http", "ws");
  return url;
}

/** Headers that let a request in. */
export function credentials(): Record<string, string> {
  return token === null ? {} : { "X-Token": token };
}
