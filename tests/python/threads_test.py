"""Interrupts, progress and threads."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import darboux
import numpy as np
from module_util import BALL, PLATE, data_file


def long_scene():
    """Several seconds of many iterations."""
    scene = darboux.Scene.load(data_file("tennis_ball.yaml"))
    scene["surface"]["frequency"] = 10
    return scene


class Once:
    """Calls something at the first report of an iteration that comes after some others."""

    def __init__(self, call, after=3):
        self.call, self.left, self.at = call, after, None

    def __call__(self, progress):
        self.left -= 1
        if self.left == 0:
            self.at = time.monotonic()
            return self.call()
        return None


class Interrupts(unittest.TestCase):
    # An iteration of the long scene takes a tenth of a second alone; machines may be busy.
    SOON = 5.0

    def check_last_state(self, result):
        self.assertFalse(result.converged)
        self.assertTrue(np.isfinite(result.points).all())
        self.assertEqual(result.termination, "stopped")
        if result.num_steps > 0:
            self.assertTrue(np.isfinite(result.displacement).all())

    def test_ctrl_c_ends_a_solve_soon_and_keeps_the_last_state(self):
        once = Once(lambda: os.kill(os.getpid(), signal.SIGINT))
        with self.assertRaises(KeyboardInterrupt) as caught:
            long_scene().solve(threads=1, progress=once)
        self.assertLess(time.monotonic() - once.at, self.SOON)
        self.check_last_state(caught.exception.result)

    def test_other_signals_raise_what_their_handlers_raise(self):
        def on_alarm(number, frame):
            raise TimeoutError("enough")

        before = signal.signal(signal.SIGALRM, on_alarm)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, 0.5)
        start = time.monotonic()
        with self.assertRaisesRegex(TimeoutError, "enough") as caught:
            long_scene().solve(threads=1)
        self.assertLess(time.monotonic() - start, 0.5 + self.SOON)
        self.check_last_state(caught.exception.result)

    def test_a_progress_function_that_raises_ends_it(self):
        def fail():
            raise ZeroDivisionError("mine")

        with self.assertRaisesRegex(ZeroDivisionError, "mine") as caught:
            long_scene().solve(threads=1, progress=Once(fail))
        self.check_last_state(caught.exception.result)

    def test_a_progress_function_that_returns_false_ends_it_without_exception(self):
        self.check_last_state(long_scene().solve(threads=1, progress=Once(lambda: False)))

    def test_an_event_stops_a_solve_in_any_thread(self):
        stop, results = threading.Event(), []
        worker = threading.Thread(
            target=lambda: results.append(
                long_scene().solve(threads=1, stop=stop, progress=Once(stop.set))
            )
        )
        worker.start()
        worker.join()
        self.check_last_state(results[0])

    def test_ctrl_c_ends_a_script_with_the_usual_traceback(self):
        script = (
            "import darboux, os, signal\n"
            f"scene = darboux.Scene.load({data_file('tennis_ball.yaml')!r})\n"
            "scene.solve(threads=1, progress=lambda p: os.kill(os.getpid(), signal.SIGINT))\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", script], stderr=subprocess.PIPE, universal_newlines=True
        )
        self.assertIn("KeyboardInterrupt", done.stderr.splitlines()[-1])
        self.assertIn(done.returncode, (-signal.SIGINT, 130, 1))

    def test_after_an_interrupt_the_next_solve_is_unharmed(self):
        before = darboux.Scene(BALL).solve(threads=1)
        with self.assertRaises(KeyboardInterrupt):
            darboux.Scene(BALL).solve(
                threads=1, progress=Once(lambda: os.kill(os.getpid(), signal.SIGINT), after=1)
            )
        after = darboux.Scene(BALL).solve(threads=1)
        self.assertTrue(np.array_equal(before.displacement, after.displacement))


class Reports(unittest.TestCase):
    def test_progress_comes_in_order_in_the_calling_thread(self):
        reports = []
        result = darboux.Scene(BALL, steps=2).solve(
            threads=1, progress=lambda p: reports.append((p, threading.get_ident()))
        )
        self.assertEqual({ident for _, ident in reports}, {threading.get_ident()})
        steps = [p for p, _ in reports if p.kind == "step"]
        iterations = [p for p, _ in reports if p.kind == "iteration"]
        self.assertEqual([p.step for p in steps], [1, 2])
        self.assertTrue(all(p.converged for p in steps))
        self.assertEqual(steps[-1].load_factor, 1.0)
        self.assertEqual([p.energy for p in iterations], result.iterations["energy"].tolist())
        self.assertEqual([p.total for p in iterations], result.iterations["total"].tolist())
        seconds = [p.seconds for p, _ in reports]
        self.assertEqual(seconds, sorted(seconds))


class Threads(unittest.TestCase):
    def test_other_threads_go_on_while_one_solves(self):
        ticks, done = [], threading.Event()

        def tick():
            while not done.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.002)

        ticker = threading.Thread(target=tick)
        ticker.start()
        start = time.monotonic()
        result = darboux.Scene(BALL).solve(threads=1)
        end = time.monotonic()
        done.set()
        ticker.join()
        self.assertTrue(result.converged)
        meanwhile = [t for t in ticks if start < t < end]
        # With the lock held there would be none.
        self.assertGreater(len(meanwhile), 10)
        gaps = np.diff([start] + meanwhile + [end])
        self.assertLess(gaps.max(), 0.5 * (end - start))

    def test_two_threads_solve_at_the_same_time_and_to_the_same_bits(self):
        scenes = [darboux.Scene(BALL), darboux.Scene(BALL)]
        scenes[1].add_load(kind="gas", gauge_pressure=0, ambient_pressure=0.1)
        alone = [scene.solve(threads=1) for scene in scenes]
        results, spans = [None, None], [None, None]
        begin = threading.Barrier(2)

        def solve(i):
            times = []
            begin.wait()
            results[i] = scenes[i].solve(
                threads=1, progress=lambda p: times.append(time.monotonic())
            )
            spans[i] = (times[0], times[-1])

        workers = [threading.Thread(target=solve, args=(i,)) for i in range(2)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertLess(max(span[0] for span in spans), min(span[1] for span in spans))
        for a, b in zip(alone, results):
            self.assertTrue(np.array_equal(a.displacement, b.displacement))
            self.assertEqual(a.summary["iterations"], b.summary["iterations"])

    def test_one_result_may_be_read_from_several_threads(self):
        result = darboux.Scene(PLATE).solve(threads=1)
        read = [None] * 4

        def look(i):
            read[i] = (result.fields(), result.at(uv=[[0.3, 0.4]]), result.points)

        workers = [threading.Thread(target=look, args=(i,)) for i in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        for fields, at, points in read[1:]:
            self.assertTrue(np.array_equal(fields["moment"], read[0][0]["moment"]))
            self.assertTrue(np.array_equal(at["moment"], read[0][1]["moment"]))
            self.assertTrue(np.array_equal(points, read[0][2]))


if __name__ == "__main__":
    unittest.main()
