/** Builds ../viewer.js: `npm ci && npm run build` in this folder. */
import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import { build } from "esbuild";

// tests/viewer/test_view.py computes the same number, so that a forgotten build is found.
const hash = createHash("sha256");
const sources = readdirSync(".").filter((name) => name.endsWith(".js"));
for (const name of sources.sort()) hash.update(readFileSync(name));

const licence = readFileSync("node_modules/three/LICENSE", "utf8").trim();
await build({
  entryPoints: ["main.js"],
  outfile: "../viewer.js",
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "ascii",
  legalComments: "none",
  banner: { js: `/* source ${hash.digest("hex")}\nContains three.js:\n${licence}\n*/` },
});
