// The documentation's links: each leads to a file and a heading that are there, and README's contents lead to each page.
// SOURCE: the source directory.
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {readdirSync, readFileSync} from "node:fs";
import {dirname, join, normalize} from "node:path";
import {test} from "node:test";
import {fileURLToPath} from "node:url";
import {remark} from "remark";
import {visit} from "unist-util-visit";

const source = process.env.SOURCE;
const here = dirname(fileURLToPath(import.meta.url));
const texts = ["CHANGELOG.md", "README.md"];
for (const folder of ["client", "lcmtypes", "service", "tests", "tools"])
  texts.push(...readdirSync(join(source, folder), {recursive: true})
    .map(file => join(folder, file)).filter(file => file.endsWith(".md") && !file.includes("node_modules")));

test("no link is dead", () => {
  const run = spawnSync(join(here, "node_modules/.bin/remark"),
    ["--frail", "--quiet", "--no-stdout", "--no-config", "--no-ignore", "--use",
      join(here, "node_modules/remark-validate-links/index.js") + "=repository:false", ...texts],
    {cwd: source, encoding: "utf8"});
  assert.equal(run.status, 0, run.stderr);
});

test("README's contents lead to each page and to the developers' one", () => {
  const linked = new Set();
  const readme = remark().parse(readFileSync(join(source, "README.md")));
  const contents = readme.children.findIndex(node => node.type === "heading" && node.children[0].value === "Contents");
  assert.notEqual(contents, -1);
  for (const node of readme.children.slice(contents))
    visit(node, "link", link => linked.add(normalize(link.url.replace(/#.*/, ""))));
  const pages = texts.filter(file => /\.[57]\.md$/.test(file));
  assert.ok(pages.length >= 10);
  assert.deepEqual([...pages, "tools/README.md"].filter(page => !linked.has(page)), []);
});

test("each page's first line is its name, section and subject", () => {
  for (const file of texts.filter(file => /\.[57]\.md$/.test(file)))
  {
    const [, name, section] = file.match(/([^/]*)\.([57])\.md$/);
    assert.ok(readFileSync(join(source, file), "utf8").startsWith(`# ${name}(${section}): `), file);
  }
});

test("what a page is called is the page that is there", () => {
  const pages = texts.map(file => file.match(/([^/]*)\.([57])\.md$/)).filter(Boolean).map(([, name, section]) => `${name}(${section})`);
  for (const file of texts) {
    const text = readFileSync(join(source, file), "utf8");
    for (const [name] of text.matchAll(/\btorqued[a-z.-]*\([57]\)/g))
      assert.ok(pages.includes(name), `${file} names ${name}, which is no page`);
    visit(remark().parse(text), "link", link => {
      const [, name, section] = link.children.map(child => child.value ?? "").join("").match(/^([a-z.-]+)\(([57])\)$/) ?? [];
      assert.ok(!name || link.url.replace(/#.*/, "").endsWith(`${name}.${section}.md`), `${file}: ${name}(${section}) leads to ${link.url}`);
    });
  }
});
