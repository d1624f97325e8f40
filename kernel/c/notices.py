"""Prints the licences of the crates whose code is in the libraries.

Argument: output of `cargo tree --prefix none --format '{p}'`; standard input: that of `cargo metadata`.
"""

import json
import pathlib
import sys

linked = {tuple(line.split()[:2]) for line in pathlib.Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()}
packages = [
    package
    for package in json.load(sys.stdin)["packages"]
    if package["source"] is not None and (package["name"], f"v{package['version']}") in linked
]

for package in sorted(packages, key=lambda package: package["name"]):
    print(f"{package['name']} {package['version']}: {package['license']}")
    folder = pathlib.Path(package["manifest_path"]).parent
    for path in sorted(folder.glob("LICENSE*")):
        print(f"\n--- {path.name}\n{path.read_text(encoding='utf-8').strip()}")
    print()
print("The compiled code also contains parts of the standard library of Rust: MIT OR Apache-2.0.")
