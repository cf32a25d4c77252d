"""What the site needs beyond Markdown: equations as MathML, and links that lead out of docs/ as names of files."""

import re
from pathlib import Path

from latex2mathml.converter import convert

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
CODE = re.compile(r"(```.*?```)", flags=re.DOTALL)


def out_of_docs(page, match):
    text, target = match[1], match[2]
    there = ((DOCS / page).parent / target.split("#")[0]).resolve()
    if there.is_relative_to(DOCS) or not there.exists():
        return match[0]  # left for the check of links
    name = f"`{there.relative_to(ROOT)}`"
    return name if text.strip("`") in name else f"{text} ({name})"


def typeset(page, text):
    text = re.sub(r"\$\$(.+?)\$\$", lambda m: "\n" + convert(m[1].strip(), display="block") + "\n", text, flags=re.DOTALL)
    # In a span, since Markdown takes what begins a line with <math> for a paragraph of its own.
    text = re.sub(r"\$`([^`]+)`\$", lambda m: f"<span>{convert(m[1])}</span>", text)
    return re.sub(r"\[([^\]]+)\]\((\.\.?/[^)]+)\)", lambda m: out_of_docs(page, m), text)


def on_page_markdown(markdown, page, **_):
    parts = CODE.split(markdown)
    return "".join(part if part.startswith("```") else typeset(page.file.src_uri, part) for part in parts)
