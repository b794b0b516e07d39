#!/usr/bin/env python3
"""The printer's page in a real browser: a job from the stick to the finished part, with a pause, a fault and a resume; what a screen reader
and a keyboard find; contrast; sizes from a phone's to a desktop's. PLUMBLINE_LOOK_AT=FOLDER keeps pictures of it."""

import os
import re
import shutil
import socket
import time
import unittest
from pathlib import Path

from case import box, main, write_sphere
from glances_test import LAYER, RED, archive_of, rgb_png
from sliced_test import png, square
from page_client import PagePrinter
from rgb_picture import rows_of
from state_client import same_age
from web_driver import CHROMIUM, DRIVER, ENTER, ESCAPE, HOME, RIGHT, TAB, Browser

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


# The light of what is in sight of a layer, in pixels of the mask.
LIGHT = "((now) => now.data.reduce((sum, value, i) => i % 4 ? sum : sum + value / 255, 0) * now.step * now.step)"


@unittest.skipUnless(CHROMIUM and DRIVER, "no chromium and chromium-driver")
class BrowserTest(PagePrinter):
    def look(self, name, expected="^$"):
        """What must hold whatever the page shows, in each size.
        @param expected  matches what the browser may complain about
        """
        for columns, rows, dark in ((320, 640, True), (390, 844, False), (1440, 900, True)):
            self.browser.size(columns, rows, dark)
            wide = self.browser.run("return [document.documentElement.scrollWidth, innerWidth]")
            self.assertLessEqual(wide[0], wide[1], f"{name} is wider than a screen of {columns} pixels")
            seen, bad = self.browser.run(CONTRAST)
            self.assertGreater(seen, 3)
            self.assertEqual(bad, [], f"contrast of {name}")
            small = self.browser.run("""return [...document.querySelectorAll('button, select, input')]
                .map((e) => e.type === 'checkbox' ? e.closest('label') : e)
                .filter((e) => e.checkVisibility() && e.getBoundingClientRect().height < 44).map((e) => e.outerHTML)""")
            self.assertEqual(small, [], "too small for a finger")
            # Regression: a scan without a picture showed a broken one.
            unhidden = self.browser.run("return [...document.querySelectorAll('[hidden]')].filter((e) => e.checkVisibility()).map((e) => e.outerHTML)")
            self.assertEqual(unhidden, [], "a style shows what is hidden")
            if folder := os.environ.get("PLUMBLINE_LOOK_AT"):
                (Path(folder) / f"page-{name}-{columns}.png").write_bytes(self.browser.picture())
        part = "dialog[open]" if self.browser.run("return Boolean(document.querySelector('dialog[open]'))") else "body"
        unnamed = self.browser.unnamed(f"{part} :is(button, select, input, img, progress, a){SHOWN}")
        self.assertEqual(unnamed, [], f"{name} has parts without a name")
        self.assertEqual([text for text in self.browser.messages() if not re.search(expected, text)], [])

    def until_state(self, state, more="true"):
        self.browser.until(f"return document.body.dataset.state === '{state}' && ({more})", state)

    def do(self, command):
        # In the first second after a question its buttons take no click.
        self.browser.until(f"return document.querySelector('[data-do={command}]:not([aria-disabled=true])')", command)
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
        """By keyboard, by buttons, by dragging: each time it is seen from another side."""
        browser, seen = self.browser, set()

        def look():
            time.sleep(0.2)
            browser.until("return view.frames > 0 && document.querySelector('#loading').hidden", "the part")
            seen.add(browser.shot("#view"))

        look()
        self.tab_to("#view")
        browser.press(RIGHT, RIGHT)
        look()
        browser.press("+")
        look()
        browser.click("#from-above")
        look()
        browser.drag("#view", -98)
        look()
        browser.run("document.querySelector('#layer').value = 20; document.querySelector('#layer').oninput()")
        look()
        self.assertEqual(len(seen), 6)

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
        self.assertEqual(len(browser.run(f"return {shown}")), 10)
        browser.click("#scans li:nth-child(4) button")
        browser.until(f"return {shown}.join() === 'set-profile'", "the profile alone")
        self.look("archive")
        self.tab_to("#scans li:nth-child(3) button")
        browser.press(ENTER)
        browser.until("return document.querySelector('#scans li:nth-child(3) button').ariaPressed === 'true'", "the third scan")
        browser.until(f"return {shown}.length === 10", "all settings")
        self.tab_to("#set-height")
        browser.type("#set-height", "5")
        browser.press(TAB)
        browser.until("return document.activeElement.id === 'set-units'", "the next setting")
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
        # Its angles stand in the fields.
        degrees = browser.run("return ['x', 'y', 'z'].map((axis) => Number(document.querySelector(`#set-rotate_${axis}_deg`).value))")
        self.assertEqual(degrees[:2], browser.run("return [state.job.rotate_x_deg, state.job.rotate_y_deg]"))
        self.look("ways")
        browser.until("return document.querySelector('[data-do=start]:not([aria-disabled=true])')", "the button")
        self.tab_to("[data-do=start]")
        browser.press(ENTER)
        # What would be printed, layer by layer.
        self.until_state("offered", "!document.querySelector('#layers').hidden")
        first = 1 + browser.until("return layerView.now().layer", "a mask")
        self.tab_to("#layer")
        browser.press(RIGHT, RIGHT, RIGHT)
        browser.until(f"return layerView.now().layer === {first + 2}", "the mask of three layers above")
        # As near as single pixels, by keyboard.
        self.tab_to("#mask")
        browser.press(*"++++++++++++")
        self.assertGreater(browser.until(f"const now = layerView.now(); return now.step === 1 && now.scale > 2 && {LIGHT}(now)", "single pixels"), 0)
        browser.press(HOME)
        self.assertRegex(browser.run("return document.querySelector('#which').textContent"), rf"^Layer {first + 3} of \d+, \d\.\d0 mm$")
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
        # Once more, whatever has been chosen since.
        browser.click("#scans li:nth-child(1) button")
        browser.until("return state.job.number === 1", "another scan")
        browser.until("return !document.querySelector('#prints button').hidden", "the last prints")
        printed = browser.run("return document.querySelector('#prints button').dataset.scan")
        browser.click("#prints button")
        browser.until(f"return state.job.scan === '{printed}' && state.job.number === 3", "the scan that was printed")
        # Nothing came from elsewhere.
        hosts = browser.run("return [...new Set(performance.getEntriesByType('resource').map((e) => new URL(e.name).host))]")
        self.assertEqual(hosts, [f"127.0.0.1:{self.port}"])

    def silhouette(self, layers):
        """@returns for each layer of what is offered the columns of the panel in which something is lit"""
        lit = []
        for n in range(layers):
            _, rows = rows_of(self.get(f"/mask?n={n}&x=400&y=960&step=1"))
            lit.append({400 + x for row in rows if any(row) for x in range(len(row) // 3) if row[3 * x]})
        return lit

    def test_the_part_in_3d_is_that_of_the_masks(self):
        """Its outline from the front is that of all masks together, to a pixel."""
        boxes = [((0, 0, 0), (8, 6, 1.5)), ((0.5, 2, 1), (2.5, 4, 8)), ((2, 2.5, 6), (7, 3.5, 7.2)), ((5.5, 2.5, 1), (6.1, 3.1, 6.5))]
        (self.dir / "arch.stl").write_text("solid arch\n" + "".join(box(*one) for one in boxes) + "endsolid arch\n")
        _, user = self.start(printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir)
        browser.size(1440, 900)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.stick.mkdir()
        (self.dir / "arch.stl").rename(self.stick / "arch.stl")
        user.state("offered", "start")
        user.do("set", key="supports", value="none")
        user.do("start")
        sliced = user.until(lambda s: s["state"] == "offered" and s["masks"] and s["commands"], "sliced")["sliced"]
        lit = self.silhouette(sliced["layers"])
        browser.until("return view.frames > 0 && !document.querySelector('#part').hidden && document.querySelector('#loading').hidden", "the part")
        browser.click("#from-front")
        time.sleep(0.5)
        columns, rows = rows_of(browser.shot("#view"))
        size = len(rows[0]) // columns
        seen = [[max(row[size * x : size * x + 3]) > 45 for x in range(columns)] for row in rows]
        pitch, high = sliced["mask_pixel_mm"][0], sliced["layer_height_mm"]
        (left, bottom), (right, top) = browser.run("return [view.placeOf([0, 0, 0]), view.placeOf([10, 0, 10])]")

        def is_lit(u, v):
            layer, column = int((v + 0.5 - bottom) / (top - bottom) * 10 / high // 1), int((u + 0.5 - left) / (right - left) * 10 / pitch // 1)
            return 0 <= layer < len(lit) and column in lit[layer]

        expected = [[is_lit(u, v) for u in range(len(seen[0]))] for v in range(len(seen))]

        def edges(image):
            return {(u, v) for v in range(1, len(image) - 1) for u in range(1, len(image[0]) - 1)
                    if image[v][u] and not (image[v - 1][u] and image[v + 1][u] and image[v][u - 1] and image[v][u + 1])}

        drawn, true = edges(seen), edges(expected)
        self.assertGreater(len(true), 1000)
        for some, others in ((drawn, true), (true, drawn)):
            near = sum(any((u + a, v + b) in others for a in (-1, 0, 1) for b in (-1, 0, 1)) for u, v in some)
            self.assertGreater(near / len(some), 0.95)

    def test_a_finding_is_mended_by_its_button(self):
        # A ball that hangs over its own foot, and nobody wants supports.
        _, user = self.start(printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir, language="de")
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.put_stick({"ball.ply": 3.0})
        user.state("offered", "start")
        user.do("set", key="supports", value="none")
        self.do("start")
        self.until_state("offered", "state.masks && document.querySelectorAll('#findings li button').length > 1")
        self.look("befund")
        # Where it is: the layer, and its mark in 3D.
        before = browser.run("return document.querySelector('#layer').value")
        browser.click("#findings li button:not([data-key])")
        browser.until(f"return document.querySelector('#layer').value !== '{before}'", "its layer")
        browser.until("return layerView.now().scale >= 2", "from near")
        # Somebody else looks, too.
        (self.dir / "other").mkdir()
        other = Browser(self, self.dir / "other")
        other.open(f"http://127.0.0.1:{self.port}/")
        other.until("return document.querySelectorAll('#findings li button').length > 1", "the same findings")
        job = browser.run("return jobId()")
        self.tab_to("#findings li button[data-key=supports]")
        self.assertEqual(browser.run("return document.activeElement.textContent"), "Stützen hinzufügen")
        browser.press(ENTER)
        browser.until(f"return state.state === 'offered' && state.masks && jobId() !== '{job}' && state.job.supports === 'auto'", "sliced again")
        browser.until("return !document.querySelector('#findings [data-key=supports]')", "it is mended")
        other.until("return state.masks && !document.querySelector('#findings [data-key=supports]')", "the other one sees it")
        # Back to the settings, where the supports are as the button has made them; and the usual ones again.
        self.do("settings")
        self.until_state("offered", "!document.querySelector('#settings').hidden && document.querySelector('#set-supports').value === 'auto'")
        browser.click("#reset")
        browser.until("return document.querySelector('#set-supports').value === ''", "the usual settings")
        self.look("einstellungen")

    def test_what_is_too_large_is_fitted_by_one_press(self):
        _, user = self.start(printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.put_stick({"globe.ply": 120.0})
        self.until_state("offered")
        self.do("start")
        self.until_state("fault", "!document.querySelector('#fault-mend').hidden")
        self.assertNotIn("job.toml", browser.run("return document.querySelector('#fault').innerText"))
        self.look("too-large")
        browser.click("#fault-mend button")
        sliced = user.until(lambda s: s["state"] == "offered" and s["sliced"] and s["masks"], "sliced")
        self.assertTrue(sliced["job"]["fit"])
        self.assertLess(sliced["sliced"]["width_mm"], 70)

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

    def test_browsers_wait_for_their_code_and_are_forgotten(self):
        self.start(plate=False, printer=self.page_board("network"))
        self.start_page("network")
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.until_state("plate in use")
        self.assertTrue(browser.run("return document.querySelector('#browsers').hidden"))
        # Another one has a code, and then wants it no more.
        self.post("/pair", {"ask": "phone"}, come_from="127.0.0.2")
        self.do("plate-empty")
        browser.until("return document.querySelector('#pair-error').textContent.startsWith('another browser is being paired')", "the wait")
        self.look("pair-wait", "/pair - .* status of 429")
        self.post("/pair", {"ask": "phone", "stop": True}, come_from="127.0.0.2")
        browser.until("return document.querySelector('#pair-error').hidden", "its turn")
        browser.messages()
        self.pair()
        self.until_state("idle", "!document.querySelector('#browsers').hidden")
        listed = browser.run("return document.querySelector('#browsers li').innerText")
        self.assertRegex(listed, r"^Chrome, Linux 1 \(this browser\)\npaired \d\d/\d\d/\d{4}, ")
        self.look("browsers")
        browser.click("#browsers button")
        browser.until("return document.querySelector('#ask').open", "the question")
        self.look("forget")
        browser.click("#ask button.danger")
        browser.until("return document.querySelector('#browsers').hidden", "forgotten")
        token = browser.run("return localStorage.getItem('token')")
        self.post("/command", {"do": "offer"}, status=401, headers={"Plumbline-Token": token})

    def click_twice(self, command, gap):
        """One finger, in one place, as fast as people are."""
        box = self.browser.run(f"const b = document.querySelector('[data-do={command}]').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]")
        at = {"x": int(box[0] + min(box[2], 60) / 2), "y": int(box[1] + box[3] / 2)}
        click = [{"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}]
        actions = [{"type": "pointerMove", **at}, *click, {"type": "pause", "duration": gap}, *click]
        self.browser.call("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]})

    def test_the_second_of_two_clicks_answers_no_other_question(self):
        self.start(speedup=200, printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.put_stick({"a.sl1": archive_of(self.dir / "a.zip", {"part1.png": square(100), "part2.png": square(100)})})
        for gap in (200, 400, 800):
            self.until_state("offered")
            browser.until("return document.querySelector('[data-do=start]:not([aria-disabled=true])')", "the button")
            self.click_twice("start", gap)
            self.until_state("offered", "!document.querySelector('#layers').hidden")
            time.sleep(1)
            self.assertEqual(browser.run("return document.body.dataset.state"), "offered", "nobody has confirmed the preview")
            self.do("start")
            self.until_state("plate in use")
            browser.until("return document.querySelector('[data-do=plate-empty]:not([aria-disabled=true])')", "the button")
            self.click_twice("plate-empty", gap)
            self.until_state("offered")
            time.sleep(1)
            self.assertEqual(browser.run("return [document.body.dataset.state, document.querySelector('#layers').hidden]"), ["offered", True],
                             "nobody has started it again")

    def test_a_question_that_was_left_open_and_what_another_job_showed_are_gone(self):
        layer = {n: png(1440, 2560, b"".join(b"\0" + bytes([255 * (400 <= x < 400 + n and 400 <= y < 400 + n) for x in range(1440)]) for y in range(2560)))
                 for n in (200, 500)}
        daemon, user = self.start(speedup=20, printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        self.put_stick({f"{name}.sl1": archive_of(self.dir / "a.zip", {f"p{k:02}.png": layer[n] for k in range(20)}) for name, n in (("A", 200), ("B", 500))})

        def slice_scan(number):
            offered = user.until(lambda s: s["state"] == "offered" and not s["sliced"] and s["commands"], "offered")
            if offered["job"]["number"] != number:  # else the question would be another one than that of the state at hand
                user.do("choose", scan=number)
            asked = user.until(lambda s: s["job"]["number"] == number, f"scan {number}")
            user.do("start", **{"for": asked["asks"]})
            return user.until(lambda s: s["state"] == "offered" and s["masks"] and s["commands"], "sliced")

        shown = f"return {LIGHT}(layerView.now())"
        slice_scan(1)
        a = browser.until(shown, "A's mask")
        # Slider and picture numbers are the same for B after a restart.
        daemon.kill()
        daemon.wait()
        daemon, user = self.start(speedup=20, plate=False, printer=self.page_board("local"))
        sliced = slice_scan(2)
        browser.until(f"return jobId() === '{sliced['job']['id']}'", "B's job")
        b = browser.until(shown, "B's mask")
        self.assertGreater(b, 3 * a, "a square of 200 pixels is not shown for one of 500")
        # "Cancel the print?", left open until the print is over.
        user.do("start", **{"for": sliced["asks"]})
        self.until_state("printing")
        self.do("cancel")
        browser.until("return document.querySelector('#ask').open", "the question")
        user.do("cancel")
        browser.until("return !document.querySelector('#ask').open", "it closes by itself")
        self.assertIn("is over", browser.run("return document.querySelector('#notice').textContent"))

    def test_the_eleventh_page_says_that_it_looks_now_and_then(self):
        self.start(printer=self.page_board("local"))
        self.start_page()
        streams = [socket.create_connection(("127.0.0.1", self.port), 30) for _ in range(10)]
        for stream in streams:
            self.addCleanup(stream.close)
            stream.sendall(f"GET /events HTTP/1.1\r\nHost: localhost:{self.port}\r\n\r\n".encode())
            self.assertIn(b" 200 ", stream.recv(100))
        self.browser = browser = Browser(self, self.dir)
        browser.open(f"http://127.0.0.1:{self.port}/")
        browser.until("return !document.querySelector('#crowded').hidden && document.querySelector('#crowded').textContent.includes('two seconds')", "the reason")
        self.until_state("idle", "document.querySelector('#lost').hidden")
        self.put_stick({"hello.ply": b"hello"})
        self.until_state("offered")
        self.look("crowded", "503")
        for stream in streams:
            stream.close()
        browser.until("return document.querySelector('#crowded').hidden", "there is room again")

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

    def test_folders_are_opened_and_what_is_not_listed_is_said_with_its_number(self):
        new = self.dir / "new"
        for path in ["bust.stl", *(f"B\u00fcsten/teil{i:02}.stl" for i in range(70))]:
            (new / path).parent.mkdir(parents=True, exist_ok=True)
            (new / path).write_bytes(b"solid")
        same_age(new)
        self.start(printer=self.page_board("local"))
        self.start_page()
        self.browser = browser = Browser(self, self.dir, language="de")
        browser.open(f"http://127.0.0.1:{self.port}/")
        new.rename(self.stick)
        self.until_state("offered", "document.querySelectorAll('#scans li').length === 16")
        folders = "return [...document.querySelectorAll('#folders button')].map((b) => [...b.children].map((c) => c.textContent).join(' '))"
        self.assertEqual(browser.run(folders), ["B\u00fcsten/ 70 darin"])
        self.assertTrue(browser.run("return document.querySelector('#left-out').hidden"))
        browser.click("#folders button")
        self.until_state("offered", "document.querySelectorAll('#scans li').length === 64")
        self.assertEqual(browser.run(folders), ["Eine Ebene h\u00f6her "])
        self.assertEqual(browser.run("return ['#stick h2', '#left-out', '#scans span'].map((s) => document.querySelector(s).textContent)"),
                         ["Auf dem Stick: B\u00fcsten", "Nicht gezeigt \u00b7 6 Dateien", "teil00.stl"])
        self.look("ordner")
        browser.click("#folders button")
        self.until_state("offered", "document.querySelectorAll('#scans li').length === 16")


if __name__ == "__main__":
    main()
