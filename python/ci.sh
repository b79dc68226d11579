#!/usr/bin/env bash
# Builds the wheel, and tests it in a fresh environment as a user has it: pytest, types, notebooks, lints of the compiled part. Where this
# machine has no Python, no pip, or no way to the package index, it says so and is done.
set -euo pipefail
cd "$(dirname "$0")"

without() {
    echo "the Python package is neither built nor tested here: $1"
    exit 0
}
command -v python3 >/dev/null || without "there is no python3"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' || without "python3 is older than 3.10"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv" >"$folder/log" 2>&1 || without "python3 makes no environment with pip"
pip=("$folder/venv/bin/pip" --disable-pip-version-check --quiet)
"${pip[@]}" download --no-deps --dest "$folder/probe" maturin >"$folder/log" 2>&1 || without "pip does not reach a package index"
host=$(rustc -vV | sed -n 's/^host: //p')
cargo fetch --locked --quiet --target "$host" || without "cargo does not reach what the package builds on"

echo "== lints of the compiled part"
cargo fmt --check -p biprism-python
cargo clippy --release --locked -p biprism-python -- -D warnings
echo "== the wheel"
"${pip[@]}" install 'maturin>=1.9,<2' || without "maturin cannot be installed"
"$folder/venv/bin/maturin" build --release --locked --interpreter "$folder/venv/bin/python" --out "$folder/wheels"
wheel=$(echo "$folder"/wheels/*.whl)
ls -l "$wheel"
"${pip[@]}" install --no-deps "$wheel"
"${pip[@]}" install "${wheel}[test]" || without "what the tests need cannot be installed"
echo "== tests, types and notebooks of the wheel"
# Another folder, so that what is imported is what is installed.
cd "$folder"
"$folder/venv/bin/pytest" --rootdir "$OLDPWD" --config-file "$OLDPWD/pyproject.toml" -p no:cacheprovider "$OLDPWD/tests"
