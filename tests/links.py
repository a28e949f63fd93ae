"""Dead links in Markdown files or in a folder of HTML: files that are missing, and headings that do not exist.

usage: links.py FILE.md...        links between Markdown files, with headings named as GitHub names them
       links.py --html FOLDER     links between the pages of a site

Prints one line for each dead link; exit status 1 if there is any. Addresses on the network are not visited.
"""
import html.parser
import os
import re
import sys
from urllib.parse import unquote, urlsplit


def without_code(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    return re.sub(r"`[^`\n]*`", lambda code: "`" + " " * (len(code.group()) - 2) + "`", text)


def github_anchors(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    found, count = set(), {}
    for heading in re.findall(r"^#+ (.*)$", text, flags=re.M):
        heading = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
        found.add(name if name not in count else f"{name}-{count[name]}")
        count[name] = count.get(name, 0) + 1
    return found | set(re.findall(r'<a (?:id|name)="([^"]*)"', text))


def markdown_page(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    plain = without_code(text)
    links = re.findall(r"\]\(([^)\s]+)\)", plain) + re.findall(r'(?:src|href)="([^"]*)"', plain)
    return links, github_anchors(text)


class HtmlPage(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.links, self.anchors = [], set()

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            elif name in ("id", "name") and value:
                self.anchors.add(value)


def html_page(path):
    page = HtmlPage()
    with open(path, encoding="utf-8", errors="replace") as file:
        page.feed(file.read())
    return page.links, page.anchors


def dead_links(paths, read, suffix):
    pages = {}

    def page(path):
        if path not in pages:
            pages[path] = read(path)
        return pages[path]

    for path in paths:
        for link in page(path)[0]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = os.path.normpath(os.path.join(os.path.dirname(path), unquote(parts.path))) if parts.path else path
            if not os.path.exists(target):
                yield f"{path}: {link}: there is no such file"
            elif parts.fragment and target.endswith(suffix) and unquote(parts.fragment) not in page(target)[1]:
                yield f"{path}: {link}: there is no such heading"


def main(arguments):
    if arguments[:1] == ["--html"]:
        paths = [os.path.join(folder, name) for folder, _, names in os.walk(arguments[1]) for name in names]
        dead = list(dead_links(sorted(p for p in paths if p.endswith(".html")), html_page, ".html"))
    else:
        dead = list(dead_links(arguments, markdown_page, ".md"))
    print("\n".join(dead), end="\n" if dead else "")
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
