"""A real browser without a window, to look at the pages of a report; a module of the tests."""

import json
import os
import shutil
import signal
import subprocess
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--enable-logging=stderr",
    "--window-size=1600,1200",
    # so that the wrapper may look into the pages in its frames
    "--allow-file-access-from-files",
    # keeps the browser open until it is told to end
    "--remote-debugging-port=0",
)
#: Pages in frames of the wanted width, one after the other: a browser's own window cannot be as
#: narrow as a telephone. What is measured is sent back. Not with --dump-dom: its time stands still
#: between frames, and what waits for a figure to come near the screen waits forever.
WRAPPER = """<!doctype html>
<script>
const wanted = {wanted};
const found = {{}};
const next = () => {{
  const one = wanted.shift();
  if (!one) {{
    const body = JSON.stringify(found);
    fetch("http://127.0.0.1:{port}", {{ method: "POST", mode: "no-cors", body }});
    return;
  }}
  const frame = document.createElement("iframe");
  frame.style = `border:0;width:${{one.width}}px;height:900px`;
  frame.onload = () => setTimeout(() => {{
    measure(frame.contentWindow, one).then((result) => {{
      found[one.name] = result;
      frame.remove();
      next();
    }});
  }}, 300);
  frame.src = one.address;
  document.body.append(frame);
}};
{measure}
onload = next;
</script>
"""


def find_browser() -> str | None:
    """Return the browser of this machine, or None."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def browse(
    browser: str, wanted: list[dict[str, Any]], measure: str, folder: Path, *flags: str
) -> tuple[dict[str, Any], str]:
    """Show pages one after the other; return what the script measured and what was complained of.

    Parameters
    ----------
    browser : str
        The program.
    wanted : list of dict
        `name`, `width` [px], `address` of each page, and what else the script needs.
    measure : str
        JavaScript with a function `measure(view, one)` that promises a result.
    folder : Path
        For the wrapper, the profile and what the browser says.
    *flags : str
        More of them for the browser.
    """
    answers: Queue[bytes] = Queue()

    class Listener(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            answers.put(self.rfile.read(int(self.headers["Content-Length"])))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    said = folder / "stderr.txt"
    wrapper = folder / "wrapper.html"
    with HTTPServer(("127.0.0.1", 0), Listener) as server, said.open("w") as stderr:
        Thread(target=server.serve_forever, daemon=True).start()
        text = WRAPPER.format(wanted=json.dumps(wanted), measure=measure, port=server.server_port)
        wrapper.write_text(text, encoding="utf-8")
        own = f"--user-data-dir={folder / 'profile'}"
        with subprocess.Popen(
            [browser, *FLAGS, *flags, own, wrapper.as_uri()],
            stderr=stderr,
            start_new_session=True,
        ) as process:
            try:
                answer = answers.get(timeout=240)
            except Empty:
                answer = b""
            finally:
                # the browser is a script that starts another process, on some systems
                os.killpg(process.pid, signal.SIGTERM)
        server.shutdown()
    complaints = said.read_text(encoding="utf-8", errors="replace")
    assert answer, complaints
    return json.loads(answer), complaints
