"""Long calls: other threads go on, Ctrl-C ends them, forked processes are told."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest

import biprism as bp

# Some seconds of work on one thread.
LONG = """
    import biprism as bp, time, sys, resource
    from pathlib import Path
    scene = bp.Scene.load(sys.argv[1]).replace({"camera.width_px": 3200, "camera.height_px": 1800, "camera.pixel_pitch_um": 3.3})
"""


def python(code: str, scene: str) -> subprocess.Popen[str]:
    line = [sys.executable, "-c", textwrap.dedent(LONG) + textwrap.dedent(code), scene]
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def path() -> str:
    from conftest import CASES

    return str(CASES / "prism_freeform.toml")


def interrupted(work: str) -> float:
    """How long after Ctrl-C the process still works, in s; the call itself raises at once."""
    code = f"""
    cpu = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_utime
    scene.replace({{"camera.width_px": 64, "camera.height_px": 36, "camera.pixel_pitch_um": 165.0}}).render("draft")
    print("begins", flush=True)
    try:
        scene.{work}
    except KeyboardInterrupt:
        raised = time.monotonic()
        while True:
            before = cpu()
            time.sleep(0.2)
            if cpu() - before < 0.02:
                break
        print(raised, time.monotonic() - 0.2 - raised)
    else:
        print("it ended by itself")
    """
    running = python(code, path())
    assert running.stdout is not None
    assert running.stdout.readline() == "begins\n"
    time.sleep(0.5)
    sent = time.monotonic()
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=100)
    assert running.returncode == 0, err
    raised, working = map(float, out.split())
    # The work itself takes far longer.
    assert raised - sent < 5.0, raised - sent
    return working


def test_ctrl_c_ends_a_picture_and_the_work_behind_it() -> None:
    assert interrupted('render("reference")') < 10.0


def test_ctrl_c_ends_a_comparison() -> None:
    assert interrupted("compare(budget=True)") < 20.0


def test_the_lock_is_released() -> None:
    scene = bp.Scene.load(path()).replace({"camera.width_px": 1600, "camera.height_px": 900, "camera.pixel_pitch_um": 6.6})
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.wait(0.005):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.monotonic()
    scene.render("reference", truth=False)
    ended = time.monotonic()
    done.set()
    thread.join()
    during = [t for t in ticks if begun < t < ended]
    assert ended - begun > 0.1 and len(during) > 0.05 * (ended - begun) / 0.005, (len(during), ended - begun)


def test_calls_of_several_threads_have_the_same_bits(flat: bp.Scene) -> None:
    wanted = flat.render(truth=False).radiance.tobytes()
    found: list[bytes] = []
    threads = [threading.Thread(target=lambda: found.append(flat.render(truth=False).radiance.tobytes())) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [wanted] * 4


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_is_told(flat: bp.Scene) -> None:
    flat.replace({"prism.index": 1.5}).render("draft", truth=False)
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe()

    def work() -> None:
        try:
            flat.render("draft", truth=False)
            theirs.send("done")
        except RuntimeError as error:
            theirs.send(str(error))

    child = context.Process(target=work)
    child.start()
    assert ours.poll(20), "the forked process hangs"
    assert "spawn" in ours.recv()
    child.join()
