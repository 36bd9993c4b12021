"""A Markdown file: its fenced blocks, the text between them, and what of it is excepted."""
import dataclasses
import re

_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)


@dataclasses.dataclass(frozen=True)
class Block:
    language: str
    body: str
    begin: int  # of the body, in the document
    end: int
    before: str  # the paragraph in front of the block
    line: int  # of the body's first line


def blocks(text):
    found, last = [], 0
    for match in _FENCE.finditer(text):
        paragraphs = text[last : match.start()].strip().split("\n\n")
        line = text.count("\n", 0, match.start(2)) + 1
        found.append(Block(match[1], match[2], match.start(2), match.end(2), paragraphs[-1], line))
        last = match.end()
    return found


def section(text, title):
    """Begin and end of `## title`; an empty range where there is none."""
    match = re.search(rf"^## {re.escape(title)}\n.*?(?=^## |\Z)", text, re.M | re.S)
    return match.span() if match else (0, 0)


def line_of(text, place):
    return text.count("\n", 0, place) + 1
