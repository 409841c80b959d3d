/** Builds ../viewer.js and ../../workbench/workbench.js: `npm ci && npm run build` in this folder. */
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { build } from "esbuild";

const scripts = (folder) => readdirSync(folder).filter((name) => name.endsWith(".js")).sort().map((name) => `${folder}/${name}`);
const licence = readFileSync("node_modules/three/LICENSE", "utf8").trim();

// tests/viewer/test_view.py and tests/workbench/test_server.py compute the same number, so that a forgotten build is found.
async function bundle(entry, outfile, folders) {
  const hash = createHash("sha256");
  for (const name of folders.flatMap(scripts)) hash.update(readFileSync(name));
  await build({
    entryPoints: [entry],
    outfile,
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2022",
    charset: "ascii",
    legalComments: "none",
    banner: { js: `/* source ${hash.digest("hex")}\nContains three.js:\n${licence}\n*/` },
  });
}

await bundle("main.js", "../viewer.js", ["."]);
await bundle("workbench/main.js", "../../workbench/workbench.js", [".", "workbench"]);
