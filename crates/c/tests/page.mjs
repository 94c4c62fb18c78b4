// The page of examples/js in a browser: served from here, run in a headless Chromium, read as it ends up.
// page.mjs PAGE PACKAGE

import { createServer } from "node:http";
import { execFile } from "node:child_process";
import { readFile } from "node:fs/promises";
import { promisify } from "node:util";
import assert from "node:assert/strict";

const folders = process.argv.slice(2);
// The browser prints a page once all of it is loaded: a picture that comes late gives the worker its time.
const wait_ms = 20_000;
const kinds = { html: "text/html", js: "text/javascript", mjs: "text/javascript", wasm: "application/wasm" };
const server = createServer(async ({ url }, response) => {
  const name = new URL(url, "http://localhost").pathname.slice(1) || "index.html";
  if (name === "late") {
    setTimeout(() => response.writeHead(404).end(), wait_ms);
    return;
  }
  for (const folder of folders) {
    let body = await readFile(`${folder}/${name}`).catch(() => undefined);
    if (body === undefined) continue;
    if (name === "index.html") body = String(body).replace("</body>", '<img src="late"></body>');
    response.writeHead(200, { "content-type": kinds[name.split(".").at(-1)] ?? "text/plain" }).end(body);
    return;
  }
  response.writeHead(404).end();
});
await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
const address = `http://127.0.0.1:${server.address().port}/`;
const options = ["--headless", "--no-sandbox", "--disable-gpu", "--timeout=120000", "--dump-dom", address];
let dumped;
for (const browser of ["chromium", "chromium-browser", "google-chrome"]) {
  try {
    dumped = (await promisify(execFile)(browser, options, { timeout: 300_000 })).stdout;
    break;
  } catch (error) {
    if (error.code !== "ENOENT") throw error;
  }
}
server.close();
if (dumped === undefined) {
  console.log("page: not run, there is no Chromium");
} else {
  assert.match(dumped, /<h2>none: [\d.]+ um at most, tolerance 40 um<\/h2>/, dumped);
  assert.match(dumped, /<h2>fixed: [\d.]+ um at most/);
  assert.match(dumped, /<td>G3 I-15 F1800<\/td>/);
  console.log("page: a browser shows what its worker answers");
}
