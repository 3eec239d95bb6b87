import { address, credentials } from "../address.ts";

/** A file on its way to the server. */
export interface Upload {
  readonly id: number;
  readonly name: string;
  /** Of its bytes; null once all are there, and are being read. */
  fraction: number | null;
  cancel(): void;
}

export type Uploaded = { mesh?: string; message?: string };

let uploads = 0;

/** Sends a file; a browser tells how far it is only with this older kind of request. */
export function upload(
  file: File,
  changed: (upload: Upload) => void,
): { upload: Upload; answer: Promise<Uploaded> } {
  const request = new XMLHttpRequest();
  const upload: Upload = {
    id: ++uploads,
    name: file.name,
    fraction: 0,
    cancel: () => request.abort(),
  };
  const answer = new Promise<Uploaded>((resolve) => {
    request.open("POST", address("upload", { name: file.name }));
    for (const [name, value] of Object.entries(credentials()))
      request.setRequestHeader(name, value);
    request.upload.onprogress = ({ loaded, total }) => {
      upload.fraction = total > 0 && loaded < total ? loaded / total : null;
      changed(upload);
    };
    request.onload = () => resolve(read(request, file.name));
    request.onabort = () => resolve({});
    request.onerror = () =>
      resolve({
        message: `${file.name} could not be sent: the server does not answer. Open the file again when it is back.`,
      });
    request.send(file);
  });
  return { upload, answer };
}

function read(request: XMLHttpRequest, name: string): Uploaded {
  try {
    const answer = JSON.parse(request.responseText) as Uploaded;
    if (request.status < 400 || answer.message) return answer;
  } catch {
    // not from the studio: a proxy's page, perhaps
  }
  if (request.status === 413) return { message: `${name} is larger than the server allows.` };
  return { message: `${name} was not opened: the server answered ${request.status}.` };
}
