"""Looks at a page in headless Chromium as people do: desktop and phone, light and dark, on paper.

    look.py PAGE... -o FOLDER

A screenshot of each into FOLDER, and an error (exit 1) for each of: a message on the console, a request to anywhere, an
image that is not there, a page that scrolls sideways, a finding of axe-core (WCAG 2 A and AA, best practices).
"""

import argparse
import base64
import importlib.metadata
import itertools
import json
import sys
from pathlib import Path

from selenium import webdriver

WIDTHS = {"desktop": 1280, "phone": 390}
SCHEMES = ["light", "dark"]
HEIGHT = 900


def browser():
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    # As root there is no sandbox, and what is opened is ours.
    for option in ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]:
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.ChromeService("/usr/bin/chromedriver"))


def axe():
    """The text of axe-core, without the package around it."""
    [script] = [f for f in importlib.metadata.files("axe-playwright-python") if f.name == "axe.min.js"]
    return script.read_text()


def emulate(driver, width, scheme, media=""):
    metrics = {"width": width, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": width < 600}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media, "features": features})


def shot(driver, path):
    taken = driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "captureBeyondViewport": True})
    path.write_bytes(base64.b64decode(taken["data"]))


def faults(driver):
    """What is wrong with the page as it stands."""
    layout = driver.execute_script(
        "return {wide: document.documentElement.scrollWidth - document.documentElement.clientWidth,"
        " missing: [...document.images].filter(x => !x.complete || !x.naturalWidth).map(x => x.src),"
        " empty: [...document.querySelectorAll('figure')].filter(x => !x.querySelector('svg path, svg polyline, svg line')).length}"
    )
    if layout["wide"] > 0:
        yield f"scrolls sideways by {layout['wide']} pixels"
    yield from (f"image is missing: {source}" for source in layout["missing"])
    if layout["empty"]:
        yield f"{layout['empty']} figures are empty"
    found = driver.execute_async_script("const done = arguments[0]; axe.run(document).then(done, e => done({error: String(e)}))")
    if "error" in found:
        yield f"axe-core: {found['error']}"
    for violation in found.get("violations", []):
        where = "; ".join(node["html"][:120] for node in violation["nodes"][:3])
        yield f"axe-core: {violation['id']}: {violation['help']} ({len(violation['nodes'])}): {where}"


def requests(driver, page):
    """What the page asked for beside itself."""
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            if url.split("#")[0] != page.as_uri() and not url.startswith("data:"):
                yield f"asks for {url}"


def look(driver, page, folder):
    name = page.parent.name + "-" + page.stem
    for (device, width), scheme in itertools.product(WIDTHS.items(), SCHEMES):
        emulate(driver, width, scheme)
        driver.get(page.as_uri())
        shot(driver, folder / f"{name}-{device}-{scheme}.png")
        driver.execute_script(axe())
        yield from (f"{device}, {scheme}: {fault}" for fault in faults(driver))
    emulate(driver, 1000, "light", "print")
    driver.get(page.as_uri())
    shot(driver, folder / f"{name}-print.png")
    yield from requests(driver, page)
    yield from (f"console: {entry['message']}" for entry in driver.get_log("browser"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+", type=Path, metavar="PAGE")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    driver = browser()
    wrong = 0
    try:
        for page in arguments.pages:
            found = list(look(driver, page.resolve(), arguments.output))
            wrong += len(found)
            print(f"{page}: {len(found) or 'no'} faults", *found, sep="\n  ")
    finally:
        driver.quit()
    print(f"screenshots in {arguments.output}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
