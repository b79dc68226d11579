#!/usr/bin/env python3
"""Breaks the program in one place at a time, and looks whether the laws that must notice it fail.

    python3 tools/break_kernels.py            # every row of tools/broken_kernels.py
    python3 tools/break_kernels.py 7 snell    # row 7, and the rows with "snell" in their file, text or tests
    python3 tools/break_kernels.py --list     # the rows
    python3 tools/break_kernels.py --check    # the table against the sources, without a build

It works in a copy of its own, `break_kernels` in the target directory (CARGO_TARGET_DIR, or `target`), with a target
directory of its own, so that neither the sources nor a built `biprism` are ever broken ones. Before the first break all
tests of the rows must pass. Rows that share a label share a build. `--times N` runs each test N times, property tests
with new random numbers each time.

Prints for each row its number, the file, the break, and the tests that caught it, or SURVIVED. A row may call a break
benign, with the reason; then its tests must pass. `--check` looks that every text stands exactly once and every named
test exists, and tells the laws that no row breaks: every test in the files of laws and in the `proptest!` blocks.

Exit code 0 when all is as the table says; 1 when a named test did not fail, or a law has no row; 2 when a text is not
found exactly once, a test is not there or fails without a break, or a break does not build. All rows take 20
builds, each of 2 to 4 minutes with its tests on two busy cores.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True
from broken_kernels import LAWS, ROWS  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
WORK = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "break_kernels"
COPY = WORK / "copy"
PATIENCE_S = 900  # A test that runs longer has failed.


def tests_of(path):
    """The tests of a file as (binary::module, name), each with whether it lies in a proptest! block."""
    text = path.read_text()
    first, *parts = path.relative_to(ROOT).with_suffix("").parts
    parts = [part.removesuffix("_tests") for part in parts if part not in ("mod", "main")]
    own = first == "tests" and parts[:1] in (["faults"], ["golden"])
    module = "::".join(parts if own else ["lib" if first == "src" else "suite", *parts])
    blocks = [match.span() for match in re.finditer(r"^( *)proptest! \{.*?^\1\}", text, re.M | re.S)]
    tests = re.finditer(r"#\[test\]\s+(?:#\[[^\n]*\]\s+)*fn (\w+)", text)
    return {(module, test[1]): any(a < test.start() < b for a, b in blocks) for test in tests}


def check():
    """What is wrong with the table, each with its exit code."""
    files = [path for folder in ("src", "tests") for path in sorted((ROOT / folder).rglob("*.rs"))]
    tests = {path.relative_to(ROOT).as_posix(): tests_of(path) for path in files}
    is_of = lambda name, key: name.startswith(key[0]) and name.endswith("::" + key[1])
    for number, row in enumerate(ROWS, 1):
        times = (ROOT / row.file).read_text().count(row.text)
        if times != 1:
            yield 2, f"{number} {row.file}: found {times} times: {row.text!r}"
        for name in row.tests():
            if not any(is_of(name, key) for keys in tests.values() for key in keys):
                yield 2, f"{number} {row.file}: there is no test {name}"
    caught = {name for row in ROWS for name in row.caught_by}
    for file, keys in tests.items():
        for key, by_proptest in keys.items():
            law = by_proptest or file in LAWS or "::".join(key) in LAWS
            if law and not any(is_of(name, key) for name in caught):
                yield 1, f"no row breaks {'::'.join(key)}"


def synchronise():
    """Makes the copy what the sources are; files that are the same keep their times, and with them their builds."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")
    wanted = {COPY / name: (ROOT / name).read_bytes() for name in names if name and (ROOT / name).is_file()}
    for path in [path for path in COPY.rglob("*") if path.is_file() and path not in wanted]:
        path.unlink()
    for path, data in wanted.items():
        if not path.is_file() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)


