#!/usr/bin/env python3
"""The printer's page in a real browser: a job from the stick to the finished part, with a pause, a fault and a resume; what a screen reader
and a keyboard find; contrast; sizes from a phone's to a desktop's. PLUMBLINE_LOOK_AT=FOLDER keeps pictures of it."""

import os
import re
import shutil
import time
import unittest
from pathlib import Path

from case import main, write_sphere
from glances_test import LAYER, RED, archive_of, rgb_png
from page_client import PagePrinter
from web_driver import CHROMIUM, DRIVER, ENTER, ESCAPE, RIGHT, TAB, Browser

SHOWN = ":not([hidden], [hidden] *, [inert] *, dialog:not([open]) *)"

# Texts whose contrast is below that of WCAG 2, level AA: 4.5, or 3 where they are large. For each text the colours under it are mixed.
CONTRAST = r"""
const parse = (text) => { const v = text.match(/[\d.]+/g).map(Number); return v.length < 4 ? [...v, 1] : v; };
const over = (top, under) => top.slice(0, 3).map((v, i) => v * top[3] + under[i] * (1 - top[3]));
const linear = (v) => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
const luminance = (c) => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
const bad = [];
let seen = 0;
for (const node of document.querySelectorAll('body *')) {
  const own = [...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim());
  const isInput = ['INPUT', 'SELECT'].includes(node.tagName) && node.type !== 'range';
  if ((!own && !isInput) || !node.checkVisibility() || ['SCRIPT', 'OPTION'].includes(node.tagName)) continue;
  const chain = [];
  for (let at = node; at; at = at.parentElement) chain.push(at);
  let ground = matchMedia('(prefers-color-scheme: dark)').matches ? [0, 0, 0] : [255, 255, 255];
  for (const at of chain.reverse()) ground = over(parse(getComputedStyle(at).backgroundColor), ground);
  const style = getComputedStyle(node), opacity = chain.reduce((all, at) => all * Number(getComputedStyle(at).opacity), 1);
  const ink = over([...parse(style.color).slice(0, 3), opacity], ground);
  const [high, low] = [luminance(ink), luminance(ground)].sort((a, b) => b - a);
  const ratio = (high + 0.05) / (low + 0.05), pixels = parseFloat(style.fontSize);
  const large = pixels >= 24 || (pixels >= 18.66 && Number(style.fontWeight) >= 700);
  seen += 1;
  if (ratio < (large ? 3 : 4.5) && !node.closest('button:disabled')) bad.push(`${ratio.toFixed(2)}: ${node.textContent.trim().slice(0, 40)}`);
}
return [seen, bad];
"""


