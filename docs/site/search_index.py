"""Writes the search index of the site: every section of every page, as a script, so that search works without a server.

usage: search_index.py FOLDER    writes FOLDER/search/index.js
"""
import html.parser
import json
import os
import sys


class Sections(html.parser.HTMLParser):
    """Cuts a page at its headings; what is outside the article is skipped."""

    def __init__(self, page):
        super().__init__()
        self.page, self.page_title, self.sections = page, None, []
        self.depth, self.heading = 0, False

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if attributes.get("itemprop") == "articleBody":
            self.depth = 1
        elif self.depth and tag == "div":
            self.depth += 1
        if self.depth and tag in ("h1", "h2", "h3") and "id" in attributes:
            self.sections.append({"address": f"{self.page}#{attributes['id']}", "title": "", "text": ""})
            self.heading = True

    def handle_endtag(self, tag):
        if self.depth and tag == "div":
            self.depth -= 1
        if self.heading and tag in ("h1", "h2", "h3"):
            self.heading = False
            section = self.sections[-1]
            section["title"] = section["title"].strip()
            if self.page_title is None:
                self.page_title = section["title"]
            else:
                section["title"] = f"{self.page_title}: {section['title']}"

    def handle_data(self, data):
        if self.depth and self.sections:
            self.sections[-1]["title" if self.heading else "text"] += data


def main(folder):
    found = []
    for place, _, names in sorted(os.walk(folder)):
        for name in sorted(names):
            path = os.path.join(place, name)
            page = os.path.relpath(path, folder)
            if not name.endswith(".html") or page.startswith("reference" + os.sep):
                continue
            sections = Sections(page)
            with open(path, encoding="utf-8") as file:
                sections.feed(file.read())
            found += sections.sections
    for section in found:
        section["text"] = " ".join(section["text"].lower().split())
    os.makedirs(os.path.join(folder, "search"), exist_ok=True)
    with open(os.path.join(folder, "search", "index.js"), "w", encoding="utf-8") as file:
        file.write("var searchIndex = " + json.dumps(found, ensure_ascii=False) + ";\n")


if __name__ == "__main__":
    main(sys.argv[1])
