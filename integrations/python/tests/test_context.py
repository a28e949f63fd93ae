"""Ctrl-C, cancelling, progress, warnings, and other threads meanwhile."""
import os
import signal
import subprocess
import sys
import threading
import time
import unittest
import warnings

import numpy as np

import resolvent
from fixtures import CUBE, INWARDS, SMALL
from resolvent import Context, Material, Mesh, Scene

#: seconds of work that is interrupted, many times over
LONG = {"width": 256, "height": 4096, "samples": 4096}


class Interruptions(unittest.TestCase):
    def setUp(self):
        # what runs in the background of a shell begins with Ctrl-C ignored, and hands that on
        handler = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, handler)

    def interrupted(self, work):
        """Ctrl-C a moment after the work began; it stops soon, by CPU time: other processes may keep it waiting."""
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        began = time.process_time()
        with self.assertRaises(KeyboardInterrupt):
            timer.start()
            work()
            time.sleep(5)  # not reached
        self.assertLess(time.process_time() - began, 4)
        timer.join()

    def cancelled_by_a_thread(self, context, work, *naps):
        """Another thread sleeps now and then, and cancels the work; again if it has not begun until then."""
        over = threading.Event()

        def cancel():
            for nap in naps:
                time.sleep(nap)
            while not over.wait(0.1):
                context.cancel()

        thread = threading.Thread(target=cancel)
        thread.start()
        try:
            with self.assertRaises(resolvent.Cancelled):
                work()
        finally:
            over.set()
            thread.join()

    def test_ctrl_c_stops_long_calls_and_the_context_lives_on(self):
        scene = Scene.builtin("cornell-blocks", context=Context())
        before = scene.reference(width=8, samples=1)
        light = scene.solve("draft", **SMALL)
        for work in (lambda: scene.reference(**LONG), lambda: light.render(gather_rays=1024, **LONG),
                     lambda: scene.solve("high"), lambda: light.certify(samples=2**20),
                     lambda: light.irradiance(np.ones((10**5, 3)), (0, 1, 0), "operator", samples=10**6)):
            self.interrupted(work)
            np.testing.assert_array_equal(scene.reference(width=8, samples=1), before)

    def test_ctrl_c_stops_scripts(self):
        script = ("import resolvent, signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\nprint('ready', flush=True)\n"
                  "resolvent.Scene.builtin('cornell-blocks').reference(width=256, height=4096, samples=4096)")
        pipe = subprocess.PIPE
        with subprocess.Popen([sys.executable, "-c", script], stdout=pipe, stderr=pipe) as process:
            process.stdout.readline()
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=120)
        self.assertTrue(error.rstrip().endswith(b"KeyboardInterrupt"), error)
        self.assertEqual(error.count(b"Traceback"), 1)

    def test_other_threads_cancel(self):
        context = Context()
        scene = Scene.builtin("cornell-blocks", context=context)
        context.cancel()  # nothing runs: nothing happens
        self.cancelled_by_a_thread(context, lambda: scene.reference(**LONG), 0.3)
        self.assertEqual(scene.reference(width=4, samples=1).shape, (4, 4, 3))

    def test_other_threads_run_meanwhile(self):
        context = Context()
        scene = Scene.builtin("cornell-blocks", context=context)
        # were they kept waiting, nothing would end the work
        self.cancelled_by_a_thread(context, lambda: scene.reference(**LONG), *[0.01] * 20)

    def test_threads_share_a_light(self):
        light = Scene.builtin("cornell-blocks").solve("draft", **SMALL)
        pictures = {}
        threads = [threading.Thread(target=lambda k=k: pictures.update({k: light.render(width=16, samples=2)}))
                   for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for k in range(4):
            np.testing.assert_array_equal(pictures[k], pictures[0])


class Progress(unittest.TestCase):
    def test_progress_is_told(self):
        told = []
        context = Context(progress=lambda phase, fraction: told.append((phase, fraction)))
        Scene.builtin("cornell-blocks", context=context).solve("draft", **SMALL)
        self.assertIn("assemble", {phase for phase, _ in told})
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in told))

    def test_progress_cancels(self):
        scene = Scene.builtin("cornell-blocks", context=Context(progress=lambda *_: False))
        with self.assertRaises(resolvent.Cancelled):
            scene.reference(**LONG)

    def test_what_progress_raises_is_raised(self):
        def fail(phase, fraction):
            raise ZeroDivisionError("of mine")

        scene = Scene.builtin("cornell-blocks", context=Context(progress=fail))
        with self.assertRaisesRegex(ZeroDivisionError, "of mine"):
            scene.reference(**LONG)
        self.assertIn("triangles", repr(scene))

    def test_wrong_arguments(self):
        for kind, arguments in ((ValueError, (-1,)), (ValueError, (2000,)), (TypeError, ("two",)), (TypeError, (1, 3))):
            with self.assertRaises(kind):
                Context(*arguments)


class Warnings(unittest.TestCase):
    def test_warnings_are_those_of_python(self):
        mesh = Mesh(CUBE, INWARDS, material=Material(roughness=7, name="cork"))
        with self.assertWarnsRegex(resolvent.ResolventWarning, "cork") as caught:
            Scene.from_meshes(mesh)
        self.assertEqual(caught.filename, __file__)  # where the package was called, not the package
        with warnings.catch_warnings():
            warnings.simplefilter("error", resolvent.ResolventWarning)
            with self.assertRaisesRegex(resolvent.ResolventWarning, "cork"):
                Scene.from_meshes(mesh)


if __name__ == "__main__":
    unittest.main()
