/**
 * Bundles the page: `node build.mjs [--out FOLDER] [--watch]`.
 *
 * Each entry of src/ becomes one file of the folder (by default where the Python package looks for
 * it), which holds nothing else. The notices of the libraries inside go with it.
 */
import { context } from "esbuild";
import { existsSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

const here = fileURLToPath(new URL(".", import.meta.url));
const { values: options } = parseArgs({
  options: {
    out: { type: "string", default: join(here, "../src/henkei/page") },
    watch: { type: "boolean", default: false },
  },
});
const folder = resolve(options.out);
const entries = ["studio.ts", "viewer.ts", "studio.css", "index.html"];
const notices = "licences.txt";

/** The text of the licences of all packages that a build took something from. */
function licences(metafile) {
  const packages = new Set();
  for (const input of Object.keys(metafile.inputs)) {
    const found = /^node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (found) packages.add(found[1]);
  }
  return [...packages].sort().map((name) => {
    const licence = readFileSync(join(here, "node_modules", name, "LICENSE"), "utf8");
    return `${name}\n\n${licence.trim()}\n`;
  });
}

/** After each build: write the notices, and take away what no entry made. */
const finish = {
  name: "finish",
  setup(build) {
    build.onEnd(({ errors, metafile }) => {
      if (errors.length > 0) return;
      writeFileSync(join(folder, notices), licences(metafile).join("\n\n"));
      const made = Object.keys(metafile.outputs).map((path) => resolve(here, path));
      const kept = new Set([...made, join(folder, notices)]);
      for (const name of readdirSync(folder)) {
        const path = join(folder, name);
        if (!kept.has(path)) rmSync(path, { recursive: true });
      }
      if (options.watch) console.log(`built ${folder}`);
    });
  },
};

const build = await context({
  absWorkingDir: here,
  entryPoints: entries
    .map((name) => join("src", name))
    .filter((path) => existsSync(join(here, path))),
  outdir: folder,
  entryNames: "[name]",
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  loader: { ".html": "copy", ".svg": "dataurl", ".woff2": "dataurl" },
  sourcemap: options.watch ? "linked" : false,
  legalComments: "none",
  metafile: true,
  logLevel: "warning",
  plugins: [finish],
});
if (options.watch) {
  await build.watch();
} else {
  try {
    await build.rebuild();
  } catch {
    process.exitCode = 1; // esbuild has said why
  }
  await build.dispose();
}
