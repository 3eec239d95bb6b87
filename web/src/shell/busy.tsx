import { Progress } from "../ui/index.ts";
import type { App } from "./app.ts";

/** Work that goes on: files on their way, and the server's jobs. */
export function Busy({ app }: { app: App }) {
  const { jobs } = app;
  // once a file is there, the server has a job of the same title
  const uploads = app.uploads.filter(
    (upload) =>
      upload.fraction !== null || !jobs.some((job) => job.title === `Open ${upload.name}`),
  );
  if (uploads.length + jobs.length === 0) return null;
  return (
    <div class="busy" role="region" aria-label="Work in progress">
      {uploads.map((upload) => (
        <Progress
          key={upload.id}
          title={`Open ${upload.name}`}
          message={upload.fraction === null ? "reading" : "sending"}
          fraction={upload.fraction}
          onCancel={upload.cancel}
        />
      ))}
      {jobs.map((job) => (
        <Progress
          key={job.job}
          title={job.title}
          message={job.message}
          fraction={job.fraction ?? null}
          onCancel={job.cancellable === false ? undefined : () => app.cancel(job.job)}
        />
      ))}
    </div>
  );
}

/** What is wrong with the connection, said quietly. */
export function Banner({ app }: { app: App }) {
  const locked = app.status === "locked" && app.state !== null;
  if (app.status !== "away" && !locked) return null;
  return (
    <div class="banner" role="status" aria-label="Connection">
      {locked ? (
        <Locked />
      ) : (
        <>
          <span class="spinner" />
          The studio's server is away; trying again …
        </>
      )}
    </div>
  );
}

/** Why there is nothing to be seen, and what to do. */
export function Locked() {
  return (
    <p class="locked">
      The studio does not let this page in. Open the whole address that <code>henkei studio</code>{" "}
      printed when it started; it ends with <code>?token=</code> and the token.
    </p>
  );
}
