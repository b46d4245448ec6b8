"""What both reports' tests ask of a page: its own text without plotly, its tags."""

import re
from html.parser import HTMLParser


def own(page: str) -> str:
    """The page without plotly's own code."""
    return re.sub(r"<script>/\*\*.*?</script>", "", page, count=1, flags=re.DOTALL)


class Tags(HTMLParser):
    VOID = ("meta", "link", "br", "img")

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.loads = [], [], []

    def handle_starttag(self, tag, attrs):
        told = dict(attrs)
        self.ids += [told["id"]] if "id" in told else []
        self.loads += [
            told[k]
            for k in ("src", "href")
            if k in told and not told[k].startswith(("#", "data:"))
        ]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
