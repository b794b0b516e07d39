"""A browser, commanded over WebDriver (www.w3.org/TR/webdriver2) with nothing but Python's standard library."""

import base64
import json
import re
import shutil
import subprocess
import time
import urllib.error
import urllib.request

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
TAB, ENTER, ESCAPE, RIGHT, HOME = "\ue004", "\ue007", "\ue00c", "\ue014", "\ue011"
SECONDS = 60


class Stale(Exception):
    """The page has drawn itself anew since the element was found."""


class Browser:
    """Debian's chromium without a window. Ends with the test."""

    def __init__(self, test, folder, columns=1280, rows=900, language="en"):
        self.test = test
        # It ends at once if the port that it was given is taken for the other version of IP.
        for _ in range(5):
            if port := self.start_driver():
                break
        self.address = f"http://127.0.0.1:{port}"
        arguments = ["--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--no-proxy-server", "--hide-scrollbars",
                     "--disable-background-networking", "--disable-component-update", f"--user-data-dir={folder}/browser", f"--lang={language}",
                     f"--window-size={columns},{rows}"]
        options = {"binary": CHROMIUM, "args": arguments, "prefs": {"intl.accept_languages": language}}
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        self.session = ""
        self.session = "/session/" + self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        test.addCleanup(self.call, "DELETE", "")

    def start_driver(self):
        """@returns its port; none: it has ended"""
        self.driver = subprocess.Popen([DRIVER, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.test.addCleanup(self.driver.wait)
        self.test.addCleanup(self.driver.stdout.close)
        self.test.addCleanup(self.driver.terminate)
        for line in self.driver.stdout:
            if found := re.search(r"successfully on port (\d+)", line):
                return found[1]
        return None

    def call(self, method, path, body=None):
        data = json.dumps({} if body is None else body).encode() if method == "POST" else None
        request = urllib.request.Request(self.address + self.session + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=SECONDS) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as error:
            found = json.load(error)["value"]
            if found["error"] == "stale element reference":
                raise Stale from error
            return self.test.fail(f"{method} {path} {body}: {found['message']}")

    def afresh(self, action):
        """Does what begins with finding elements, from its start again if they have gone meanwhile."""
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            try:
                return action()
            except Stale:
                continue
        return action()

    def open(self, address):
        self.call("POST", "/url", {"url": address})

    def run(self, script, *arguments):
        """@returns what the body of a JavaScript function returns"""
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def size(self, columns, rows, dark=False):
        self.cdp("Emulation.setDeviceMetricsOverride", width=columns, height=rows, deviceScaleFactor=1, mobile=False)
        self.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def cdp(self, command, **parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def find(self, selector):
        return self.call("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]

    def find_all(self, selector):
        return [one[ELEMENT] for one in self.call("POST", "/elements", {"using": "css selector", "value": selector})]

    def click(self, selector):
        self.afresh(lambda: self.call("POST", f"/element/{self.find(selector)}/click"))

    def type(self, selector, text):
        self.afresh(lambda: self.call("POST", f"/element/{self.find(selector)}/value", {"text": text}))

    def press(self, *keys):
        """Keys for whatever has the focus."""
        actions = [{"type": kind, "value": key} for key in keys for kind in ("keyDown", "keyUp")]
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": actions}]})

    def drag(self, selector, columns):
        """Drags the middle of an element to the right with the pointer."""
        middle = {ELEMENT: self.find(selector)}
        actions = [{"type": "pointerMove", "origin": middle, "x": 0, "y": 0}, {"type": "pointerDown", "button": 0},
                   {"type": "pointerMove", "duration": 100, "origin": "pointer", "x": columns, "y": 0}, {"type": "pointerUp", "button": 0}]
        self.call("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]})

    def unnamed(self, selector):
        """@returns the HTML of the elements for which a screen reader has no name to say"""
        return self.afresh(lambda: [self.run("return arguments[0].outerHTML", {ELEMENT: element}) for element in self.find_all(selector)
                                    if not self.call("GET", f"/element/{element}/computedlabel").strip()])

    def until(self, script, what):
        script = f"try {{ {script} }} catch (error) {{ if (!(error instanceof TypeError)) throw error }}"  # an element is not there yet
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            if value := self.run(script):
                return value
            time.sleep(0.05)
        shown = self.run("return document.body.innerText")
        return self.test.fail(f"{what}: the page shows\n{shown}")

    def picture(self):
        """@returns the whole page as PNG"""
        box = self.cdp("Page.getLayoutMetrics")["cssContentSize"]
        shot = self.cdp("Page.captureScreenshot", captureBeyondViewport=True, clip={**box, "scale": 1})
        return base64.b64decode(shot["data"])

    def shot(self, selector):
        """@returns an element as PNG"""
        return base64.b64decode(self.afresh(lambda: self.call("GET", f"/element/{self.find(selector)}/screenshot")))

    def messages(self):
        """What the browser complained about since the last call."""
        all_of_them = [one["message"] for one in self.call("POST", "/se/log", {"type": "browser"})]
        # Not of its own first page, on a busy machine, nor that WebGL is slow without a graphics card.
        return [one for one in all_of_them if not one.startswith("chrome://") and "GL Driver Message" not in one]
