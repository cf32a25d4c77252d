"""Checks the built site: every link and picture is there, nothing is loaded from the network; and README's links."""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).parents[2]


class Page(HTMLParser):
    """Targets of a page's links, what it loads, and its anchors."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.anchors = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        self.anchors |= {of[name] for name in ("id", "name") if of.get(name)}
        if tag == "a" and of.get("href"):
            self.links.append(of["href"])
        elif tag in ("script", "img", "iframe") and of.get("src"):
            self.loaded.append(of["src"])
        elif tag == "link" and of.get("href") and of.get("rel") != "canonical":
            self.loaded.append(of["href"])


def main():
    site = Path(sys.argv[1]).resolve()
    pages = {path: Page(path) for path in site.rglob("*.html")}
    wrong, links = [], 0
    for path, page in pages.items():
        at = path.relative_to(site)
        wrong += [f"{at}: loads {of}" for of in page.loaded if urlsplit(of).netloc]
        for link in [*page.links, *page.loaded]:
            to = urlsplit(link)
            if to.scheme or to.netloc or (path.name == "404.html" and link.startswith("/")):
                continue
            links += 1
            there = (path.parent / unquote(to.path)).resolve() if to.path else path
            if not there.exists():
                wrong.append(f"{at}: {link} is not there")
            elif to.fragment and there in pages and unquote(to.fragment) not in pages[there].anchors:
                wrong.append(f"{at}: {link} has no such anchor")
    for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"):
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", (ROOT / name).read_text(encoding="utf-8")):
            links += 1
            if not (ROOT / target).exists():
                wrong.append(f"{name}: {target} is not there")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"docs: {len(pages)} pages, {links} links")


if __name__ == "__main__":
    main()