@unittest.skipUnless(CHROMIUM and DRIVER, "no chromium and chromium-driver")
class BrowserTest(PagePrinter):
    def look(self, name, expected="^$"):
        """What must hold whatever the page shows, in each size.
        @param expected  matches what the browser may complain about
        """
        for columns, rows, dark in ((360, 740, False), (1280, 900, True)):
            self.browser.size(columns, rows, dark)
            wide = self.browser.run("return [document.documentElement.scrollWidth, innerWidth]")
            self.assertLessEqual(wide[0], wide[1], f"{name} is wider than a screen of {columns} pixels")
            seen, bad = self.browser.run(CONTRAST)
            self.assertGreater(seen, 3)
            self.assertEqual(bad, [], f"contrast of {name}")
            small = self.browser.run("""return [...document.querySelectorAll('button, select, input')]
                .filter((e) => e.checkVisibility() && e.getBoundingClientRect().height < 44).map((e) => e.outerHTML)""")
            self.assertEqual(small, [], "too small for a finger")
            # Regression: a scan without a picture showed a broken one.
            unhidden = self.browser.run("return [...document.querySelectorAll('[hidden]')].filter((e) => e.checkVisibility()).map((e) => e.outerHTML)")
            self.assertEqual(unhidden, [], "a style shows what is hidden")
            if folder := os.environ.get("PLUMBLINE_LOOK_AT"):
                (Path(folder) / f"page-{name}-{columns}.png").write_bytes(self.browser.picture())
        part = "dialog[open]" if self.browser.run("return Boolean(document.querySelector('dialog[open]'))") else "body"
        unnamed = [self.browser.run("return arguments[0].outerHTML", {"element-6066-11e4-a52e-4f735466cecf": element})
                   for element in self.browser.find_all(f"{part} :is(button, select, input, img, progress, a){SHOWN}")
                   if not self.browser.label(element).strip()]
        self.assertEqual(unnamed, [], f"{name} has parts without a name")
        self.assertEqual([text for text in self.browser.messages() if not re.search(expected, text)], [])

    def until_state(self, state, more="true"):
        self.browser.until(f"return document.body.dataset.state === '{state}' && ({more})", state)

    def do(self, command):
        self.browser.until(f"return document.querySelector('[data-do={command}]')", command)
        self.browser.click(f"[data-do={command}]")

    def tab_to(self, selector):
        """Goes there by keyboard alone."""
        for _ in range(60):
            if self.browser.run("return document.activeElement.matches(arguments[0])", selector):
                return
            self.browser.press(TAB)
        self.fail(f"the keyboard does not reach {selector}")

    def pair(self):
        """Types the code of the page's log, after one that is wrong."""
        self.browser.until("return document.querySelector('#pair').open", "the question for a code")
        end = time.monotonic() + 30
        while not self.log and time.monotonic() < end:
            time.sleep(0.02)
        code = re.search(r"is (\d{6})$", self.log[-1].strip())[1]
        self.browser.type("#code", "000000" if code != "000000" else "000001")
        self.browser.press(ENTER)
        self.browser.until("return !document.querySelector('#pair-error').hidden", "wrong code")
        self.look("pair", "/pair - .* status of 403")
        self.browser.run("document.querySelector('#code').value = ''")
        self.browser.type("#code", code)
        self.browser.press(ENTER)
        self.browser.until("return !document.querySelector('#pair').open", "paired")

    def turn_the_part(self):
        """By keyboard, by buttons, by dragging: each time the picture is another one."""
        seen = set()

        def shows(text):
            picture = self.browser.until(f"""const i = document.querySelector('#stage img');
                return document.querySelector('#turned').textContent === '{text}' && i && i.alt === '{text}' && i.naturalWidth === 200 && i.src""", text)
            seen.add(picture)

        shows("from the front")
        self.tab_to("#stage")
        self.browser.press(RIGHT, RIGHT)
        shows("turned by 45.0°")
        self.browser.click("#turn-left")
        shows("turned by 22.5°")
        self.browser.click("#turn-right")
        self.browser.click("#turn-right")
        shows("turned by 67.5°")
        self.browser.drag("#stage", -98)
        shows("turned by 337.5°")
        self.assertEqual(len(seen), 5)
        stage = self.browser.run("const s = document.querySelector('#stage'); return [s.role, s.ariaLabel, s.ariaValueText, s.ariaValueNow]")
        self.assertEqual(stage, ["slider", "Turn the part", "turned by 337.5°", "337.5"])

    def test_a_job_from_the_stick_to_the_finished_part(self):
        self.start("--fault", "stage.stalls@layer=40", plate=False, speedup=120, printer=self.page_board("network"))
        self.start_page("network")
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.until_state("plate in use")
        self.look("plate")
        # The first command pairs the browser.
        self.do("plate-empty")
        self.pair()
        self.until_state("idle")
        self.look("idle")
        archive = archive_of(self.dir / "made.zip", {"1.png": LAYER, "thumbnail/thumbnail400x400.png": rgb_png(400, 400, RED)})
        self.put_stick({"bust <b>1.ply": 2.0, "gear.ply": 3.0, "empty.xyz": b"", "part.sl1": archive})
        self.until_state("offered")
        names = browser.run("return [...document.querySelectorAll('#scans li')].map((e) => e.innerText.replace(/\\s+/g, ' '))")
        self.assertEqual(len(names), 4)
        self.assertIn("bust <b>1.ply", names[0])
        self.assertIn("the file is empty", names[1])
        # Another scan and its settings, by keyboard.
        # Pictures come one by one, and whoever is on a line stays there.
        line, image = "document.querySelector('#scans li:nth-child(3) button')", "document.querySelector('#scans li:nth-child(3) img')"
        browser.until(f"{line}.focus(); return document.activeElement === {line}", "the third line")
        browser.until(f"return !{image}.hidden && {image}.complete && {image}.naturalWidth === 64", "its picture")
        self.assertTrue(browser.run(f"return document.activeElement === {line}"), "the line was drawn anew")
        browser.run("document.activeElement.blur()")
        # An archive has its slicer's thumbnail, and of the settings only the profile.
        browser.until("const i = document.querySelector('#scans li:nth-child(4) img'); return !i.hidden && i.complete && i.naturalWidth === 64", "a thumbnail")
        shown = "[...document.querySelectorAll('#form select, #form input')].filter((e) => e.checkVisibility()).map((e) => e.id)"
        self.assertEqual(len(browser.run(f"return {shown}")), 6)
        browser.click("#scans li:nth-child(4) button")
        browser.until(f"return {shown}.join() === 'set-profile'", "the profile alone")
        self.look("archive")
        self.tab_to("#scans li:nth-child(3) button")
        browser.press(ENTER)
        browser.until("return document.querySelector('#scans li:nth-child(3) button').ariaPressed === 'true'", "the third scan")
        browser.until(f"return {shown}.length === 6", "all settings")
        self.tab_to("#set-height")
        browser.type("#set-height", "5")
        browser.press(TAB)
        browser.until("return document.activeElement.id === 'set-rotate_z_deg'", "the next setting")
        browser.type("#set-layer_height", "0.1\t")
        browser.until("return document.querySelector('#set-height').value === '5' && document.querySelector('#set-layer_height').value === '0.1'",
                      "the settings")
        self.look("offered")
        # The best ways up, with a picture of each; the second is taken.
        self.tab_to("#propose")
        browser.press(ENTER)
        browser.until("""const all = [...document.querySelectorAll('#proposals img')];
            return all.length === 5 && all.every((img) => img.naturalWidth === 160)""", "five ways up")
        ways = browser.run("return [...document.querySelectorAll('#proposals button')].map((b) => [b.ariaPressed, b.innerText])")
        self.assertEqual([pressed for pressed, _ in ways], ["true", "false", "false", "false", "false"])
        self.assertRegex(ways[2][1], r"^\s*No. 2\nVolume to support \d\.\d ml, \d\.\d cm²\nHeight \d\.\d mm\nLargest layer \d\.\d cm²$")
        self.tab_to("#proposals li:nth-child(3) button")
        browser.press(ENTER)
        browser.until("return document.querySelector('#proposals li:nth-child(3) button').ariaPressed === 'true'", "the second way up")
        # Its angle is one of the choices, in degrees like the others, and of that list only.
        for name, most in (("rotate_x_deg", 5), ("rotate_z_deg", 4)):
            choices = browser.run(f"return [...document.querySelectorAll('#set-{name} option')].map((option) => option.textContent)")
            self.assertTrue(all(choice.endswith("°") for choice in choices), choices)
            self.assertLessEqual(len(choices), most, choices)
        self.look("ways")
        self.tab_to("[data-do=start]")
        browser.press(ENTER)
        # What would be printed, layer by layer.
        self.until_state("offered", "!document.querySelector('#layers').hidden")
        loaded = "const m = document.querySelector('#mask'); return m.complete && m.naturalWidth > 0 && m.dataset.layer"
        first = browser.until(loaded, "a mask")
        self.tab_to("#layer")
        browser.press(RIGHT, RIGHT, RIGHT)
        browser.until(f"return document.querySelector('#mask').dataset.layer === '{int(first) + 3}'", "the mask of three layers above")
        self.assertRegex(browser.run("return document.querySelector('#which').textContent"), rf"^Layer {int(first) + 3} of \d+, \d\.\d0 mm$")
        browser.until("return document.querySelector('#picture-preview').naturalWidth === 320", "the preview")
        browser.until("return document.querySelector('#picture-coverage').naturalWidth > 300", "what was scanned")
        self.turn_the_part()
        self.look("sliced")
        self.do("start")
        self.until_state("printing")
        browser.until("const i = document.querySelector('#picture-layer'); return i && i.naturalWidth > 0", "the layer's picture")
        self.do("pause")
        self.until_state("paused")
        self.assertRegex(browser.run("return document.querySelector('#left').textContent"), r"^\d+ % · \d+ min left$")
        self.look("paused")
        # Whoever presses cancel is asked. Escape and the first button keep the print.
        for keep in (lambda: browser.press(ESCAPE), lambda: browser.press(ENTER)):
            self.do("cancel")
            browser.until("return document.querySelector('#ask').open", "the question")
            self.assertEqual(browser.run("return document.activeElement.textContent"), "Keep printing")
            keep()
            browser.until("return !document.querySelector('#ask').open", "the answer")
        self.do("cancel")
        self.look("cancel")
        browser.press(ESCAPE)
        self.do("resume")
        self.until_state("fault", "!document.querySelector('#fault').hidden")
        self.assertIn("PL-403", browser.run("return document.querySelector('#fault').innerText"))
        self.look("fault")
        self.do("seen")
        self.until_state("interrupted")
        self.look("interrupted")
        self.do("resume")
        # The stage stood elsewhere than the journal says, so the printer asks. Whoever goes on has measured the part.
        self.until_state("paused", "!document.querySelector('#question').hidden")
        # It names the printer's buttons. The page says which of its own those are.
        self.assertIn("start is “Resume”", browser.run("return document.querySelector('#answers').innerText"))
        self.look("question")
        self.do("resume")
        self.until_state("printing")
        self.look("printing")
        self.until_state("plate in use", "!document.querySelector('#report').hidden")
        self.assertIn("100", browser.run("return document.querySelector('#progress').textContent"))
        self.look("finished")
        report = browser.run("return fetch('/report.json').then((r) => r.json()).then((r) => [r.state, r.next_layer, r.layers])")
        self.assertEqual((report[0], report[1]), ("finished", report[2]))
        # The last prints, each with its picture and its report.
        self.browser.until("return [...document.querySelectorAll('#prints img')].some((e) => e.complete && e.naturalWidth > 0)", "a preview")
        reports = browser.run("""return Promise.all([...document.querySelectorAll('#prints a')].map((a) => fetch(a.href).then((r) => r.json())))
            .then((all) => all.map((r) => r.state))""")
        self.assertEqual((len(reports), reports[0]), (browser.run("return document.querySelectorAll('#prints li').length"), "finished"))
        # The part is off. What is on the stick is offered again.
        self.do("plate-empty")
        self.until_state("offered")
        # Nothing came from elsewhere.
        hosts = browser.run("return [...new Set(performance.getEntriesByType('resource').map((e) => new URL(e.name).host))]")
        self.assertEqual(hosts, [f"127.0.0.1:{self.port}"])

    def test_a_scan_is_uploaded_and_printed(self):
        self.start(speedup=200, printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.until_state("idle", "!document.querySelector('#upload').hidden")
        self.look("upload")
        # A name with letters that the printer does not take.
        scan = self.dir / "Büste <1>.ply"
        write_sphere(scan, points=5000, radius=2)
        browser.type("#file", str(scan))
        self.tab_to("#send button.main")
        browser.press(ENTER)
        self.until_state("offered", "!document.querySelector('#stick').hidden")
        self.assertEqual(browser.run("return document.querySelector('#title').textContent"), "Uploaded scan")
        self.assertIn("Buste _1_.ply", browser.run("return document.querySelector('#scans').innerText"))
        browser.until("return document.querySelector('#upload-status').textContent === 'Uploaded: Büste <1>.ply'", "what became of it")
        self.look("uploaded")
        # What the printer refuses is said, and what was uploaded before stays.
        for name, data, words in (("notes.doc", b"x", "not have the ending of a scan, mesh"), ("empty.ply", b"", "The file is empty")):
            (self.dir / name).write_bytes(data)
            browser.type("#file", str(self.dir / name))
            browser.click("#send button.main")
            browser.until(f"return document.querySelector('#upload-error').textContent.includes('{words}')", words)
        self.look("refused", "/upload - .* status of 409")
        self.do("start")
        self.until_state("offered", "!document.querySelector('#layers').hidden")
        self.do("start")
        self.until_state("printing", "document.querySelector('#upload').hidden")
        self.assertEqual(browser.run("return document.querySelector('#upload-error').textContent"), "", "what was wrong before is over")
        self.until_state("plate in use", "!document.querySelector('#report').hidden")
        self.do("plate-empty")
        self.until_state("offered", "document.querySelector('#title').textContent === 'Uploaded scan'")
        self.do("cancel")
        self.until_state("idle", "document.querySelector('[data-do=offer]').textContent === 'Show the uploaded scan'")
        # It is deleted by whoever says yes. Escape and the first button keep it.
        self.assertIn("Kept on the printer: Buste _1_.ply", browser.run("return document.querySelector('#stored').innerText"))
        self.look("kept")
        for keep in (lambda: browser.press(ESCAPE), lambda: browser.press(ENTER)):
            browser.click("#stored button")
            browser.until("return document.querySelector('#ask').open", "the question")
            self.assertEqual(browser.run("return document.activeElement.textContent"), "Keep it")
            keep()
            browser.until("return !document.querySelector('#ask').open", "the answer")
        browser.click("#stored button")
        browser.until("return document.querySelector('#ask').open", "the question")
        self.look("delete")
        browser.click("#ask button.danger")
        self.until_state("idle", "document.querySelector('#stored').hidden && !document.querySelector('[data-do=offer]')")
        self.assertEqual(list((self.folder / "uploads").iterdir()), [])

    def test_an_upload_is_stopped(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir, language="de")
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.until_state("idle", "!document.querySelector('#upload').hidden")
        # So slow a network that it can be looked at.
        browser.cdp("Network.enable")
        browser.cdp("Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=-1, uploadThroughput=20_000)
        (self.dir / "large.xyz").write_bytes(b"1 2 3\n" * 1_000_000)
        browser.type("#file", str(self.dir / "large.xyz"))
        browser.click("#send button.main")
        browser.until("return document.querySelector('#sent').value > 0 && !document.querySelector('#stop-upload').hidden", "progress")
        self.assertEqual(browser.run("return document.querySelector('#upload-status').textContent"), "Wird hochgeladen: large.xyz")
        self.look("hochladen")
        browser.click("#stop-upload")
        browser.until("return document.querySelector('#upload-error').textContent.startsWith('Das Hochladen wurde beendet')", "the end")
        browser.until("return !document.querySelector('#file').disabled", "the next one may come")
        self.assertEqual(list((self.folder / "uploads").iterdir()), [])

    def test_the_page_says_that_the_printer_is_gone_and_comes_back(self):
        daemon, _ = self.start(printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir, language="de")
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.until_state("idle")
        self.assertEqual(browser.run("return [document.documentElement.lang, document.querySelector('#title').textContent]"), ["de", "Bereit"])
        daemon.kill()
        browser.until("return !document.querySelector('#lost').hidden", "no printer")
        self.look("lost")
        self.start(printer=self.page_board("local"))
        browser.until("return document.querySelector('#lost').hidden", "the printer is back")
        # A local page needs no code.
        browser.until("return localStorage.getItem('token')", "paired")
        self.put_stick({"gear.ply": 3.0})
        self.until_state("offered")
        self.look("deutsch")
        self.do("cancel")
        self.until_state("idle")
        shutil.rmtree(self.stick)
        time.sleep(1)  # the printer looks for its simulated stick again and again
        self.put_stick({"hello.ply": b"hello"})
        self.until_state("offered")
        self.do("start")
        self.until_state("fault")
        browser.until("return document.querySelector('#fault-title').textContent === 'PL-102: Kein Scan'", "a fault in German")
        self.look("fehler")


if __name__ == "__main__":
    main()