def failures(tests, times):
    """How many of `times` runs of each test fail in the copy; or the compiler's words, if it does not build.

    Optimised less than a release, which the tests hardly feel and which builds sooner.
    """
    binaries = sorted({test.split("::", 1)[0] for test in tests})
    which = [word for b in binaries for word in (["--lib"] if b == "lib" else ["--test", b])]
    command = ["cargo", "test", "--release", "--no-run", "--message-format=json-render-diagnostics"]
    command += ["--config", "profile.release.package.biprism.opt-level=1", *which]
    environment = {**os.environ, "CARGO_TARGET_DIR": str(WORK / "target"), "CARGO_INCREMENTAL": "1"}
    build = subprocess.run(command, cwd=COPY, env=environment, capture_output=True, text=True)
    if build.returncode != 0:
        return next((line for line in build.stderr.splitlines() if line.startswith("error")), build.stderr)
    count = dict.fromkeys(tests, 0)
    for made in (json.loads(line) for line in build.stdout.splitlines() if line.startswith("{")):
        if not (made.get("executable") and made["profile"]["test"]):
            continue
        binary = "lib" if "lib" in made["target"]["kind"] else made["target"]["name"]
        own = {test.split("::", 1)[1]: test for test in tests if test.split("::", 1)[0] == binary}
        for _ in range(times):
            try:
                run = [made["executable"], "--exact", *own]
                said = subprocess.run(run, cwd=COPY, capture_output=True, timeout=PATIENCE_S).stdout
            except subprocess.TimeoutExpired as late:
                said = late.stdout or b""
            passed = re.findall(r"^test (\S+) .*ok$", said.decode(errors="replace"), re.M)
            for name in own.keys() - set(passed):
                count[own[name]] += 1
    return count


def judged(row, count, times):
    """Exit code and words of one row, given how often each test failed."""
    often = lambda test: test if count[test] in (0, times) else f"{test} ({count[test]} of {times} times)"
    caught = ", ".join(often(test) for test in row.tests() if count[test])
    wrong = [f"{t} passed" for t in row.caught_by if not count[t]] + [f"{t} failed" for t in row.passed_by if count[t]]
    text = f"caught by {caught}" if caught else f"SURVIVED{f' (benign: {row.benign})' if row.benign else ''}"
    return int(bool(wrong)), text + ("; NOT AS TOLD: " + ", ".join(wrong) if wrong else "")


def try_together(rows, times):
    """Exit codes and words of rows that are broken at once."""
    try:
        for row in rows:
            path = COPY / row.file
            path.write_text(path.read_text().replace(row.text, row.broken))
        found = failures(sorted({test for row in rows for test in row.tests()}), times)
    finally:
        synchronise()
    return [(2, f"does not build: {found}") if isinstance(found, str) else judged(row, found, times) for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", help="numbers of rows, or words in their files, texts or tests")
    parser.add_argument("--check", action="store_true", help="only look at the table")
    parser.add_argument("--list", action="store_true", help="only print the rows")
    parser.add_argument("--times", type=int, default=1, help="runs of each test")
    asked = parser.parse_args()
    meant = lambda k, row: any(w == str(k) if w.isdigit() else w in row.words() for w in asked.rows) or not asked.rows
    rows = [(k, row) for k, row in enumerate(ROWS, 1) if meant(k, row)]
    if asked.list:
        print("\n".join(f"{k} {row.words()}" for k, row in rows))
        return 0
    complaints = list(check())
    tests = {test for row in ROWS for test in row.caught_by}
    print("\n".join([text for _, text in complaints] + [f"{len(ROWS)} rows, {len(tests)} tests"]), flush=True)
    worst = max((code for code, _ in complaints), default=0)
    if asked.check or worst == 2:
        return worst
    COPY.mkdir(parents=True, exist_ok=True)
    synchronise()
    found = failures(sorted({test for _, row in rows for test in row.tests()}), 1)
    ill = found if isinstance(found, str) else ", ".join(test for test, count in found.items() if count)
    if ill:
        print(f"wrong without a break: {ill}")
        return 2
    groups = {}
    for k, row in rows:
        groups.setdefault(row.together or k, []).append((k, row))
    for group in groups.values():
        start = time.monotonic()
        for (k, row), (code, text) in zip(group, try_together([row for _, row in group], asked.times)):
            worst = max(worst, code)
            print(f"{k} {row.file}: {row.shown()}: {text}", flush=True)
        print(f"    {time.monotonic() - start:.0f} s", flush=True)
    return worst


if __name__ == "__main__":
    sys.exit(main())
