"""A simulated printer with its page, and what a browser's programs would ask of it."""

import http.client
import json
import re
import shutil
import subprocess
import threading
import time

from case import PROGRAMS, SIM2K, SOURCE_DIR
from state_client import StatePrinter

PAGE = PROGRAMS / "plumbline-page"


class PagePrinter(StatePrinter):
    """A simulated printer with a page on a port of its own."""

    def page_board(self, page, start="after_preview"):
        """@returns a board file like that of sim2k, with a page"""
        folder = self.dir / "board"
        if not folder.exists():
            shutil.copytree(SOURCE_DIR / "board" / "profiles", folder / "profiles")
        text = SIM2K.read_text().replace('"on_request"', f'"{start}"').replace('page = "off"', f'page = "{page}"')
        (folder / "sim2k.toml").write_text(text)
        return folder / "sim2k.toml"

    def start_page(self, page="local", **board):
        self.log = []
        command = [PAGE, "--printer", self.page_board(page, **board), "--socket", self.path, "--port", "0", "--state", self.dir]
        self.page = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end_page)
        line = self.page.stdout.readline()
        self.assertRegex(line, r"http://[^:]+:\d+/")
        self.port = int(re.search(r":(\d+)/", line)[1])
        self.reader = threading.Thread(target=lambda: self.log.extend(iter(self.page.stderr.readline, "")))
        self.reader.start()

    def logged(self, words):
        """Waits until the page has logged the words."""
        end = time.monotonic() + 30
        while not any(words in line for line in self.log):
            self.assertLess(time.monotonic(), end, self.log)
            time.sleep(0.02)

    def end_page(self):
        self.page.kill()
        self.page.wait()
        self.reader.join()
        self.page.stdout.close()
        self.page.stderr.close()

    def ask(self, method, path, body=None, headers=None, host=None, come_from="127.0.0.1"):
        """@param body  bytes, or what becomes JSON
        @param come_from  the client's address: all of 127.0.0.0/8 are this machine's
        @returns (status, headers, bytes)
        """
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30, source_address=(come_from, 0))
        host = host or f"127.0.0.1:{self.port}"
        sent = {"Host": host, **(headers or {})}
        if method == "POST":
            sent = {"Origin": f"http://{host}", "Content-Type": "application/json", **sent}
        connection.request(method, path, body=body if body is None or isinstance(body, bytes) else json.dumps(body), headers=sent)
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        return answer.status, answer.headers, data

    def get(self, path, **options):
        status, _, data = self.ask("GET", path, **options)
        self.assertEqual(status, 200, (path, data[:300]))
        return data

    def post(self, path, body, status=200, **options):
        got, _, data = self.ask("POST", path, body, **options)
        while status == 200 and b'"answer_soon"' in data:  # what it asks has just come
            time.sleep(0.2)
            got, _, data = self.ask("POST", path, body, **options)
        self.assertEqual(got, status, (path, body, data[:300]))
        return json.loads(data)

    def upload(self, name, data, headers, status=200):
        """Asks, then sends. @returns the answer"""
        asked = self.post("/upload", {"do": "upload", "name": name, "bytes": len(data)}, headers=headers)
        return self.post(f"/upload/body?n={asked['upload']}", data, status=status, headers={**headers, "Content-Type": "application/octet-stream"})

    def paired(self):
        """@returns the headers of a browser that is paired with a local page"""
        return {"Plumbline-Token": self.post("/pair", {})["token"]}
