"""Prints the licences of the crates whose code is in the libraries, from `cargo metadata` on standard input."""

import json
import pathlib
import sys

metadata = json.load(sys.stdin)
packages = {package["id"]: package for package in metadata["packages"]}
nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}

seen, open_ids = set(), [next(i for i, package in packages.items() if package["name"] == "ballrace-c")]
while open_ids:
    current = open_ids.pop()
    if current in seen:
        continue
    seen.add(current)
    for dependency in nodes[current]["deps"]:
        normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
        macro = any("proc-macro" in target["kind"] for target in packages[dependency["pkg"]]["targets"])
        if normal and not macro:
            open_ids.append(dependency["pkg"])

for package in sorted((packages[i] for i in seen), key=lambda package: package["name"]):
    if package["source"] is None:
        continue
    print(f"{package['name']} {package['version']}: {package['license']}")
    folder = pathlib.Path(package["manifest_path"]).parent
    for path in sorted(folder.glob("LICENSE*")):
        print(f"\n--- {path.name}\n{path.read_text(encoding='utf-8').strip()}")
    print()
print("The libraries also contain parts of the core library and of compiler_builtins of Rust: MIT OR Apache-2.0.")
